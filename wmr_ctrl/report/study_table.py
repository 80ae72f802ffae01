"""The table of a study for its pictures: numbers, outcomes, reasons for missing values."""

import csv
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.core.errors import ResultFileError
from wmr_ctrl.simulation.campaign.study_store import finished_study

Floats = NDArray[np.float64]
PlainPlan: TypeAlias = Mapping[str, Any]
"""A plan in plain values, as study.json has it."""
PREFERRED = ("tracking_drive_rms", "position_rms", "ise_total")
SMALL = 0.1
"""Lengths are drawn in mm where their median is below this [m]."""


@dataclass(frozen=True)
class StudyTable:
    """Plot data of a study: its plan as plain values, and the columns of its table.

    ``numbers`` has an array per numeric column (NaN: none), ``group`` law and guard of each run,
    ``ended`` its outcome, ``refusal`` the guard's reason if it refused.
    """

    plan: PlainPlan
    numbers: Mapping[str, Floats]
    group: NDArray[np.str_]
    ended: NDArray[np.str_]
    refusal: NDArray[np.str_]
    units: Mapping[str, str]

    @property
    def keys(self) -> list[str]:
        """Numeric fields that differ from run to run."""
        return [key for key in _keys(self.plan) if np.unique(self.numbers[key]).size > 1]

    @property
    def groups(self) -> list[str]:
        """Law and guard, in the plan's order."""
        return list(dict.fromkeys(self.group.tolist()))

    def scale(self, name: str) -> tuple[float, str]:
        """Plot scale of a column, and its unit then: small lengths in mm."""
        unit, values = self.units.get(name, ""), self.numbers[name]
        finite = values[np.isfinite(values)]
        small = unit == "m" and finite.size and abs(np.median(finite)) < SMALL
        return (1e3, "mm") if small else (1.0, unit)

    @property
    def figure(self) -> str:
        """The figure to draw: one of tracking, if there is any."""
        names = self.plan["figures"]
        return next((name for name in PREFERRED if name in names), names[0])

    @property
    def point(self) -> NDArray[np.intp]:
        """Index of each run's values among the points of grid and sample."""
        of_point = len(self.plan["laws"]) * len(self.plan["guard"]) * self.plan["seeds"]["count"]
        return self.numbers["index"].astype(np.intp) // of_point

    def missing(self, mask: NDArray[np.bool_]) -> str:
        """Number of runs without the drawn figure, and their outcomes; "" if all have one."""
        without = mask & ~np.isfinite(self.numbers[self.figure])
        if not without.any():
            return ""
        listed = ", ".join(sorted(set(self.ended[without].tolist())))
        return f"{without.sum()} of {mask.sum()} runs have no value of {self.figure}: {listed}"


def _keys(plan: Mapping[str, Any]) -> list[str]:
    sample = plan["sample"] or {"ranges": {}}
    return [*plan["grid"], *sample["ranges"]]


def read_study(folder: Path) -> StudyTable:
    """The table in a study's folder; raises ResultFileError without a finished one."""
    with finished_study(folder):
        plan = json.loads((folder / "study.json").read_text(encoding="utf-8"))["plan"]
        with (folder / "columns.csv").open(encoding="utf-8", newline="") as file:
            units = {row["name"]: row["unit"] for row in csv.DictReader(file)}
        with (folder / "table.csv").open(encoding="utf-8", newline="") as file:
            head, *rows = csv.reader(file)
        if not rows:
            raise ResultFileError(f"{str(folder)!r}: the study's table has no row.")
        cells = dict(zip(head, zip(*rows, strict=True), strict=True))
        wanted = ("index", *_keys(plan), *plan["figures"])
        numbers = {name: np.array([*map(_number, cells[name])]) for name in wanted}
        pairs = zip(cells["law"], cells["guard"], strict=True)
        group = [f"{law}, guarded" if guard == "true" else law for law, guard in pairs]
        ended, refusal = np.array(cells["outcome"]), np.array(cells["refusal"])
    return StudyTable(plan, numbers, np.array(group), ended, refusal, units)


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return {"true": 1.0, "false": 0.0}.get(cell, np.nan)
