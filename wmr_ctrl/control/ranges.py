"""Ranges of parameters, as the scenario's fields and the laws' gains declare them."""

from __future__ import annotations

from collections.abc import Iterable

from wmr_ctrl.control.setup import KINEMATICS
from wmr_ctrl.fields.section import Section, quantities
from wmr_ctrl.fields.values import Range as Admitted
from wmr_ctrl.laws import LAWS
from wmr_ctrl.model.kinematics import KinematicGains
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.scenario.scenario import sections
from wmr_ctrl.signals import LARGEST

SMALLEST = 1e-12
"""Stands for `above zero`, since FMI's ranges include their ends."""

Range = tuple[float, float]


def ranges_of(scenario: Scenario, keys: Iterable[str]) -> dict[str, Range]:
    """Lowest and highest value of each key path that is a field of the scenario or a law's gain."""
    holders = ((key, _holder(scenario, key)) for key in keys)
    return {
        key: _range(holder, key.rpartition(".")[2]) for key, holder in holders if holder is not None
    }


def fields_of(scenario: Scenario, keys: Iterable[str]) -> dict[str, Admitted]:
    """What the field of each key path admits, its ends told apart from what is just outside."""
    holders = ((key, _holder(scenario, key)) for key in keys)
    return {
        key: dict(quantities(holder))[key.rpartition(".")[2]].bounds
        for key, holder in holders
        if holder is not None
    }


def clock_of(scenario: Scenario) -> dict[str, Range]:
    """Ranges of the clock where the drives have lag or delay: the controller counts its steps."""
    if scenario.actuator.ideal:
        return {}
    return {f"clock.{key}": (getattr(scenario.clock, key),) * 2 for key in ("control", "plant")}


def _holder(scenario: Scenario, key: str) -> type[Section] | None:
    """The dataclass that declares the field ``key``, or None."""
    section, _, rest = key.partition(".")
    if section == "gains":
        law = rest.partition(".")[0]
        return KinematicGains if law == KINEMATICS else LAWS[law].gains if law in LAWS else None
    holder = type(scenario.table(section)) if section in sections() else None
    known = {name for name, _ in quantities(holder)} if holder and rest else set()
    return holder if rest in known else None


def _range(holder: type[Section], name: str) -> Range:
    bounds = dict(quantities(holder))[name].bounds
    low = _first(
        bounds.minimum, None if bounds.above is None else bounds.above + SMALLEST, -LARGEST
    )
    high = _first(
        bounds.maximum, None if bounds.below is None else bounds.below - SMALLEST, LARGEST
    )
    return low, high


def _first(*candidates: float | None) -> float:
    return next(float(value) for value in candidates if value is not None)
