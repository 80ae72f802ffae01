"""Peaks: largest deviations of the loop, and a tube from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wmr_ctrl.theory.checks.error_coordinates import Floats

LEAST = 1e-15
"""Added to every deviation that is made larger."""


@dataclass(frozen=True)
class Peaks:
    """Largest deviations: fast state with all its rows, state at samples, outputs of the law."""

    fast: Floats
    state: Floats
    law: Floats

    @property
    def parts(self) -> tuple[Floats, Floats, Floats]:
        """The fast, state and law parts."""
        return self.fast, self.state, self.law

    @property
    def every(self) -> Floats:
        """All numbers in one vector."""
        return np.concatenate(self.parts)

    def times(self, factor: float, more: float = LEAST) -> Peaks:
        """The peaks times a factor, plus ``more``."""
        return Peaks(*(part * factor + more for part in self.parts))

    def limit(self, first: Peaks, second: Peaks) -> Peaks:
        """Point slightly beyond the limit of these three peaks, if they grow geometrically."""
        before, now = second.every - first.every, self.every - second.every
        share = float((now / np.where(before > 0, before, np.inf)).max())
        more = 1.01 * share / (1 - share) if share < 1 else 0.0
        parts = zip(self.parts, second.parts, strict=True)
        return Peaks(*(last + more * np.maximum(last - old, 0.0) for last, old in parts))

    def within(self, other: Peaks) -> bool:
        """True if no element is larger than the other's."""
        return bool((self.every <= other.every).all())


@dataclass(frozen=True)
class Tube:
    """A closed box: ``position`` [m], ``heading`` [rad], and the most used condition.

    ``position_late`` [m]: bound of the position in the long run.
    """

    peaks: Peaks
    position: float
    position_late: float
    heading: float
    binding: str
    share: float


def reference_gap(v_d: Floats, step: float) -> float:
    """Distance [m] between a circle's arc of one plant step and its sum by Simpson's rule."""
    return abs(float(v_d[0])) * float(v_d[1]) ** 4 * step**5 / 1000
