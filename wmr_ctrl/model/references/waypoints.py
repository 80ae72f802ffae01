"""Smooth path through given points, open or closed, as a spline path."""

from __future__ import annotations

from wmr_ctrl.model.references.kinds import Parameters
from wmr_ctrl.model.references.spline import path_parameters
from wmr_ctrl.model.references.spline import trajectory as trajectory
from wmr_ctrl.scenario.paths import path_of
from wmr_ctrl.scenario.reference import Waypoints


def parameters(reference: Waypoints) -> Parameters:
    """Return the table of the path through the points (see ``spline.path_parameters``)."""
    return path_parameters(path_of(reference))
