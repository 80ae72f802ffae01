"""The main job: run Sections V and VI, judge the claims, draw, and write the report."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from wmr_ctrl.campaign import (
    PAPER_LAWS,
    Campaign,
    Prepare,
    Progress,
    Silent,
    Simulate,
    paper_plan,
    run_campaign,
)
from wmr_ctrl.campaign.ours_run import Comparison
from wmr_ctrl.errors import ArgumentError, ResultFileError
from wmr_ctrl.report.claims import Evidence, judge_all
from wmr_ctrl.report.data_files import write_claims, write_runs, write_table
from wmr_ctrl.report.drawing import Drawing
from wmr_ctrl.report.extras import extra_figures
from wmr_ctrl.report.html import Page, write_report
from wmr_ctrl.report.ours import our_figures, our_section, write_ours
from wmr_ctrl.report.ours.rows import Rows
from wmr_ctrl.report.paper_figures import paper_figure
from wmr_ctrl.report.readings import load_readings
from wmr_ctrl.report.verdicts import Verdicts
from wmr_ctrl.results import check_writable

QUICK_SEEDS = 3
FILES = ("report.html", "table.csv", "runs.csv", "claims.json")
OURS = "ours.csv"

Compare: TypeAlias = Callable[[int | None, Progress], tuple[Comparison, ...]]
"""(jobs, progress) -> the rows of the comparison past the paper."""


def reproduce(
    simulate: Simulate,
    prepare: Prepare,
    laws: Sequence[str] = PAPER_LAWS,
    seeds: int = 20,
    quick: bool = False,
    jobs: int | None = None,
    out: str | os.PathLike[str] = "reproduction",
    progress: Progress | None = None,
    facts: Mapping[str, Any] | None = None,
    compare: Compare | None = None,
) -> Verdicts:
    """Rerun the paper and write report.html, table.csv, runs.csv, claims.json and figures/.

    ``laws`` must contain the paper's four, others are shown beside them; ``quick`` takes 3 seeds.
    ``facts`` may hold ``titles`` (law -> text), ``timings`` (law -> s per 10,000 evaluations),
    ``readings`` (entries with key, value, unit, why) and ``versions`` (name -> text).  ``compare``,
    if given, runs the comparison past the paper, which becomes a section of its own and ours.csv.
    Nothing is written before all runs are done.  Raises ArgumentError for seeds, jobs or laws that
    cannot be, ResultFileError where ``out`` cannot be written, both before the first run.
    """
    folder = Path(out)
    _check_laws(laws)
    plan = paper_plan(laws, QUICK_SEEDS if quick else seeds)
    check_folder(folder, (*FILES, OURS) if compare else FILES)
    shown = progress or Silent()
    campaign = run_campaign(simulate, prepare, plan, jobs, shown)
    ours = compare(jobs, shown) if compare else ()
    return report(campaign, folder, shown, facts or {}, ours)


def report(
    campaign: Campaign,
    folder: Path,
    progress: Progress,
    facts: Mapping[str, Any],
    ours: tuple[Comparison, ...] = (),
) -> Verdicts:
    """Judge a campaign and write everything about it into ``folder``, which is made if needed.

    ``ours`` are the rows of the comparison past the paper, if it was run.
    """
    judged = judge_all(Evidence(campaign.table, facts.get("timings") or {}))
    figures = folder / "figures"
    _make(figures)
    past = our_figures(Rows(ours)) if ours else ()
    drawings = (*all_drawings(campaign), *past)
    pictures = _draw(drawings, figures, progress)
    section = our_section(Rows(ours), past) if ours else None
    page = Page(campaign, judged, drawings, figures, load_readings(), facts, section)
    write_table(folder / "table.csv", campaign.table)
    write_runs(folder / "runs.csv", campaign.table)
    write_claims(folder / "claims.json", judged, campaign.table, page.readings)
    write_report(folder / "report.html", page)
    if ours:
        write_ours(folder / OURS, ours)
    names = (*FILES, OURS) if ours else FILES
    files = (*(folder / name for name in names), *pictures)
    return Verdicts(judged, campaign.table, folder, files)


def all_drawings(campaign: Campaign) -> tuple[Drawing, ...]:
    """Every figure of the report, in its order."""
    laws = campaign.table.laws
    fig3 = {law: campaign.runs["paper-simulation", law] for law in laws}
    fig5 = {law: campaign.runs["paper-experiment", law] for law in laws}
    return (
        *paper_figure(3, fig3, "simulation of Section V"),
        *paper_figure(5, fig5, "experiment of Section VI, simulated"),
        *extra_figures(campaign),
    )


def check_folder(folder: Path, names: Sequence[str] = FILES) -> None:
    """Raise ResultFileError if it is plain that files ``names`` cannot be written to ``folder``."""
    known = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not known.is_dir():
        raise ResultFileError(
            f"cannot write to {str(folder)!r}: {str(known)!r} is not a folder. "
            "Give the name of a folder."
        )
    if not os.access(known, os.W_OK | os.X_OK):
        raise ResultFileError(
            f"cannot write to {str(folder)!r}: {str(known)!r} may not be written to. "
            "Choose another folder, or allow writing to this one."
        )
    for name in names if known == folder else ():
        check_writable(folder / name)


def _check_laws(laws: Iterable[str]) -> None:
    missing = [law for law in PAPER_LAWS if law not in set(laws)]
    if missing:
        raise ArgumentError(
            f"laws: {', '.join(missing)} is missing. The paper's claims are about "
            f"{', '.join(PAPER_LAWS)}; name these four, and others after them."
        )


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = os.strerror(error.errno or errno.EIO)
        raise ResultFileError(
            f"cannot make the folder {str(folder)!r}: {reason}. Choose another folder."
        ) from error


def _draw(drawings: Sequence[Drawing], folder: Path, progress: Progress) -> list[Path]:
    progress.start(len(drawings), "Drawing the figures")
    paths: list[Path] = []
    try:
        for drawing in drawings:
            paths += drawing.save(folder)
            progress.advance(1)
    finally:
        progress.done()
    return paths
