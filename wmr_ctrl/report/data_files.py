"""The report's data: table.csv, runs.csv and claims.json."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from wmr_ctrl.campaign import FIGURES, STATISTICS, Table
from wmr_ctrl.report.citation import CITATION
from wmr_ctrl.report.claims import Judged, Measured
from wmr_ctrl.report.claims.judge import RULE
from wmr_ctrl.results import atomic_write, json_safe

_HEADINGS = tuple(figure.heading for figure in FIGURES)


def write_table(path: Path, table: Table) -> None:
    """One row per scenario, law and statistic over the seeds; a column per figure, with its unit.

    Cells are empty where there is no number.
    """
    rows = (
        (scenario, law, len(table.case(scenario, law)), statistic,
         *(getattr(table.spread(f.name, scenario, law), statistic) for f in FIGURES))
        for scenario, law in table.cases
        for statistic in STATISTICS
    )  # fmt: skip
    write_csv(path, ("scenario", "law", "seeds", "statistic", *_HEADINGS), rows)


def write_runs(path: Path, table: Table) -> None:
    """One row per run, with all of its figures."""
    rows = (
        (row.scenario, row.law, row.seed, row.outcome, *(row.values[f.name] for f in FIGURES))
        for row in table
    )
    write_csv(path, ("scenario", "law", "seed", "outcome", *_HEADINGS), rows)


def write_claims(
    path: Path, judged: Sequence[Judged], table: Table, readings: Sequence[Mapping[str, Any]]
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


def _claim(judged: Judged) -> dict[str, Any]:
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


def _test(test: Measured) -> dict[str, Any]:
    spec, found = test.spec, test.found
    return {
        "measure": spec.text,
        "figure": spec.figure,
        "scenarios": spec.scenarios,
        "laws": spec.laws,
        "at_least": spec.at_least,
        "at_most": spec.at_most,
        "unit": spec.unit or "1",
        "found": {"seeds": len(test.values), **{s: getattr(found, s) for s in STATISTICS}},
        "seeds_that_keep_it": test.keeping if spec.decides else None,
        "passed": test.passed,
    }


def write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a header and rows, whole or not at all; None becomes an empty cell."""
    with atomic_write(path, text=True) as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)
