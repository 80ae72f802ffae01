"""The table of units, and quantities as texts: ``kg.m2/s`` in SI, ``20 ms``, ``2 km/h``.

Every unit of the project is read here: of FMUs, SSP and maps (exponents of the SI base units, as
those standards want them) and of numbers that a user writes with their unit.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache
from typing import Self

from wmr_ctrl.core.data import data
from wmr_ctrl.core.errors import ArgumentError

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
PI = Fraction("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899")
UNITS = data(__package__, "units.toml")
_KNOWN: Mapping[str, tuple[Fraction, dict[str, int]]] = {
    **{name: (Fraction(1), {name: 1}) for name in BASE},
    **{
        name: (Fraction(row["size"]) * (PI if "pi" in row else 1), row["exponents"])
        for name, row in UNITS["known"].items()
    },
}
"""Size and exponents; sizes are exact, but for pi, of which 80 digits are known."""
_PREFIXES = {name: Fraction(size) for name, size in UNITS["prefixed"]["sizes"].items()}
_SPELLINGS = str.maketrans({"²": "2", "³": "3", "·": ".", "*": ".", " ": ".", "µ": "u", "μ": "u"})
_QUANTITY = re.compile(
    r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)(\s*[A-Za-z%°µμ].*|\s+1\b.*)"
)
KINDS: Mapping[str, tuple[str, str]] = UNITS["kinds"]
"""By unit: what it measures, and how users may write it."""
_DISPLAY = {"rad": ("deg", float(180 / PI)), "rad/s": ("deg/s", float(180 / PI))}


@dataclass(frozen=True)
class NamedUnit:
    """A unit's name and exponents of the base units; a value v is factor v + offset in SI."""

    name: str
    factor: float
    exponents: dict[str, int] = field(hash=False)
    offset: float = 0.0

    @property
    def display(self) -> tuple[str, float] | None:
        """Display unit and the number of them in one of this unit, or None."""
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
    """Read a unit such as ``kg.m2/s``; raises ArgumentError if it is not a known unit."""
    size, exponents = _read(name)
    return NamedUnit(name, float(size), exponents)


@cache
def _read(name: str) -> tuple[Fraction, dict[str, int]]:
    """Size in SI units, exact except for pi, and exponents of the base units."""
    size, exponents = Fraction(1), dict.fromkeys(BASE, 0)
    text = re.sub(r"/\(([^()]*)\)", lambda found: "/" + found[1].replace(".", "/"), name)
    for place, group in enumerate(text.split("/")):
        for part in group.split("."):
            match = re.fullmatch(r"([A-Za-z]+|%|1)(-?\d{1,2})?", part)
            known = _part(match[1]) if match else None
            if match is None or known is None:
                raise ArgumentError(
                    f"unit {name!r} is not known: {part!r} is none of {', '.join(_KNOWN)}, some of "
                    f"which take {', '.join(_PREFIXES)} before. Write it as in kg.m2/s, with whole "
                    "exponents."
                )
            power = int(match[2] or 1) * (1 if place == 0 else -1)
            size *= Fraction(known[0]) ** power
            for key, exponent in known[1].items():
                exponents[key] += exponent * power
    return size, {key: value for key, value in exponents.items() if value}


def _part(name: str) -> tuple[Fraction, dict[str, int]] | None:
    """Size and exponents of a unit, with or without a prefix."""
    if name in _KNOWN:
        return _KNOWN[name]
    if name[0] in _PREFIXES and name[1:] in UNITS["prefixed"]["units"]:
        size, exponents = _KNOWN[name[1:]]
        return size * _PREFIXES[name[0]], exponents
    return None


def fitting(unit: str) -> str:
    """Units in which a number in ``unit`` may be written."""
    return KINDS[unit][1] if unit in KINDS else unit


class Stated(float):
    """A number in SI that was written with its unit; ``text`` is the original spelling."""

    text: str
    unit: str

    @classmethod
    def of(cls, value: float, text: str, unit: str) -> Self:
        """The number ``value`` [SI], which was written as ``text`` in ``unit``."""
        number = cls(value)
        number.text, number.unit = text, unit
        return number

    def refused(self, wanted: str) -> str:
        """Reason why this number cannot be given in ``wanted``; empty if it can.

        Angles are not plain numbers here: rad/s differs from 1/s.  So Hz, which may mean turns,
        leads to a question.
        """
        mine = _read(self.unit)[1]
        try:
            same = mine == _read(wanted)[1]
        except ArgumentError:
            same = False  # a law's own unit, or none
        if same:
            return ""
        kinds = {kind: unit for unit, (kind, _) in KINDS.items() if _read(unit)[1] == mine}
        kind = KINDS[wanted][0] if wanted in KINDS else f"a number in {wanted or 'no unit'}"
        what = next(iter(kinds), f"a number in {self.unit}")
        units = fitting(wanted) or "no unit"
        return f"{kind} (in {units}), not {what}"


def stated(text: str) -> str | Stated:
    """The number of a text such as "20 ms" in SI, correctly rounded; other texts as they are."""
    match = _QUANTITY.fullmatch(text.strip())
    if match is None:
        return text
    unit = re.sub(r"\s*([/*.·])\s*|\s+", lambda found: found[1] or " ", match[2].strip())
    unit = unit.replace("^", "").replace("°", "deg").translate(_SPELLINGS)
    try:
        value = float(Fraction(match[1]) * _read(unit)[0])
    except (ArgumentError, OverflowError, ValueError):  # of digits beyond what Python reads
        return text
    return Stated.of(value, text, unit)


def with_units(raw: object) -> object:
    """Replace each text of a raw value that is a number with its unit by `Stated`."""
    if isinstance(raw, str):
        return stated(raw)
    if isinstance(raw, Mapping):
        return {key: with_units(value) for key, value in raw.items()}
    return [with_units(item) for item in raw] if isinstance(raw, list | tuple) else raw


def per_second(name: str) -> str:
    """Name of the unit of a quantity's rate: ``m/s2`` for ``m/s``; "" if no unit is stated."""
    if not name:
        return ""
    if seconds := re.search(r"(?<=/)s(\d*)$", name):
        return f"{name[: seconds.start()]}s{int(seconds[1] or 1) + 1}"
    return f"{name}/s"


def units_of(names: Iterable[str]) -> list[NamedUnit]:
    """The different units among ``names``, in the order of their names."""
    return [unit_of(name) for name in sorted(set(names))]
