"""Shares of a study's runs that kept the limits and that tracked, by law, guard and grid point."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.core.errors import show
from wmr_ctrl.results import Outcome, percent

from .study_table import StudyTable

MOST_CELLS = 24
"""Cells above which only laws and guards are told apart."""
KEPT = (Outcome.COMPLETED, Outcome.BOUNDS_LEFT, Outcome.SLIPPED)
"""Outcomes of runs within the limits."""
SHARE_HEADS = ("", "runs", "kept the limits", "tracked")


@dataclass(frozen=True)
class Share:
    """Runs of a cell: their number, the share that kept the limits, and the share that tracked.

    ``refused``: runs that the guard refused, which are not among ``runs``; a share is None if no
    run was made, or the study does not have the figure.
    """

    cell: str
    runs: int
    refused: int
    kept: float | None
    tracked: float | None

    @property
    def cells(self) -> tuple[str, ...]:
        """Cells of a table's row, in the order of `SHARE_HEADS`."""
        shares = ("-" if one is None else percent(one) for one in (self.kept, self.tracked))
        refused = f" ({self.refused} refused)" if self.refused else ""
        return self.cell, f"{self.runs}{refused}", *shares


def shares_of(table: StudyTable) -> list[Share]:
    """Shares by law and guard, and by point of a grid with few points."""
    cells = [(group, table.group == group) for group in table.groups]
    grid = table.plan["grid"]
    if grid and not table.plan["sample"]:
        points = [
            ", ".join(f"{key} = {show(value)}" for key, value in zip(grid, values, strict=True))
            for values in product(*grid.values())
        ]
        if len(points) * len(cells) <= MOST_CELLS:
            cells = [
                (f"{group}, {words}", mask & (table.point == place))
                for group, mask in cells
                for place, words in enumerate(points)
            ]
    return [*_shares(table, cells)]


def _shares(table: StudyTable, cells: list[tuple[str, NDArray[np.bool_]]]) -> Iterator[Share]:
    made = table.refusal == ""
    kept = np.isin(table.ended, KEPT)
    if "violated" in table.numbers:
        kept = table.numbers["violated"] == 0
    tracked = table.numbers.get("tracked")
    for name, mask in cells:
        runs = mask & made
        count = int(runs.sum())
        yield Share(
            name,
            count,
            int(mask.sum()) - count,
            float(kept[runs].mean()) if count else None,
            float(tracked[runs].mean()) if count and tracked is not None else None,
        )
