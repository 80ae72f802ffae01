"""The log: one row per control sample, columns in the order of ``signals.LOG_HEAD``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from wmr_ctrl.signals import LOG_HEAD
from wmr_ctrl.sim.oracle.arrays import FloatArray


class Recorder:
    """Collects rows of values by column name."""

    def __init__(self, further: Mapping[str, Any]) -> None:
        self.sizes = {signal.name: signal.size for signal in LOG_HEAD}
        self.sizes.update(
            {name: len(v) if isinstance(v, tuple) else 1 for name, v in further.items()}
        )
        self.rows: dict[str, list[Any]] = {name: [] for name in self.sizes}

    def write(self, row: Mapping[str, Any]) -> None:
        """Append one row, which must name every column and nothing else."""
        if row.keys() != self.rows.keys():
            raise KeyError(f"columns that differ: {sorted(row.keys() ^ self.rows.keys())}")
        for name, value in row.items():
            self.rows[name].append(value)

    def columns(self) -> dict[str, FloatArray]:
        """Arrays (N,), or (N, size) for vectors, also when there is no row."""
        return {
            name: np.array(self.rows[name], dtype=float).reshape(-1 if size == 1 else (-1, size))
            for name, size in self.sizes.items()
        }
