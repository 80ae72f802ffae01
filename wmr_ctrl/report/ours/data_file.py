"""ours.csv: a row per run of the comparison."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from wmr_ctrl.campaign.ours_run import AFTER, BEFORE, Comparison
from wmr_ctrl.report.data_files import write_csv

_WINDOWS = tuple(f"{start:g}-{end:g} s" for start, end in (BEFORE, AFTER))
HEADINGS = (
    "base",
    "case",
    "law",
    "guard",
    "seed",
    "outcome",
    "steps beyond a limit [1]",
    "max |v1|/limit [1]",
    "max |omega|/limit [1]",
    "ISE [m2.s + rad2.s]",
    *(f"mean |e1| over {window} [m]" for window in _WINDOWS),
    "peak wheel torque [N.m]",
    "share of time in clip, thrust [1]",
    "share of time in clip, moment [1]",
)


def write_ours(path: Path, rows: Iterable[Comparison]) -> None:
    """Every run with its figures; cells are empty where there is no number."""
    write_csv(path, HEADINGS, map(_cells, rows))


def _cells(row: Comparison) -> tuple[object, ...]:
    case, nothing = row.case, (None, None)
    return (
        case.base, case.factor, case.law, "on" if case.guard else "off", case.seed, row.outcome,
        None if row.speed is None else row.violations, *(row.speed or nothing), row.ise,
        row.e1_before, row.e1_after, row.tau_peak, *(row.clipped or nothing),
    )  # fmt: skip
