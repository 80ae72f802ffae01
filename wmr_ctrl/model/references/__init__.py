"""Desired trajectories as CasADi expressions of time, one file a kind.

Each gives position, orientation, velocities and the velocities' rates, in the order of
``signals.REFERENCE``, such that q_d' = H(theta_d) v_d, Eqs. (4)-(5).
"""

from __future__ import annotations

from wmr_ctrl.model.references.evaluate import function_of as function_of
from wmr_ctrl.model.references.evaluate import reference_bounds as reference_bounds
from wmr_ctrl.model.references.evaluate import sample as sample
from wmr_ctrl.model.references.kinds import Parameters as Parameters
from wmr_ctrl.model.references.registry import Trajectory as Trajectory
from wmr_ctrl.model.references.registry import trajectory_of as trajectory_of
