"""Files of a finished reproduction: figures, tables, claims and page.  No simulation here."""

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.paper import CITATION
from wmr_ctrl.results import FIGURES, atomic_text, json_safe, make_folder
from wmr_ctrl.results.files import write_csv
from wmr_ctrl.results.table import STATISTICS, RunTable
from wmr_ctrl.simulation.batch import Progress
from wmr_ctrl.simulation.campaign import PAPER_LAWS
from wmr_ctrl.simulation.campaign.paper_runs import REPORTED

from .drawing import Drawing
from .paper_claims import RULE, Judged, Measured, Verdict, load_readings
from .report_page import Reproduction, write_page

FILES = ("report.html", "table.csv", "runs.csv", "claims.json")


@dataclass(frozen=True)
class Verdicts:
    """The verdict on every claim, the table behind it, and the files that were written."""

    judged: tuple[Judged, ...]
    table: RunTable
    folder: Path
    files: tuple[Path, ...]

    @property
    def changed(self) -> tuple[Judged, ...]:
        """Claims whose verdict differs from the committed one."""
        return tuple(one for one in self.judged if not one.as_expected)

    @property
    def as_expected(self) -> bool:
        """True if every verdict is the committed one."""
        return not self.changed

    @property
    def ok(self) -> bool:
        """Alias of :attr:`as_expected`."""
        return self.as_expected

    @property
    def report(self) -> Path:
        """The page to open."""
        return self.folder / "report.html"

    def count(self, verdict: Verdict) -> int:
        """Number of claims with this verdict."""
        return sum(1 for one in self.judged if one.verdict == verdict)

    def __str__(self) -> str:
        """One line per claim, then a summary; lines on changed verdicts if there are any."""
        wide = max((len(one.verdict.value) for one in self.judged), default=0)
        lines = [
            f"{one.verdict.value:<{wide}} {one.claim.section:<18} {one.claim.title}"
            for one in self.judged
        ]
        counts = ", ".join(f"{self.count(v)} {v.value}" for v in Verdict if self.count(v))
        changed = [
            f"CHANGED: {one.claim.id} is {one.verdict.value}, committed is {one.claim.expected}."
            for one in self.changed
        ]
        return "\n".join((*lines, "", f"{len(self.judged)} claims: {counts}.", *changed))


def write_reproduction(
    folder: str | os.PathLike[str],
    reproduction: Reproduction,
    drawings: Sequence[Drawing],
    progress: Progress | None = None,
) -> Verdicts:
    """Write report.html, table.csv, runs.csv, claims.json and figures/ into ``folder``.

    The folder is made if needed. Raises ArgumentError for runs that lack a law of the paper,
    ResultFileError if a file cannot be written.
    """
    home, table = Path(folder), reproduction.campaign.table
    missing = [law for law in PAPER_LAWS if law not in table.laws]
    if missing:
        raise ArgumentError(
            f"laws: {', '.join(missing)} is missing. The paper's claims are about "
            f"{', '.join(PAPER_LAWS)}; run these four, and others after them."
        )
    figures = home / "figures"
    make_folder(figures)
    pictures: list[Path] = []
    for count, drawing in enumerate(drawings, start=1):
        pictures += drawing.save(figures)
        if progress:
            progress(count / len(drawings))
    write_table(home / "table.csv", table)
    write_runs(home / "runs.csv", table, (), REPORTED)
    write_claims(home / "claims.json", reproduction.judged, table)
    write_page(home / "report.html", reproduction, drawings, figures)
    files = (*(home / name for name in FILES), *pictures)
    return Verdicts(reproduction.judged, table, home, files)


# -- the data: cells are empty, and JSON null, where there is no number ---------------------


def write_table(path: Path, table: RunTable) -> None:
    """One row per scenario, law and statistic over the seeds; one column per figure."""
    rows, figures = [], FIGURES.with_others(REPORTED)
    for case in table.cases:
        runs = table.case(*case)
        spreads = [runs.spread(figure.name).statistics for figure in figures]
        rows += [(*case, runs.rows, name, *(one[name] for one in spreads)) for name in STATISTICS]
    headings = (figure.heading for figure in figures)
    write_csv(path, ("scenario", "law", "seeds", "statistic", *headings), rows)


def write_runs(path: Path, table: RunTable, labels: Sequence[str], figures: Sequence[str]) -> None:
    """One row per run: scenario, law, seed, outcome, further ``labels``, and the figures."""
    columns = {"scenario": "case"} | {name: name for name in ("law", "seed", "outcome", *labels)}
    columns |= {figure.heading: figure.name for figure in FIGURES.with_others(figures)}
    rows = ([row[name] for name in columns.values()] for row in table.records())
    write_csv(path, columns, rows)


def write_claims(path: Path, judged: Sequence[Judged], table: RunTable) -> None:
    """Every claim with its tests and verdict, and the readings, as JSON."""
    content = {
        "paper": CITATION,
        "seeds": table.seeds,
        "rule": RULE,
        "as_expected": all(one.as_expected for one in judged),
        "claims": [_claim(one) for one in judged],
        "read_into_the_paper": load_readings(),
    }
    with atomic_text(path) as file:
        json.dump(json_safe(content), file, indent=1, ensure_ascii=False, allow_nan=False)
        file.write("\n")


def _claim(judged: Judged) -> dict[str, object]:
    parts = ("id", "section", "title", "quote", "threshold")
    return {
        **{name: getattr(judged.claim, name) for name in parts},
        "tests": [_test(test) for test in judged.tests],
        "verdict": judged.verdict.value,
        "expected": judged.claim.expected.value,
        "explanation": judged.explanation,
    }


def _test(test: Measured) -> dict[str, object]:
    spec, parts = test.spec, ("figure", "scenarios", "laws", "at_least", "at_most")
    return {
        "measure": spec.text,
        **{name: getattr(spec, name) for name in parts},
        "unit": spec.unit or "1",
        "found": {"seeds": len(test.values), **test.spread.statistics},
        "seeds_that_keep_it": test.keeping if spec.decides else None,
        "passed": test.passed,
    }
