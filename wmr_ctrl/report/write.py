"""Writing a finished reproduction: its figures, tables, claims and page.  Nothing is run here."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from wmr_ctrl.campaign import PAPER_LAWS, Campaign, PhaseProgress, Silent
from wmr_ctrl.errors import ArgumentError, ResultFileError
from wmr_ctrl.report.comparison_figures import comparison_figures
from wmr_ctrl.report.data_files import (
    write_claims,
    write_comparison,
    write_rigid,
    write_runs,
    write_table,
)
from wmr_ctrl.report.drawing import Drawing
from wmr_ctrl.report.guarantee_figures import guarantee_figures
from wmr_ctrl.report.guard_section import guard_section
from wmr_ctrl.report.measure_figures import measure_figures
from wmr_ctrl.report.page import Page, load_readings, write_page
from wmr_ctrl.report.paper_figures import paper_figure
from wmr_ctrl.report.reproduction import Reproduction, Verdicts
from wmr_ctrl.report.rigid_section import rigid_figures, rigid_section
from wmr_ctrl.results import check_writable, make_folder

FILES = ("report.html", "table.csv", "runs.csv", "claims.json")
COMPARISON_FILE, RIGID_FILE = "ours.csv", "rigid.csv"


def write_reproduction(
    folder: str | os.PathLike[str],
    reproduction: Reproduction,
    progress: PhaseProgress | None = None,
) -> Verdicts:
    """Write report.html, table.csv, runs.csv, claims.json and figures/ into ``folder``.

    The folder is made if needed; rows of the comparison past the paper add a section, figures and
    ours.csv, those with the rigid body a section, figures and rigid.csv.  Raises ArgumentError for
    runs that lack a law of the paper, ResultFileError where a file cannot be written.
    """
    home, table = Path(folder), reproduction.campaign.table
    _check_laws(table.laws)
    figures = home / "figures"
    make_folder(figures)
    compared, rigid = reproduction.comparison, reproduction.rigid
    past = comparison_figures(compared) if compared else ()
    fall = rigid_figures(rigid) if rigid.table else ()
    drawings = (*all_drawings(reproduction.campaign), *past, *fall)
    pictures = _draw(drawings, figures, progress or Silent())
    section = guard_section(compared, past) if compared else None
    body = rigid_section(rigid.table, fall) if rigid.table else None
    write_table(home / "table.csv", table)
    write_runs(home / "runs.csv", table)
    write_claims(home / "claims.json", reproduction.judged, table, load_readings())
    write_page(home / "report.html", Page(reproduction, drawings, figures, section, body))
    if compared:
        write_comparison(home / COMPARISON_FILE, compared)
    if rigid.table:
        write_rigid(home / RIGID_FILE, rigid.table)
    names = file_names(bool(compared), bool(rigid.table))
    files = (*(home / name for name in names), *pictures)
    return Verdicts(reproduction.judged, table, home, files)


def file_names(with_comparison: bool, with_rigid: bool = False) -> tuple[str, ...]:
    """The files beside the folder of figures."""
    more = ((COMPARISON_FILE, with_comparison), (RIGID_FILE, with_rigid))
    return (*FILES, *(name for name, wanted in more if wanted))


def all_drawings(campaign: Campaign) -> tuple[Drawing, ...]:
    """Every figure of the report but those of the comparison, in its order."""
    laws = campaign.table.laws
    fig3 = {law: campaign.runs["paper-simulation", law] for law in laws}
    fig5 = {law: campaign.runs["paper-experiment", law] for law in laws}
    return (
        *paper_figure(3, fig3, "simulation of Section V"),
        *paper_figure(5, fig5, "experiment of Section VI, simulated"),
        *measure_figures(campaign),
        *guarantee_figures(campaign),
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


def _check_laws(laws: Sequence[str]) -> None:
    missing = [law for law in PAPER_LAWS if law not in set(laws)]
    if missing:
        raise ArgumentError(
            f"laws: {', '.join(missing)} is missing. The paper's claims are about "
            f"{', '.join(PAPER_LAWS)}; run these four, and others after them."
        )


def _draw(drawings: Sequence[Drawing], folder: Path, progress: PhaseProgress) -> list[Path]:
    progress.start(len(drawings), "Drawing the figures")
    paths: list[Path] = []
    try:
        for drawing in drawings:
            paths += drawing.save(folder)
            progress.advance(1)
    finally:
        progress.done()
    return paths
