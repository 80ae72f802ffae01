"""Dead reckoning between pose updates: how the experiment's slow pose sensor is read."""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.model.parameters import Parameters
from wmr_ctrl.model.system import Output, System, port, ports, stack
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import POSE, VELOCITY, Signal

GAIN = Signal("gain", "1", "share of the pose error that is corrected now: 1, correction or 0")
OLD_VELOCITY = Signal("v_previous", "m/s, rad/s", "velocity of the previous sample", 2)


def estimator(scenario: Scenario) -> System:
    """Sampled System: measured pose, exact velocity and a gain to the estimated pose.

    Predicts by Euler over one control period with the previous sample's velocity, the angle first,
    then moves the estimate by ``gain`` times the measured error.
    """
    measured, velocity, gain = ports(POSE), ports(VELOCITY), port(GAIN)
    estimate, old = ports(POSE), port(OLD_VELOCITY)
    p = Parameters(scenario)
    period = p.take("clock.control")
    q, v_old = stack(item.sym for item in estimate), old.sym
    theta = q[2] + period * v_old[1]
    step = period * v_old[0]
    predicted = ca.vertcat(q[0] - step * ca.sin(theta), q[1] + step * ca.cos(theta), theta)
    error = stack(item.sym for item in measured) - predicted
    corrected = predicted + gain.sym * error
    outputs = tuple(Output(item, corrected[i]) for i, item in enumerate(POSE))
    update = ca.vertcat(corrected, stack(item.sym for item in velocity))
    return System(
        "estimator",
        "dead reckoning with pose correction",
        (*measured, *velocity, gain),
        (*estimate, old),
        p.ports,
        update,
        outputs,
        period=scenario.clock.control,
    )
