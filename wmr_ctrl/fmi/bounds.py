"""Ranges of parameters, as the scenario's fields and the laws' gains declare them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields
from typing import Any

from wmr_ctrl.laws import LAWS
from wmr_ctrl.model import auxiliary
from wmr_ctrl.scenario import Scenario

LARGEST = 1e12
"""What no parameter may exceed in size; stands for `unlimited` too."""
SMALLEST = 1e-12
"""Stands for `above zero`, since FMI's ranges include their ends."""

Range = tuple[float, float]


def ranges_of(scenario: Scenario, keys: Iterable[str]) -> dict[str, Range]:
    """Lowest and highest value of each key path that is a field of the scenario or a law's gain."""
    holders = ((key, _holder(scenario, key)) for key in keys)
    return {
        key: _range(holder, key.rpartition(".")[2]) for key, holder in holders if holder is not None
    }


def clock_of(scenario: Scenario) -> dict[str, Range]:
    """Ranges of the clock where the drives have lag or delay: the controller counts its steps."""
    if scenario.actuator.ideal:
        return {}
    return {f"clock.{key}": (getattr(scenario.clock, key),) * 2 for key in ("control", "plant")}


def _holder(scenario: Scenario, key: str) -> Any:
    """The dataclass that declares the field ``key``, or None."""
    section, _, rest = key.partition(".")
    if section == "gains":
        law = rest.partition(".")[0]
        return auxiliary.Gains if law == "kinematics" else LAWS[law].gains if law in LAWS else None
    holder = scenario.believed if section == "model" else getattr(scenario, section, None)
    known = getattr(holder, "__dataclass_fields__", {}) if rest else {}
    return type(holder) if rest in known else None


def _range(holder: Any, name: str) -> Range:
    bounds = next(
        (item.metadata.get("bounds") for item in fields(holder) if item.name == name), None
    )
    if bounds is None:
        return -LARGEST, LARGEST
    low = _first(
        bounds.minimum, None if bounds.above is None else bounds.above + SMALLEST, -LARGEST
    )
    high = _first(
        bounds.maximum, None if bounds.below is None else bounds.below - SMALLEST, LARGEST
    )
    return low, high


def _first(*candidates: float | None) -> float:
    return next(float(value) for value in candidates if value is not None)
