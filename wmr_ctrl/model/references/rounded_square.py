"""Square with smoothed corners, as a closed spline path."""

from __future__ import annotations

from wmr_ctrl.model.references.kinds import Parameters
from wmr_ctrl.model.references.spline import path_parameters
from wmr_ctrl.model.references.spline import trajectory as trajectory
from wmr_ctrl.scenario.paths import path_of
from wmr_ctrl.scenario.reference import RoundedSquare


def parameters(reference: RoundedSquare) -> Parameters:
    """Return the table of the square's path (see ``spline.path_parameters``)."""
    return path_parameters(path_of(reference))
