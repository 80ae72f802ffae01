"""Numbers as readers like them."""

from __future__ import annotations

import math

ABSENT = "–"


def shown(value: float | None, digits: int = 3) -> str:
    """A number with ``digits`` significant digits, never in programmers' notation; – for None."""
    if value is None or math.isnan(value):
        return ABSENT
    if value == 0 or 1e-3 <= abs(value) < 1e5:
        return _plain(value, digits)
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    return f"{mantissa}·10{_raised(int(exponent))}".replace("-", "−")


def _plain(value: float, digits: int) -> str:
    if value == 0:
        return "0"
    exponent = int(f"{value:.{digits - 1}e}".split("e")[1])
    places = digits - 1 - exponent
    return f"{round(value, places):.{max(places, 0)}f}".replace("-", "−")


def _raised(exponent: int) -> str:
    signs = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
    return str(exponent).translate(signs)


class SpokenNumber(float):
    """A number for sentences: three digits, or by its format ``%`` per cent, ``mm`` millimetres."""

    def __format__(self, spec: str) -> str:
        if spec == "%":
            return f"{shown(100 * self, 2)} %"
        return f"{shown(1000 * self, 2)} mm" if spec == "mm" else shown(float(self))


def spoken(value: float | None) -> SpokenNumber:
    """A number for sentences; NaN stands for one that is missing."""
    return SpokenNumber(math.nan if value is None else value)
