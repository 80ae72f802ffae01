"""Confidence intervals, and a valid rule for stopping a study early.

A rule examines the runs of a case only after fixed numbers of seeds, doubling from ``first``.  Each
of the J looks that the plan allows uses an interval of confidence 1 - (1 - c)/J (Bonferroni), so
that all of them together are correct with probability c at least, wherever the rule stops: exactly
for Clopper and Pearson's interval of a share, nearly for the bootstrap of a mean.
"""

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.core.fields.section import REQUIRED, Section, quantity
from wmr_ctrl.results.figures import SHARES

Floats = NDArray[np.float64]
RESAMPLES = 2000


class StopRule(Section, key="stop"):
    """Rule to stop a case: the interval of its figure is narrow enough."""

    figure: str = quantity(REQUIRED, "1", "figure whose interval decides", kind="text")
    half_width: float = quantity(
        REQUIRED, "1", "half-width of its interval, in the figure's unit", above=0
    )
    confidence: float = quantity(0.95, "1", "of the interval", above=0, below=1)
    first: int = quantity(32, "1", "seeds before the first look", minimum=2)

    @property
    def share(self) -> bool:
        """True for a figure that is 0 or 1 in each run."""
        return self.figure in SHARES

    def looks(self, seeds: int) -> list[int]:
        """Numbers of seeds after which the rule is evaluated; the last is all of them."""
        counts = []
        count = self.first
        while count < seeds:
            counts.append(count)
            count *= 2
        return [*counts, seeds]

    def reached(self, values: Floats, looks: int, cell: int) -> bool:
        """True if the runs of a case are enough; never if a value is missing."""
        if not np.isfinite(values).all():
            return False
        low, high = self.bounds(values, 1 - (1 - self.confidence) / max(looks, 1), cell)
        return (high - low) / 2 <= self.half_width

    def bounds(self, values: Floats, confidence: float, cell: int = 0) -> tuple[float, float]:
        """The interval of the share or mean of ``values``."""
        if not self.share:
            return bootstrap(values, confidence, cell)
        return of_share(int(np.sum(values > 0)), len(values), confidence)


def of_share(hits: int, count: int, confidence: float) -> tuple[float, float]:
    """Clopper and Pearson's interval: it has any true share with at least this probability."""
    from scipy.stats import binomtest  # slow to import, and seldom needed

    return binomtest(hits, count).proportion_ci(confidence)


def bootstrap(values: Floats, confidence: float, key: int = 0) -> tuple[float, float]:
    """Percentile bootstrap of a mean; its draws depend on ``key`` alone."""
    draw = np.random.Generator(np.random.Philox(key=key))
    means = np.empty(RESAMPLES)
    for k in range(RESAMPLES):
        means[k] = values[draw.integers(0, len(values), len(values))].mean()
    low, high = np.quantile(means, [(1 - confidence) / 2, (1 + confidence) / 2]).tolist()
    return low, high
