"""What a guard counts on, and where each of its numbers is from: stated, or added up by effects."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from wmr_ctrl.guard.bounds import GuardNumbers, Pair, pair_of
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.world.effect import Bound, Effect

MODEL = "model.m, model.I, widened by guard.mass_margin"
STATED = "stated"
_PARTS: Mapping[str, Callable[[Bound], Pair]] = {
    "M_min": lambda bound: bound.mass,
    "M_max": lambda bound: bound.mass,
    "dbar": lambda bound: bound.dbar,
    "nbar": lambda bound: bound.nbar,
    "delay": lambda bound: bound.takeover,
    "lag": lambda bound: bound.lag,
    "age": lambda bound: bound.age,
    "window": lambda bound: bound.window,
}
"""What an effect adds to each number.  Masses are narrowed below and widened above."""


@dataclass(frozen=True)
class Counted:
    """A number that the guard counts on, per axis or from least to most, and what it is made of."""

    name: str
    value: Pair
    sources: Mapping[str, Pair | None]
    """What each adds, by effect or key; None where a source is no sum."""


def counted(
    scenario: Scenario, guard: GuardNumbers, effects: Iterable[Effect]
) -> dict[str, Counted]:
    """The numbers of a settled guard by name, in SI units; ``effects`` are those present."""
    bounds = {item.name: b for item in effects if (b := item.bounded(scenario)) is not None}
    return {
        name: Counted(name, pair_of(getattr(guard, name)), dict(_sources(scenario, name, bounds)))
        for name in _PARTS
    }


def _sources(
    scenario: Scenario, name: str, bounds: Mapping[str, Bound]
) -> Iterable[tuple[str, Pair | None]]:
    if getattr(scenario.guard, name, None) is not None:
        yield STATED, None
        return
    if name in ("M_min", "M_max"):
        yield MODEL, None
    yield from ((effect, _PARTS[name](b)) for effect, b in bounds.items() if any(_PARTS[name](b)))
    if name == "dbar" and any(scenario.guard.d_model):
        yield "guard.d_model", scenario.guard.d_model
