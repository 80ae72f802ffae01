"""Where MB breaks its limit at 20 ms, from a million starts.

``python -m analysis.limit_map [gpu]`` writes limit_map.npz, which notebook 12
draws.  Each run is that of `runs`, on every machine.
"""

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl import simulate_many
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.world.scenario import Scenario

CELLS, SEEDS = 500, 4
REACH = 3.0
"""Starts lie within so many metres of the scenario's, in x and in y."""
TURNED = 1.5
"""Their orientation is the scenario's and so much more [rad]."""
LAW = "mb"
FILE = Path(__file__).with_name("limit_map.npz")
Counts = NDArray[np.uint8]


def scenario(*, guard: bool = False) -> Scenario:
    """The paper's simulation over 8 s, at a control period of 20 ms."""
    return scenario_of(
        "paper-simulation", {"clock.duration": 8.0, "clock.control": 0.02}, guard=guard
    )


def places() -> NDArray[np.float64]:
    """Offsets of the middles of the cells of one axis [m]."""
    return REACH * ((2.0 * np.arange(CELLS) + 1.0) / CELLS - 1.0)


def runs(rows: NDArray[np.intp], columns: NDArray[np.intp], device: str = "cpu") -> Counts:
    """Of each cell (row: y, column: x), how many of its seeds broke the limit."""
    base, offset = scenario(), places()
    x, y, theta = base.initial.pose
    each = np.column_stack([x + offset[columns], y + offset[rows]])
    starts = [(*where, theta + TURNED, *base.initial.velocity) for where in each.tolist()]
    every = [start for start in starts for _ in range(SEEDS)]
    table = simulate_many(base, LAW, [*range(SEEDS)] * len(starts), starts=every, device=device)
    broken = (table["violations"] > 0).reshape(-1, SEEDS)
    return broken.sum(axis=1).astype(np.uint8)


def main(device: str = "cpu") -> None:
    """Make all runs and write the file."""
    rows, columns = (axis.ravel() for axis in np.indices((CELLS, CELLS)))
    np.savez_compressed(FILE, broken=runs(rows, columns, device).reshape(CELLS, CELLS))


def counts() -> Counts:
    """Of each cell, how many of its seeds broke the limit, (CELLS, CELLS), as it was made."""
    with np.load(FILE) as archive:
        return np.asarray(archive["broken"])


if __name__ == "__main__":
    main(*sys.argv[1:])
