"""Stands of a scene: guard on or off, periods, delays: what the page changes by another loop.

Numbers are parameters of a loop and change while it runs.  What decides the form of its graphs does
not: the law, the guard, how many commands are under way.  A stand is a choice of those; it has a
loop for each law, and the numbers that the product derives for it, such as the guard's.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.control.structure import structure_of
from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.fields.values import multiple
from wmr_ctrl.scenario import Scenario, override

PERIODS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1)
"""Control periods [s] that are offered where no part of the loop counts its steps."""
LATE = (0, 2, 5)
"""Delays of the drives that are offered, in control periods of the scenario."""


@dataclass(frozen=True)
class Variant:
    """One choice; period and delay [s]."""

    guard: bool
    period: float
    delay: float

    @property
    def overrides(self) -> Mapping[str, object]:
        """What makes it of a scenario."""
        return {
            "guard.enabled": self.guard,
            "clock.control": self.period,
            "actuator.delay": self.delay,
        }


@dataclass(frozen=True)
class SettledStand:
    """A stand with the settled setup of each law, or why the product refuses it."""

    stand: Variant
    setups: Mapping[str, Setup]
    refusal: str = ""


def settled_stands(scenario: Scenario, laws: tuple[str, ...]) -> Iterator[SettledStand]:
    """All stands of a scenario, its own first.

    Raises as `settle` does where its own is refused.
    """
    own = Variant(scenario.guard.enabled, scenario.clock.control, scenario.actuator.delay)
    yield SettledStand(own, {law: settle(scenario, law) for law in laws})
    for stand in _others(scenario, own, laws[0]):
        try:
            changed = override(scenario, stand.overrides)
            yield SettledStand(stand, {law: settle(changed, law) for law in laws})
        except ScenarioError as error:
            yield SettledStand(stand, {}, str(error))


def _others(scenario: Scenario, own: Variant, law: str) -> Iterator[Variant]:
    periods = _periods(scenario, own, law)
    delays = {own.delay, *(round(count * own.period, 12) for count in LATE)}
    for guard in (own.guard, not own.guard):
        places = [(period, own.delay) for period in periods]
        places += [(own.period, delay) for delay in sorted(delays - {own.delay})]
        for place in places:
            stand = Variant(guard, *place)
            if stand != own:
                yield stand


def _periods(scenario: Scenario, own: Variant, law: str) -> tuple[float, ...]:
    """Periods that the scenario's loop may have: its own, and more if nothing counts its steps."""
    clock = scenario.clock
    fitting = [p for p in PERIODS if multiple(p, clock.plant) and multiple(clock.duration, p)]
    try:
        other = next(p for p in fitting if p != own.period)
        changed = override(scenario, {"clock.control": other, "guard.enabled": False})
        still = override(scenario, {"guard.enabled": False})
        same = structure_of(settle(changed, law)) == structure_of(settle(still, law))
    except (ScenarioError, StopIteration):
        same = False
    return tuple(sorted({own.period, *(fitting if same else ())}))
