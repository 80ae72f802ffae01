"""Case: one region of a claim, given as a chart of free positive numbers onto the region.

``values`` maps the chart's numbers to the inputs that it fixes, in any arithmetic (rationals, z3,
fraction fields), so that the cover of a domain by its cases can itself be proved.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

POSITIVE, NONNEGATIVE, NONZERO, FREE = "> 0", ">= 0", "!= 0", "any"
_SAMPLES = tuple(map(Fraction, ("1/2", "3/5", "7/4", "2/7", "5/3", "11/13")))


@dataclass(frozen=True)
class Case:
    """Numbers of the chart with their domains, and the inputs as functions of them."""

    label: str
    numbers: Mapping[str, str] = field(default_factory=dict)
    values: Callable[[Mapping[str, Any]], Mapping[str, Any]] = lambda _: {}
    declared: Mapping[str, str] = field(default_factory=dict)

    def sample(self, names: tuple[str, ...], shift: int) -> dict[str, Fraction]:
        """A rational point of the case: one value for each input in ``names``."""
        chart = {name: _sample(k + shift) for k, name in enumerate(self.numbers)}
        fixed = dict(self.values(chart))
        point = {name: Fraction(fixed[name]) for name in names if name in fixed}
        for k, name in enumerate(n for n in names if n not in fixed):
            signed = self.declared.get(name, FREE) in (FREE, NONZERO)
            sign = -1 if signed and not (k + shift) % 3 else 1
            point[name] = sign * _sample(3 * k + 5 * shift + 1)
        return point

    def described(self) -> list[Any]:
        """Fingerprint for records: numbers and domains, and the chart at two exact points.

        Charts are quotients of polynomials, so others than this one have other values there.
        """
        charts = [{name: _sample(3 * k + s) for k, name in enumerate(self.numbers)} for s in (1, 2)]
        points = [sorted((n, str(x)) for n, x in self.values(chart).items()) for chart in charts]
        return [self.label, dict(self.numbers), dict(self.declared), points]


def _sample(k: int) -> Fraction:
    return _SAMPLES[k % len(_SAMPLES)] + Fraction(k % 7, 3 * (1 + k % 5))


def at(**coordinates: str | int) -> dict[str, Fraction]:
    """An exact point: whole numbers, or text such as ``4/5`` or ``0.8``."""
    return {name: Fraction(value) for name, value in coordinates.items()}
