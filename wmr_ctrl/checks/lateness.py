"""How late the linear loop takes drives and sensors to be, and what it leaves out of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import casadi as ca

from wmr_ctrl.control.setup import Setup
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.world.effect import EffectRole
from wmr_ctrl.world.pose_delay import PoseDelay
from wmr_ctrl.world.pose_sensor import PoseSensor, samples_a_pose
from wmr_ctrl.world.registry import EFFECTS

Pair = tuple[float, float]
WINDOW = "velocity's window"


@dataclass(frozen=True)
class Lateness:
    """How late commands act, velocities and poses are seen [s]; pairs are (linear, angular).

    A command takes over ``delay`` after it was given and is followed with time constant ``lag``;
    a velocity is its mean over a ``window`` that ended ``age`` ago; a pose is ``pose_age`` old, and
    the share ``correction`` of its difference from the predicted one is believed; one comes every
    ``pose_period``.  Of the delay the last part, ``untold``, is known to no law.
    """

    delay: float = 0.0
    lag: float = 0.0
    age: Pair = (0.0, 0.0)
    window: Pair = (0.0, 0.0)
    pose_age: float = 0.0
    correction: float = 1.0
    pose_period: float = 0.0
    untold: float = 0.0

    @property
    def shown(self) -> float:
        """Age of the oldest velocity or pose that a sensor still shows [s]."""
        ages = [age + window for age, window in zip(self.age, self.window, strict=True)]
        return max(*ages, self.pose_age)

    @property
    def told(self) -> Lateness:
        """What laws and observer take the drives for: without what nobody told them."""
        return Lateness(max(self.delay - self.untold, 0.0), self.lag)

    @property
    def discrete(self) -> bool:
        """Whether there is more than a lag: what a differential equation has no place for."""
        return self.delay > 0 or self.shown > 0 or self.correction < 1 or self.pose_period > 0

    def samples_a_pose(self, period: float) -> int:
        """Samples from one pose to the next, at a control period [s]."""
        return int(_samples()(self.pose_period, period))

    @property
    def words(self) -> dict[str, float]:
        """What there is of it [s], by word."""
        parts = {
            "delay": self.delay, "lag": self.lag,
            "velocity's age": max(self.age), WINDOW: max(self.window),
            "pose's age": self.pose_age,
        }  # fmt: skip
        return {word: value for word, value in parts.items() if value}


@cache
def _samples() -> ca.Function:
    every, T = ca.SX.sym("every"), ca.SX.sym("T")
    return ca.Function("samples", [every, T], [samples_a_pose(every, T)])


def lateness_of(setup: Setup, period: float | None = None) -> Lateness:
    """What all effects of a scenario add up to, at its largest where it varies.

    At the scenario's control period, or at another one [s]: a window of one sample goes with it,
    and none is shorter.  No pose is taken to be lost: `lost_poses` tells where some are.
    """
    bound, scenario = setup.bound, setup.scenario
    late, sensor = scenario.section(PoseDelay).pose_delay, scenario.section(PoseSensor)
    own = scenario.clock.control
    first, second = (_window(stated, own, period or own) for stated in bound.window)
    velocities = (bound.delay, bound.lag[1], bound.age, (first, second))
    untold = bound.delay - scenario.actuator.delay
    return Lateness(*velocities, late, sensor.correction, sensor.pose_period, untold)


def _window(stated: float, sample: float, period: float) -> float:
    """A window [s], ``stated`` where a ``sample`` takes so long [s], at another period [s]."""
    if stated == 0 or is_one_sample(stated, sample):
        return period if stated else 0.0
    return max(stated, period)


def is_one_sample(window: float, sample: float) -> bool:
    """Whether a window [s] is that of a single ``sample`` [s]."""
    return 0 < window < 1.5 * sample


def lost_poses(scenario: Scenario) -> str:
    """What the linear loop leaves out of the pose sensor, in words; empty if nothing."""
    lost = scenario.section(PoseSensor).pose_dropout
    return f"as if all poses came, though {lost:.0%} of them do not" if lost > 0 else ""


def unknown_effects(scenario: Scenario) -> str:
    """Which sensors and drives the linear loop does not know, in words; empty if it knows all."""
    present = EFFECTS.present(scenario, EffectRole.SENSOR, EffectRole.DRIVE)
    acting = (item for item in present if not item.linear and item.active(scenario))
    named = " and ".join(f"[{item.section.KEY}]" for item in acting)
    return f"as if there were no {named}" if named else ""


def rare_poses(scenario: Scenario) -> str:
    """What a loop that is the same at every sample leaves out of the pose sensor, in words."""
    sensor, period = scenario.section(PoseSensor), scenario.clock.control
    parts = [f"a pose comes every {sensor.pose_period:g} s"] * (sensor.pose_period > period)
    parts += [f"{sensor.pose_dropout:.0%} of them do not come"] * (sensor.pose_dropout > 0)
    said = " and ".join(parts)
    return f"as if a pose came at every sample, though {said}" if said else ""
