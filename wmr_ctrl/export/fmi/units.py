"""Units as the FMI and SSP standards want them: exponents of the SI base units, display units."""

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cache

from wmr_ctrl.core.errors import ArgumentError

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

    def __mul__(self, other: "NamedUnit") -> "NamedUnit":
        names = {**self.exponents, **other.exponents}
        total = {key: self.exponents.get(key, 0) + other.exponents.get(key, 0) for key in names}
        left = {key: exponent for key, exponent in total.items() if exponent}
        return NamedUnit(f"{self.name}.{other.name}", self.factor * other.factor, left)

    def fits(self, other: "NamedUnit") -> bool:
        """True if both measure the same kind of quantity; angles count as numbers."""
        mine, theirs = self.exponents.items(), other.exponents.items()
        return {key for key, _ in mine ^ theirs} <= {"rad"}


@cache
def unit_of(name: str) -> NamedUnit:
    """Read a unit such as ``kg.m2/s``; raises ArgumentError for what is not one."""
    factor, exponents = 1.0, dict.fromkeys(BASE, 0)
    for place, group in enumerate(name.split("/")):
        for part in group.split("."):
            match = re.fullmatch(r"([A-Za-z]+|1)(-?\d+)?", part)
            if not match or match[1] not in _KNOWN:
                raise ArgumentError(
                    f"unit {name!r} is not known: {part!r} is none of {', '.join(_KNOWN)}. Write "
                    "it as in kg.m2/s, with whole exponents."
                )
            scale, base = _KNOWN[match[1]]
            power = int(match[2] or 1) * (1 if place == 0 else -1)
            factor *= scale**power
            for key, exponent in base.items():
                exponents[key] += exponent * power
    return NamedUnit(name, factor, {key: value for key, value in exponents.items() if value})


def per_second(name: str) -> str:
    """Name of the unit of a quantity's rate: ``m/s2`` for ``m/s``; "" where none is stated."""
    if not name:
        return ""
    if seconds := re.search(r"(?<=/)s(\d*)$", name):
        return f"{name[: seconds.start()]}s{int(seconds[1] or 1) + 1}"
    return f"{name}/s"


def units_of(names: Iterable[str]) -> list[NamedUnit]:
    """The different units among ``names``, in the order of their names."""
    return [unit_of(name) for name in sorted(set(names))]
