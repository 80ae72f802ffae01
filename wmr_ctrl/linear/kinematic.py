"""The kinematic loop by itself: what is left when the velocity follows v_c0 at once, Eq. (7).

It has two resting points on a circle or a line: e = 0, and e = (0, 0, pi), a saddle, where the
robot rides along the reference backwards-facing and the law does nothing about it.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from wmr_ctrl.control.setup import kinematic_gains
from wmr_ctrl.linear.linearise import V_D, Floats, linearise
from wmr_ctrl.linear.point import reference_velocity
from wmr_ctrl.model.kinematics import auxiliary_velocity, error_rate
from wmr_ctrl.model.system import Output, System, port
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import TRACKING_ERROR

SADDLE = (0.0, 0.0, np.pi)
"""The other resting point of the kinematic loop."""


def kinematic_loop(scenario: Scenario) -> System:
    """Continuous System e' of Eqs. (33)-(35) with v = v_c0."""
    e, v_d = port(TRACKING_ERROR), port(V_D)
    v = auxiliary_velocity(e.sym, v_d.sym, ca.SX(ca.DM(kinematic_gains(scenario).k)))
    rate, outputs = error_rate(e.sym, v, v_d.sym), (Output(TRACKING_ERROR, e.sym),)
    name, title = "kinematics", "kinematic loop"
    return System(name, title, inputs=(v_d,), state=(e,), update=rate, outputs=outputs)


def kinematic_poles(scenario: Scenario, e: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Floats:
    """Eigenvalues [1/s] near error ``e`` [m, m, rad], v_d that of the reference at t = 0.

    The slowest is last at e = 0 with the paper's gains.
    """
    near = linearise(kinematic_loop(scenario), reference_velocity(scenario, 0.0)[0], e)
    poles = np.asarray(near.poles(), dtype=complex)
    return poles[np.argsort(poles.real)]
