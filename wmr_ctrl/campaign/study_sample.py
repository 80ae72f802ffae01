"""A sample of a box of a scenario's numbers: Latin hypercube, uniform, or the points of Sobol."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from typing import Any
from warnings import catch_warnings, filterwarnings

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.errors import MissingExtraError

LATIN, SOBOL, UNIFORM = "latin-hypercube", "sobol", "uniform"


@dataclass(frozen=True)
class SamplePlan:
    """A sample of a box: method, size, seed, and the range of each key.

    "sobol" makes the n (d + 2) points that Sobol indices need (SALib's scheme of Saltelli).
    """

    method: str
    n: int
    seed: int
    ranges: Mapping[str, tuple[float, float]]

    @cached_property
    def points(self) -> NDArray[np.float64]:
        """The points, one a row, in the order of ``ranges``."""
        low, high = np.array(list(self.ranges.values())).T
        if self.method == SOBOL:
            sampler: Any = library("SALib.sample.sobol", "study")
            with catch_warnings():
                filterwarnings("ignore", ".*power of 2", UserWarning)  # `warnings` tells it
                rows = sampler.sample(self.problem, self.n, calc_second_order=False, seed=self.seed)
            return np.asarray(rows, dtype=np.float64)
        draw = np.random.Generator(np.random.Philox(self.seed))
        unit = draw.random((self.n, len(low)))
        if self.method == LATIN:
            strata = np.column_stack([draw.permutation(self.n) for _ in low])
            unit = (strata + unit) / self.n
        return low + (high - low) * unit

    @property
    def warnings(self) -> tuple[str, ...]:
        """What makes the sample worse than it could be, one sentence each."""
        if self.method != SOBOL or self.n.bit_count() == 1:
            return ()
        below = 1 << (self.n.bit_length() - 1)
        return (
            f"sample.n = {self.n} is not a power of 2, which Sobol's points need to be evenly "
            f"spread. Take {below} or {2 * below}.",
        )

    @property
    def problem(self) -> dict[str, object]:
        """The box as SALib wants it."""
        bounds = [list(pair) for pair in self.ranges.values()]
        return {"num_vars": len(bounds), "names": list(self.ranges), "bounds": bounds}


def library(name: str, extra: str) -> object:
    """A module of an optional package; raises MissingExtraError with what to install."""
    try:
        return import_module(name)
    except ImportError:
        raise MissingExtraError(
            f"this needs {name.partition('.')[0]}, which is not installed: "
            f"pip install 'wmr_ctrl[{extra}]'."
        ) from None
