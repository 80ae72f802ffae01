"""Pose sensor: slow and noisy poses, with dead reckoning from the measured velocity in between.

Source: Section VI of the paper has such a sensor; it does not say how the pose is used between two
measurements.
"""

from __future__ import annotations

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import MEASURED_POSE, MEASURED_VELOCITY, SAMPLE, Signal
from wmr_ctrl.core.symbolic import ca

from .effect import Effect, EffectRole, Scenario, adds_nothing
from .model.system import (
    UNIFORM,
    Parameters,
    System,
    draw,
    outputs,
    port,
    ports,
    stack,
)

NUMBERS = Signal("pose", "1", "uniform numbers on [-1, 1)", 2)
LOST = Signal("pose_lost", "1", "uniform numbers on [-1, 1)", 2)
ESTIMATE = Signal("pose_estimate", "m, m, rad", "dead-reckoned pose of the previous sample", 3)
OLD_VELOCITY = Signal("v_reckoned", "m/s, rad/s", "measured velocity of the previous sample", 2)


class PoseSensor(Section, key="sensor"):
    """Period, error and weight of the measured pose; the defaults are a perfect sensor.

    Between two measured poses the pose is predicted from the velocity; each measured pose
    corrects the prediction by the share ``correction`` of the difference.
    """

    pose_period: float = quantity(
        0.0,
        "s",
        "time between two poses; 0: one every control period",
        minimum=0,
        multiple_of="clock.control",
    )
    pose_noise: float = quantity(
        0.0,
        "m",
        "half-width of the uniform error in x and y; theta is exact",
        minimum=0,
        usual=(0, 5),
    )
    correction: float = quantity(
        1.0, "1", "share of the difference to a measured pose that is corrected", above=0, maximum=1
    )
    pose_dropout: float = quantity(0.0, "1", "probability that a pose is lost", minimum=0, below=1)

    @property
    def perfect(self) -> bool:
        """True if the laws receive the true pose at every sample."""
        exact = self.pose_period == 0 and self.pose_noise == 0 and self.correction == 1
        return exact and self.pose_dropout == 0


def build(scenario: Scenario) -> System:
    """Sampled System: pose, measured velocity and sample number to measured pose.

    It predicts by an Euler step over one control period with the previous sample's measured
    velocity, angle first, then moves the estimate by a share of the measured error: 1 at the first
    sample, ``correction`` if a pose arrived, 0 otherwise.
    """
    pose, velocity, sample = ports(MEASURED_POSE), ports(MEASURED_VELOCITY), port(SAMPLE)
    estimate, old, p = port(ESTIMATE), port(OLD_VELOCITY), Parameters(scenario)
    T, every = p.take("clock.control"), p.take("sensor.pose_period")
    width, correction = p.take("sensor.pose_noise"), p.take("sensor.correction")
    draws = [error := draw(NUMBERS, UNIFORM, width > 0)]
    true = stack(item.sym for item in pose)
    measured = true + ca.vertcat(width * error.port.sym, 0)
    predicted = reckoned(estimate.sym, old.sym, T)
    k, apart = sample.sym, samples_a_pose(every, T)
    came = k - apart * ca.floor(k / apart) == 0
    share = ca.if_else(k == 0, 1, ca.if_else(came, correction, 0))
    perfect = ca.logic_and(ca.logic_and(every == 0, width == 0), correction == 1)
    if scenario.section(PoseSensor).pose_dropout > 0:
        lost = p.take("sensor.pose_dropout")
        draws.append(chance := draw(LOST, UNIFORM, lost > 0))
        comes = ca.logic_or(sample.sym == 0, (chance.port.sym[0] + 1) / 2 >= lost)
        share, perfect = ca.if_else(comes, share, 0), ca.logic_and(perfect, lost == 0)
    seen = ca.if_else(perfect, true, corrected(predicted, measured, share))
    return System(
        "pose_sensor",
        "dead reckoning with pose correction",
        inputs=(*pose, *velocity, sample),
        state=(estimate, old),
        params=p.ports,
        update=ca.vertcat(seen, *(item.sym for item in velocity)),
        outputs=outputs(MEASURED_POSE, seen),
        draws=tuple(draws),
    )


def samples_a_pose(every: ca.SX, T: ca.SX) -> ca.SX:
    """Control periods ``T`` from one pose to the next, for the time ``every`` between them [s]."""
    return ca.fmax(1, ca.floor(every / T + 0.5))


def corrected(predicted: ca.SX, measured: ca.SX, share: ca.SX) -> ca.SX:
    """Pose (3,) after a share of the difference between measurement and prediction."""
    return predicted + share * (measured - predicted)


def reckoned(q: ca.SX, v: ca.SX, T: ca.SX) -> ca.SX:
    """Dead-reckoned pose (3,) after a period T [s] at velocity v (2,), by Euler, angle first."""
    theta = q[2] + T * v[1]
    step = T * v[0]
    return ca.vertcat(q[0] - step * ca.sin(theta), q[1] + step * ca.cos(theta), theta)


POSE_SENSOR = Effect("pose sensor", EffectRole.SENSOR, PoseSensor, build, adds_nothing, always=True)
