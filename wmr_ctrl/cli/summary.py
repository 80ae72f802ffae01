"""A run's verdict and figures as text; a recorded drive as ``show`` and ``compare`` print it."""

from collections.abc import Iterator, Mapping
from itertools import product

import click

from wmr_ctrl import results
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.report.run_rows import guard_relies_on, is_foreign, rows_of
from wmr_ctrl.results import Run
from wmr_ctrl.results.drive import NEVER, RecordedDrive, drive_of
from wmr_ctrl.results.frames import FAULTS, FMUS
from wmr_ctrl.theory.checks.outlook import scenario_of_run
from wmr_ctrl.theory.checks.unknown_zero import promise_of_run

from .check_sentences import remedy
from .console import print_json, say, table, wrapped, write_file
from .options import check_output


def summary_text(run: Run, verbose: bool = False) -> str:
    """Text on a run: law, scenario, engine, verdict, and the figures that suit its base.

    ``verbose``: remarks in full, the guard's assumptions, and all figures.
    """
    guarded = ", guarded" if run.guard else ""
    rigid = "" if run.monitor.rigid is None else f", {run.settings.plant_kind} plant"
    head = [f"{run.law}{guarded} on {run.scenario}, seed {run.seed}, {run.engine} engine{rigid}"]
    head += map(wrapped, changes_of(run))
    labels = {name: run.provenance.get(f"fmu_{name}") for name in FMUS}
    if is_foreign(run):
        labels["plant"] = f"{labels['plant']}; watched every {run.settings.plant:g} s"
    head += [wrapped(f"{name}: {label}", hang="  ") for name, label in labels.items() if label]
    for name, fault in product(FMUS, FAULTS):
        if said := run.provenance.get(f"{fault}_{name}"):
            head.append(wrapped(f"{name} {fault} in {said}", hang="  "))
    remarks = [wrapped(f"- {text}", hang="  ") for text in _unsaid(run, verbose)]
    verdict = [wrapped(run.explanation), wrapped(promise_of_run(run)), *remarks]
    verdict.append(wrapped(guard_relies_on(run)) if verbose else "")
    told = "\n".join(filter(None, verdict))
    return "\n\n".join(("\n".join(head), told, table(rows_of(run, verbose))))


def changes_of(run: Run) -> list[str]:
    """Sentences on how the robot changed during a run, one for each time of change."""
    case = scenario_of_run(run)
    return [] if case is None else [item.sentence for item in case.changes]


def _unsaid(run: Run, verbose: bool) -> Iterator[str]:
    """Remarks that the outcome does not already state, and objections of `check`, each once.

    Their short remedy is used if there is one, unless ``verbose``.
    """
    told = (run.outcome.value, results.OBJECTED)
    texts = [(item.key, item.text) for item in run.remarks if item.key not in told]
    texts = [(key, text) for key, text in texts if text not in run.explanation]
    texts += [(w.key, w.sentence) for w in (run.outlook.objections if run.outlook else ())]
    lines = (f"{key}: {(not verbose and remedy(key)) or text}" for key, text in texts)
    yield from dict.fromkeys(lines)


COLUMNS = ("", "samples", "to [s]", "gap [ms]", "least", "largest")
FIGURES = (
    ("way [m]", "way"), ("|v1|", "max_abs_v1"), ("|omega|", "max_abs_v2"), ("torque", "tau_peak"),
)  # fmt: skip
"""Columns of a comparison's table."""
NOTHING_JUDGED = f"A bag has no {NEVER}, so nothing is judged."


def show_drive(drive: RecordedDrive, as_json: bool, **files: str | None) -> None:
    """Save and draw a drive, as `write_run` does for a run, and print it."""
    out = files["out"]
    check_output(out, (".csv",), "--out of a drive")
    draw_drives([drive], files["plot"], files["animate"], files["report"])
    if out:
        drive.save(out)
        say("wrote", out)
    if as_json:
        print_json(drive.summary())
    else:
        click.echo(drive_text(drive))


def drives_of(sources: Mapping[str, Run | RecordedDrive]) -> list[RecordedDrive]:
    """Drives and runs by name as drives of these names."""
    return [
        drive_of(one, name)
        if isinstance(one, Run)
        else RecordedDrive(name, one.times, one.columns, one.remarks)
        for name, one in sources.items()
    ]


def draw_drives(drives: list[RecordedDrive], plot: str | None, *others: str | None) -> None:
    """Draw drives into the named file; refuse the ``others``."""
    if any(others):
        raise ArgumentError(
            "--report and --animate are of a run, which a recorded drive is not. Use --plot."
        )
    write_file(plot, "plot_drives", drives)


def drive_text(drive: RecordedDrive) -> str:
    """Columns of a drive with times, longest gaps and ranges, and a list of missing columns."""
    rows = [
        (f"{name} [{fact.unit}]", str(fact.samples), f"{fact.last:.4g}",
         f"{1e3 * fact.longest_gap:.3g}", f"{fact.least:.4g}", f"{fact.largest:.4g}")
        for name, fact in drive.facts().items()
    ]  # fmt: skip
    way = drive.figures()["way"]
    driven = "" if way is None else f", {way:.4g} m by its poses"
    parts = [f"{drive.name}: a drive of {drive.duration:.4g} s{driven}", table(rows, COLUMNS)]
    parts.append("\n".join((wrapped(NOTHING_JUDGED), *_notes(drive))))
    return "\n\n".join(parts)


def drives_text(drives: list[RecordedDrive]) -> str:
    """Table of the figures of drives, followed by missing columns and remarks on each drive."""
    rows = []
    for drive in drives:
        figures = drive.figures()
        values = [figures[key] for _, key in FIGURES]
        cells = ("-" if value is None else f"{value:.4g}" for value in values)
        rows.append((drive.name, f"{drive.duration:.4g}", *cells))
    lines = [table(rows, ("drive", "time [s]", *(word for word, _ in FIGURES))), ""]
    lines.append(wrapped(NOTHING_JUDGED))
    for drive in drives:
        lines += [wrapped(f"{drive.name}:"), *_notes(drive)]
    return "\n".join(lines)


def _notes(drive: RecordedDrive) -> Iterator[str]:
    lacks = [f"not there: {', '.join(drive.missing)}"] if drive.missing else []
    return (wrapped(f"- {text}", hang="  ") for text in (*lacks, *drive.remarks))
