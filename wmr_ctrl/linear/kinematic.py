"""The kinematic loop by itself: what is left when the velocity follows v_c0 at once, Eq. (7).

It has two resting points on a circle or a line: e = 0, and e = (0, 0, pi), a saddle, where the
robot rides along the reference backwards-facing and the law does nothing about it.
"""

from __future__ import annotations

import casadi as ca
import control as ct
import numpy as np

from wmr_ctrl.barrier.stable import stable_minimiser
from wmr_ctrl.control.gains import kinematic_gains
from wmr_ctrl.linear.linearise import linearise
from wmr_ctrl.linear.names import V_D
from wmr_ctrl.linear.numbers import Floats
from wmr_ctrl.linear.point import reference_velocity
from wmr_ctrl.model.auxiliary import auxiliary_velocity
from wmr_ctrl.model.system import Output, System, port
from wmr_ctrl.model.tracking import error_rate
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import TRACKING_ERROR

SADDLE = (0.0, 0.0, np.pi)
"""The other resting point of the kinematic loop."""


def kinematic_loop(scenario: Scenario, saturated: bool = False) -> System:
    """Continuous System e' of Eqs. (33)-(35) with v = v_c0, or v = v_c1 where ``saturated``."""
    e, v_d = port(TRACKING_ERROR), port(V_D)
    v = auxiliary_velocity(e.sym, v_d.sym, ca.SX(ca.DM(kinematic_gains(scenario).k)))
    if saturated:
        limits = scenario.limits
        v = ca.vertcat(
            *(
                stable_minimiser(v[i], ca.SX(limits.v_u1[i]), ca.SX(limits.v_u2[i]))
                for i in range(2)
            )
        )
    rate = error_rate(e.sym, v, v_d.sym)
    outputs = (Output(TRACKING_ERROR, e.sym),)
    return System("kinematics", "kinematic loop", (v_d,), (e,), (), rate, outputs)


def kinematics_at(
    scenario: Scenario, e: tuple[float, float, float] = (0.0, 0.0, 0.0), t: float = 0.0
) -> ct.StateSpace:
    """The kinematic loop near error ``e`` [m, m, rad], with v_d of the reference at ``t`` [s]."""
    v_d, _ = reference_velocity(scenario, t)
    return linearise(kinematic_loop(scenario), v_d, e)


def kinematic_poles(scenario: Scenario, e: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Floats:
    """Its eigenvalues [1/s], slowest last at e = 0 with the paper's gains."""
    poles = np.asarray(kinematics_at(scenario, e).poles(), dtype=complex)
    return poles[np.argsort(poles.real)]
