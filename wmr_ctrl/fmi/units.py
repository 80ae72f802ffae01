"""Units as the FMI and SSP standards want them: exponents of the SI base units, display units."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cache

from wmr_ctrl.errors import ArgumentError

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
_KNOWN: dict[str, tuple[float, dict[str, int]]] = {
    **{name: (1.0, {name: 1}) for name in BASE},
    "1": (1.0, {}),
    "N": (1.0, {"kg": 1, "m": 1, "s": -2}),
    "mN": (1e-3, {"kg": 1, "m": 1, "s": -2}),
    "kN": (1e3, {"kg": 1, "m": 1, "s": -2}),
    "J": (1.0, {"kg": 1, "m": 2, "s": -2}),
    "W": (1.0, {"kg": 1, "m": 2, "s": -3}),
    "Hz": (1.0, {"s": -1}),
    "deg": (math.pi / 180, {"rad": 1}),
    "rpm": (2 * math.pi / 60, {"rad": 1, "s": -1}),
    "g": (1e-3, {"kg": 1}),
    "mm": (1e-3, {"m": 1}),
    "cm": (1e-2, {"m": 1}),
    "km": (1e3, {"m": 1}),
    "ms": (1e-3, {"s": 1}),
    "min": (60.0, {"s": 1}),
    "h": (3600.0, {"s": 1}),
}
_DISPLAY = {"rad": ("deg", 180 / math.pi), "rad/s": ("deg/s", 180 / math.pi)}


@dataclass(frozen=True)
class NamedUnit:
    """A unit's name and exponents of the base units; a value v is factor v + offset in SI."""

    name: str
    factor: float
    exponents: dict[str, int] = field(hash=False)
    offset: float = 0.0

    @property
    def display(self) -> tuple[str, float] | None:
        """Display unit and how many of it are one of this unit, or None."""
        return _DISPLAY.get(self.name)

    def fits(self, other: NamedUnit) -> bool:
        """Whether both measure the same kind of quantity; angles count as numbers."""
        return _without_angle(self) == _without_angle(other)


@cache
def unit_of(name: str) -> NamedUnit:
    """Read a unit such as ``kg.m2/s``; raises ArgumentError for what is not one."""
    factor, exponents = 1.0, dict.fromkeys(BASE, 0)
    for place, group in enumerate(name.split("/")):
        for part in group.split("."):
            symbol, power = _part(part, name)
            power = power if place == 0 else -power
            scale, base = _KNOWN[symbol]
            factor *= scale**power
            for key, exponent in base.items():
                exponents[key] += exponent * power
    return NamedUnit(name, factor, {key: value for key, value in exponents.items() if value})


def units_of(names: Iterable[str]) -> list[NamedUnit]:
    """The different units among ``names``, in the order of their names."""
    return [unit_of(name) for name in sorted(set(names))]


def _part(text: str, whole: str) -> tuple[str, int]:
    match = re.fullmatch(r"([A-Za-z]+|1)(-?\d+)?", text)
    if not match or match[1] not in _KNOWN:
        raise ArgumentError(
            f"unit {whole!r} is not known: {text!r} is none of {', '.join(_KNOWN)}. Write it as in "
            "kg.m2/s, with whole exponents."
        )
    return match[1], int(match[2] or 1)


def _without_angle(unit: NamedUnit) -> dict[str, int]:
    return {key: value for key, value in unit.exponents.items() if key != "rad"}
