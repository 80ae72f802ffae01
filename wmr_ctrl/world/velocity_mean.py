"""Velocity that is late or averaged: the mean over a window that ended some time ago.

Source: a device that differences positions shows the mean; a filter or a bus adds the age. The
sensor is ideal, without counts (see `encoder`).
"""

from wmr_ctrl.core.fields.section import Section
from wmr_ctrl.core.signals import MEASURED_VELOCITY, PATH, POSE, SAMPLE, VELOCITY, Signal

from .effect import Bound, Effect, EffectRole, Scenario, on_axes
from .gyro import axes_without_gyro
from .history import history, remembered
from .model.system import Parameters, System, outputs, port, ports, stack

PLACE = Signal("mean_place", "m, rad", "way and orientation", 2)
OLD_VELOCITY = Signal("mean_v", "m/s, rad/s", "true velocity", 2)


class VelocityMean(Section, key="sensor"):
    """Window and age of the measured velocity."""

    velocity_window: float = remembered("time over which the velocity is averaged")
    velocity_age: float = remembered("age of the end of that window")


def build(scenario: Scenario) -> System:
    """Sampled System: path length, orientation, true velocity and sample to measured velocity."""
    sample, p = port(SAMPLE), Parameters(scenario)
    window, age = _periods(scenario)
    true = (port(PATH), port(POSE[2])) if window else ports(VELOCITY)
    now = stack(item.sym for item in true)
    signal = PLACE if window else OLD_VELOCITY
    seen = history(signal, now, sample.sym == 0, age + window)
    shown = seen.aged[age]
    if window:
        shown = (shown - seen.aged[-1]) / (p.take("clock.control") * window)
    return System(
        "velocity_mean",
        "late or averaged velocity",
        inputs=(*true, sample),
        state=seen.state,
        params=p.ports,
        update=seen.update,
        outputs=outputs(MEASURED_VELOCITY, shown),
    )


def _periods(scenario: Scenario) -> tuple[int, int]:
    mean, period = scenario.section(VelocityMean), scenario.clock.control
    return round(mean.velocity_window / period), round(mean.velocity_age / period)


def bound(scenario: Scenario) -> Bound:
    """Window and age; for a mean also the rounding error of the path length.

    The path length is at most u1 times the duration and is rounded by 2^-53 of that in each plant
    step, so within the window by 2^-53 u1 duration/step; the same again covers its difference.
    """
    mean, clock = _periods(scenario), scenario.clock
    window, age = (item * clock.control for item in mean)
    share = 2.0**-52 * clock.duration / clock.plant if window else 0.0
    first, second = (share * limit for limit in scenario.limits.v_u1)
    late = Bound(age=(age, age), window=(window, window), nbar=(first, second))
    return on_axes(axes_without_gyro(scenario), late)


SHAPE = ("sensor.velocity_window", "sensor.velocity_age", "clock.control")
VELOCITY_MEAN = Effect("velocity mean", EffectRole.SENSOR, VelocityMean, build, bound, shape=SHAPE)
