"""What the guard costs: the steady speeds that it leaves, beside those the reference asks for."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from wmr_ctrl.guard.bounds import GuardNumbers, Pair, unbeatable_speed, usable_speed
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.world.friction import largest_friction
from wmr_ctrl.world.references.evaluate import reference_bounds


@dataclass(frozen=True)
class SpeedPrice:
    """Speeds of both axes [m/s, rad/s], against the largest friction of the run.

    ``usable``: largest steady ones that the guard admits; ``unbeatable``: no guard can admit more;
    ``asked``: the largest of the reference.
    """

    usable: Pair
    unbeatable: Pair
    asked: Pair

    @property
    def short(self) -> tuple[bool, bool]:
        """Whether the reference asks for more than is usable, per axis."""
        return self.asked[0] > self.usable[0], self.asked[1] > self.usable[1]


@lru_cache(maxsize=64)
def speed_price(scenario: Scenario, guard: GuardNumbers) -> SpeedPrice:
    """Usable speeds by `usable_speed`; friction brakes the way ahead, and no turn."""
    friction = (largest_friction(scenario), 0.0)
    slowest, fastest, turning = reference_bounds(scenario)
    return SpeedPrice(
        usable_speed(scenario, guard, friction),
        unbeatable_speed(scenario, guard, friction),
        (max(abs(slowest), abs(fastest)), turning),
    )
