"""Where a run starts, seen from its reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.control.setup import Setup
from wmr_ctrl.model.auxiliary import auxiliary_velocity
from wmr_ctrl.model.tracking import tracking_error
from wmr_ctrl.world.references import sample

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class StartPoint:
    """Reference (7) at t = 0, tracking error e (3) [m, m, rad], v and v_c0 (2) [m/s, rad/s]."""

    reference: Floats
    e: Floats
    v: Floats
    v_c0: Floats


def start_point(setup: Setup) -> StartPoint:
    """The scenario at t = 0: Eqs. (8) and (7) there."""
    scenario = setup.scenario
    reference = sample(scenario, np.zeros(1))[0]
    e = tracking_error(_sx(reference[:3]), _sx(scenario.initial.pose))
    v_c0 = auxiliary_velocity(e, _sx(reference[3:5]), _sx(setup.kinematics.k))
    return StartPoint(reference, _flat(e), np.array(scenario.initial.velocity), _flat(v_c0))


def _sx(numbers: Any) -> ca.SX:
    return ca.SX(ca.DM(numbers))


def _flat(column: ca.SX) -> Floats:
    return np.asarray(ca.evalf(column)).ravel()
