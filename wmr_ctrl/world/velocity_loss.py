"""Lost velocities: the last one that arrived is held, and its age is reported.

Source: radio, buses and wheel slip detectors, which drop odometry.  Each measured velocity is lost
with probability 1/2, but never more than ``velocity_losses`` in a row, and the first one arrives.
The age of the held velocity is an output; a governor of commands uses it (`filter`).
"""

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import MEASURED_VELOCITY, ODOMETRY_AGE, SAMPLE, Signal
from wmr_ctrl.core.symbolic import ca

from .effect import Bound, Effect, EffectRole, Scenario
from .model.system import (
    UNIFORM,
    Output,
    Parameters,
    System,
    draw,
    port,
    ports,
    stack,
)
from .velocity_mean import VelocityMean

NUMBERS = Signal("velocity_loss", "1", "uniform numbers on [-1, 1)", 2)
HEARD = Signal("velocity_heard", "m/s, rad/s", "last measured velocity that was not lost", 2)
MISSED = Signal("velocities_missed", "1", "measured velocities lost in a row")


class VelocityLoss(Section, key="sensor"):
    """Largest number of velocities lost in a row."""

    velocity_losses: int = quantity(
        0, "1", "largest number of consecutive lost velocities", minimum=0
    )


def build(scenario: Scenario) -> System:
    """Sampled System: measured velocity and sample number to shown velocity and its age.

    The age is -1 while the shown velocity would be from before the start.
    """
    velocity, sample, p = ports(MEASURED_VELOCITY), port(SAMPLE), Parameters(scenario)
    heard, missed = port(HEARD), port(MISSED)
    T, old, most = map(p.take, ("clock.control", "sensor.velocity_age", "sensor.velocity_losses"))
    number = draw(NUMBERS, UNIFORM, most > 0)
    lost = ca.logic_and(number.port.sym[0] < 0, missed.sym < most)
    comes = ca.logic_or(sample.sym == 0, ca.logic_not(lost))
    shown = ca.if_else(comes, stack(item.sym for item in velocity), heard.sym)
    missing = ca.if_else(comes, 0, missed.sym + 1)
    age = missing * T + old
    before = age > (sample.sym + 0.5) * T
    return System(
        "velocity_loss",
        "lost velocities",
        inputs=(*velocity, sample),
        state=(heard, missed),
        params=p.ports,
        update=ca.vertcat(shown, missing),
        outputs=(
            *(Output(item.signal, shown[i]) for i, item in enumerate(velocity)),
            Output(ODOMETRY_AGE, ca.if_else(before, -1, age)),
        ),
        draws=(number,),
    )


def bound(scenario: Scenario) -> Bound:
    """A guard assumes one fixed age; a governor receives it at every sample."""
    lost = scenario.section(VelocityLoss).velocity_losses
    sentence = f"sensor.velocity_losses = {lost}: a velocity is held for as long as none comes."
    return Bound(void=sentence if lost else "")


def acts(scenario: Scenario) -> bool:
    """True if velocities are lost, or late on a base whose filter uses their age."""
    late = scenario.section(VelocityMean).velocity_age > 0 and scenario.takes_velocity
    return scenario.section(VelocityLoss).velocity_losses > 0 or late


VELOCITY_LOSS = Effect(
    "velocity loss", EffectRole.SENSOR, VelocityLoss, build, bound, acts=acts,
    shape=("sensor.velocity_age", "clock.control"),
)  # fmt: skip
