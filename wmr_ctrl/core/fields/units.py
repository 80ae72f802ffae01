"""Values whose unit looks mistaken: usual sizes, units that are often confused; digits."""

import math
from collections.abc import Mapping
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal

from .named_units import UNITS, unit_of

USUAL: Mapping[str, tuple[float, float]] = UNITS["usual"]
"""Sizes that are usual of a wheeled robot, by unit; a field may state a range of its own."""
OTHERS: Mapping[str, list[tuple[str, str]]] = UNITS["others"]
"""Units that may be meant instead: name and symbol."""


def is_usual(value: float, usual: tuple[float, float]) -> bool:
    """True if the size of a value is in a range; also for 0 and for values that are not finite."""
    return not value or not math.isfinite(value) or usual[0] <= abs(value) <= usual[1]


def written(usual: tuple[float, float]) -> str:
    """A range of sizes in words, such as "up to 15" or "0.003 to 1"."""
    return f"{usual[0]:g} to {usual[1]:.4g}" if usual[0] else f"up to {usual[1]:.4g}"


def meant(value: float, unit: str, usual: tuple[float, float]) -> str:
    """Question whether ``value`` was meant in another unit, in which it would be usual; else
    empty.
    """
    here = f" {unit}" if unit != "1" else ""
    return " ".join(
        f"{words.capitalize()}? {value:g} {sign} is {value * size:.4g}{here}."
        for words, sign in OTHERS.get(unit, ())
        if is_usual(value * (size := unit_of(sign).factor / unit_of(unit).factor), usual)
    )


def rounded(value: float, digits: int, up: bool = True) -> str:
    """A number with ``digits`` significant digits, rounded up or down (tolerance 1e-12)."""
    if not (math.isfinite(value) and value):
        return f"{value:g}"
    exact = Decimal(value * (1 - 1e-12 if up == (value > 0) else 1 + 1e-12))
    mode = ROUND_CEILING if up else ROUND_FLOOR
    return f"{float(Context(digits, mode).plus(exact)):.{digits}g}"


def plain(value: float) -> str:
    """A number of up to ten digits, without an exponent for the sizes that occur on robots."""
    text = f"{value:.10g}"
    usual = math.isfinite(value) and (not value or 1e-6 <= abs(value) < 1e15)
    return f"{Decimal(text):f}" if usual else text


def sized(value: float, unit: str, digits: int = 4) -> str:
    """A number with its unit, in thousandths or millionths of the unit if it is below 0.1."""
    steps = ((1.0, ""), (1e3, "m"), (1e6, "µ")) if unit else ((1.0, ""),)
    fits = (step for step in steps if abs(value) * step[0] >= 0.1 or not value)
    size, prefix = next(fits, steps[-1])
    return f"{value * size:.{digits}g} {prefix}{unit}".strip()


def limits_in_words(sides: tuple[tuple[float, float], tuple[float, float]]) -> str:
    """Limits of v and omega, as "1 m/s and 1.5 rad/s", or "-0.2 to 1 m/s" if directions differ."""
    named = zip(sides, ("m/s", "rad/s"), strict=True)
    return " and ".join(
        f"{high:g} {unit}" if low == -high else f"{low:g} to {high:g} {unit}"
        for (low, high), unit in named
    )


def length(value: float, up: bool = True) -> str:
    """A length with its unit, in mm if it is short; rounded up, or down if ``up`` is false."""
    return f"{rounded(1e3 * value, 3, up)} mm" if value < 0.1 else f"{rounded(value, 3, up)} m"
