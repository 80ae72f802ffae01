"""The registry of effects: one line each, in the order in which effects of a role compose.

Other packages add theirs through the entry-point group ``wmr_ctrl.effects`` (name = effect,
value = an `Effect`); they come after ours.  An effect with a table of its own in the scenario
needs nothing else; one whose fields belong to an existing table is a base of that table's class.
"""

import math
from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.plugins import loaded
from wmr_ctrl.core.fields.section import Section, quantity

from .command_dead_band import COMMAND_DEAD_BAND, CommandDeadBand
from .command_delay import COMMAND_DELAY, CommandDelay
from .command_jerk import COMMAND_JERK, CommandJerk
from .command_loss import COMMAND_LOSS, CommandLoss
from .command_quantum import COMMAND_QUANTUM, CommandQuantum
from .command_ramp import COMMAND_RAMP, CommandRamp
from .delay import DELAY, Delay
from .effect import Effect, EffectRole
from .encoder import ENCODER
from .gust import GUST
from .gyro import GYRO
from .jitter import JITTER, Jitter
from .lag import LAG, Lag
from .motor import MOTOR
from .pose_delay import POSE_DELAY, PoseDelay
from .pose_sensor import POSE_SENSOR, PoseSensor
from .push import PUSH, Push
from .resistance import RESISTANCE
from .slope import SLOPE
from .speed_loop import BaseKind
from .speed_loop_first_order import FirstOrderGains, LoopGain
from .speed_loop_pi import PiLoopGains
from .speed_loop_second_order import SecondOrderGains
from .speed_loops import SPEED_LOOP
from .standstill import STANDSTILL, Standstill
from .torque_noise import TORQUE_NOISE_EFFECT, TorqueNoise
from .velocity_loss import VELOCITY_LOSS, VelocityLoss
from .velocity_mean import VELOCITY_MEAN, VelocityMean
from .velocity_noise import VELOCITY_NOISE, VelocityNoise
from .wheel_commands import WHEEL_COMMANDS, WheelCommands
from .wheel_speed_limit import WHEEL_SPEED_LIMIT, WheelSpeedLimit
from .wheels import WHEELS

if TYPE_CHECKING:
    from .scenario import Scenario

OURS = (
    ENCODER, VELOCITY_MEAN, GYRO, VELOCITY_NOISE, VELOCITY_LOSS, POSE_DELAY, POSE_SENSOR,
    TORQUE_NOISE_EFFECT, PUSH, GUST, SLOPE, RESISTANCE,
    COMMAND_DELAY, COMMAND_LOSS, COMMAND_QUANTUM, COMMAND_DEAD_BAND, STANDSTILL,
    WHEEL_SPEED_LIMIT, WHEEL_COMMANDS, COMMAND_RAMP, COMMAND_JERK, SPEED_LOOP,
    DELAY, JITTER, MOTOR, LAG, WHEELS,
)  # fmt: skip
GROUP = "wmr_ctrl.effects"


class Sensor(VelocityLoss, VelocityNoise, VelocityMean, PoseSensor, PoseDelay, key="sensor"):
    """Sensors of pose and velocity; the defaults are perfect."""


class Disturbance(Push, TorqueNoise, key="disturbance"):
    """Torque on the wheels that no law commands: random, or as adverse as its size allows."""


class Actuator(Delay, Jitter, Lag, key="actuator"):
    """Torque limit, first-order lag and delay of the drives; the defaults are ideal drives."""

    tau_max: float = quantity(
        math.inf, "N.m", "largest torque of each wheel; inf: none", above=0, infinite=True
    )

    traction: bool = quantity(
        False, "1", "limit wheel torques to what the tyres of [body] can certainly transmit"
    )

    @property
    def ideal(self) -> bool:
        """True if the torque acts without delay and lag (it may still be limited)."""
        return self.lag == 0 and self.delay == 0 and self.unmodelled_delay == 0 and self.jitter == 0


class Base(
    CommandJerk, CommandRamp, WheelCommands, WheelSpeedLimit, Standstill, CommandDeadBand,
    CommandQuantum, CommandLoss, CommandDelay, PiLoopGains, SecondOrderGains, LoopGain,
    FirstOrderGains, BaseKind,
    key="base",
):  # fmt: skip
    """Input of the base: wheel torques, or velocities that its own speed loop follows.

    Each wheel of the speed loop gives at most actuator.tau_max.
    """

    min_radius: float = quantity(
        0.0, "m", "least turning radius of a base that cannot turn on the spot; 0: it can",
        minimum=0,
    )  # fmt: skip
    tau_believed: tuple[float, float] | None = quantity(
        None,
        "s",
        "time constants that laws assume; default: tau, or 2 damping/frequency, or mass over kp",
        size=2,
        above=0,
        usual=(0, 5),
        alike=True,
    )


SHARED = tuple(section.KEY for section in (Sensor, Disturbance, Actuator, Base))
"""Tables to which several effects give fields."""


class EffectRegistry:
    """All effects: ours, then those of other packages in the order of their names."""

    @cached_property
    def plugins(self) -> tuple[Effect, ...]:
        """Effects of other packages."""
        foreign = loaded(GROUP, Effect)
        for place, effect in enumerate(foreign):
            others = (*OURS, *foreign[:place])
            keys = {*SHARED, *(o.section.KEY for o in others)}
            if effect.name in {other.name for other in others} or effect.section.KEY in keys:
                raise ArgumentError(
                    f"the effect {effect.title} has the name or the table of another one. Its "
                    "author must give it a different name and section.KEY."
                )
        return foreign

    def __iter__(self) -> Iterator[Effect]:
        yield from (*OURS, *self.plugins)

    def present(self, scenario: "Scenario", *roles: EffectRole) -> tuple[Effect, ...]:
        """Effects in a scenario's loop; if roles are named, only effects of these roles."""
        asked = (item for item in self if not roles or item.role in roles)
        return tuple(item for item in asked if item.present(scenario))

    def sections(self) -> dict[str, type[Section]]:
        """Sections of effects that have a table of their own, by its key."""
        own = (item.section for item in self if item.section.KEY not in SHARED)
        return {section.KEY: section for section in own}


EFFECTS = EffectRegistry()
