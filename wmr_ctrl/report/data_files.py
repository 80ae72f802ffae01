"""The report's data: table.csv, runs.csv, claims.json and ours.csv."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from wmr_ctrl.campaign import STATISTICS, FigureTable, RunRow
from wmr_ctrl.campaign.comparison import AWAY, E1, E1_BEFORE, FARTHEST
from wmr_ctrl.campaign.rigid import COMPARED
from wmr_ctrl.campaign.table import reported
from wmr_ctrl.report.claims import RULE, Judged, Measured
from wmr_ctrl.results import atomic_write, json_safe
from wmr_ctrl.results.windows import BEFORE, LATE

CITATION = (
    "Z. Chen, Y. Liu, W. He, H. Qiao, and H. Ji, “Adaptive-Neural-Network-Based Trajectory "
    "Tracking Control for a Nonholonomic Wheeled Mobile Robot With Velocity Constraints,” "
    "IEEE Transactions on Industrial Electronics, vol. 68, no. 6, pp. 5057–5067, June 2021, "
    "doi:10.1109/TIE.2020.2989711."
)
"""The paper that is rerun."""


def _headings() -> tuple[str, ...]:
    return tuple(figure.heading for figure in reported())


def write_table(path: Path, table: FigureTable) -> None:
    """One row per scenario, law and statistic over the seeds; a column per figure, with its unit.

    Cells are empty where there is no number.
    """
    rows = (row for case in table.cases for row in _statistic_rows(table, *case))
    write_csv(path, ("scenario", "law", "seeds", "statistic", *_headings()), rows)


def _statistic_rows(table: FigureTable, scenario: str, law: str) -> Iterator[Sequence[object]]:
    seeds = len(table.case(scenario, law))
    spreads = [table.spread(figure.name, scenario, law).statistics for figure in reported()]
    for name in STATISTICS:
        yield scenario, law, seeds, name, *(numbers[name] for numbers in spreads)


def write_runs(path: Path, table: FigureTable) -> None:
    """One row per run, with all of its figures."""
    rows = (
        (
            row.case.name,
            row.case.law,
            row.seed,
            row.outcome,
            *(row.values[f.name] for f in reported()),
        )
        for row in table
    )
    write_csv(path, ("scenario", "law", "seed", "outcome", *_headings()), rows)


def write_claims(
    path: Path,
    judged: Sequence[Judged],
    table: FigureTable,
    readings: Sequence[Mapping[str, object]],
) -> None:
    """Every claim with its tests and verdict, and the readings, as JSON (null for no number)."""
    content = {
        "paper": CITATION,
        "seeds": sorted({row.seed for row in table}),
        "rule": RULE,
        "as_expected": all(one.as_expected for one in judged),
        "claims": [_claim(one) for one in judged],
        "read_into_the_paper": list(readings),
    }
    with atomic_write(path, text=True) as file:
        json.dump(json_safe(content), file, indent=1, ensure_ascii=False, allow_nan=False)
        file.write("\n")


def _claim(judged: Judged) -> dict[str, object]:
    claim = judged.claim
    return {
        "id": claim.id,
        "section": claim.section,
        "title": claim.title,
        "quote": claim.quote,
        "threshold": claim.threshold,
        "tests": [_test(test) for test in judged.tests],
        "verdict": judged.verdict.value,
        "expected": claim.expected.value,
        "explanation": judged.explanation,
    }


def _test(test: Measured) -> dict[str, object]:
    spec = test.spec
    return {
        "measure": spec.text,
        "figure": spec.figure,
        "scenarios": spec.scenarios,
        "laws": spec.laws,
        "at_least": spec.at_least,
        "at_most": spec.at_most,
        "unit": spec.unit or "1",
        "found": {"seeds": len(test.values), **test.spread.statistics},
        "seeds_that_keep_it": test.keeping if spec.decides else None,
        "passed": test.passed,
    }


def write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a header and rows, whole or not at all; None becomes an empty cell."""
    with atomic_write(path, text=True) as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


_WINDOWS = tuple(f"{start:g}-{end:g} s" for start, end in (BEFORE, LATE))
_COMPARISON_HEADINGS = (
    "base",
    "case",
    "law",
    "guard",
    "seed",
    "outcome",
    "steps beyond a limit [1]",
    "max |v1|/limit [1]",
    "max |omega|/limit [1]",
    f"RMS distance over {_WINDOWS[-1]} [m]",
    f"largest distance over {_WINDOWS[-1]} [m]",
    "ISE [m2.s + rad2.s]",
    *(f"mean |e1| over {window} [m]" for window in _WINDOWS),
    "peak wheel torque [N.m]",
    "share of time in clip, thrust [1]",
    "share of time in clip, moment [1]",
)


def write_comparison(path: Path, rows: Iterable[RunRow]) -> None:
    """Every run with its figures; cells are empty where there is no number."""
    write_csv(path, _COMPARISON_HEADINGS, map(_cells, rows))


def _cells(row: RunRow) -> tuple[object, ...]:
    case, steps = row.case, row["violations"]
    speeds, shares = ("limit_ratio1", "limit_ratio2"), ("guard_share1", "guard_share2")
    return (
        case.base, case.name, case.law, "on" if case.guard else "off", row.seed, row.outcome,
        None if steps is None else int(steps), *map(row.__getitem__, speeds), row[AWAY],
        row[FARTHEST], row["ise_total"], row[E1_BEFORE], row[E1], row["tau_peak"],
        *(row[name] if case.guard else None for name in shares),
    )  # fmt: skip


_RIGID_HEADINGS = (
    "case",
    "law",
    "seed",
    "plant",
    "outcome",
    "ISE [m2.s + rad2.s]",
    f"RMS of e1 over {_WINDOWS[0]} [m]",
    f"RMS of e1 over {_WINDOWS[1]} [m]",
    "max |v|/limit [1]",
    "first slip [s]",
    "fall [s]",
)


def write_rigid(path: Path, rows: Iterable[RunRow]) -> None:
    """Every run on either plant; cells are empty where there is no number."""
    cells = (
        (r.case.name, r.case.law, r.seed, r.case.plant, r.outcome, *map(r.__getitem__, COMPARED))
        for r in rows
    )
    write_csv(path, _RIGID_HEADINGS, cells)
