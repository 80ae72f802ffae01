"""A robot's drive, as ``show`` and ``compare`` print it."""

from collections.abc import Mapping
from dataclasses import asdict

import click

from wmr_ctrl.cli.console import print_json, say, table, wrapped
from wmr_ctrl.cli.options import check_output
from wmr_ctrl.cli.progress import Progress
from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.results import Run
from wmr_ctrl.results.drive import NEVER, RecordedDrive, drive_of

COLUMNS = ("", "samples", "to [s]", "gap [ms]", "least", "largest")
FIGURES = (
    ("way [m]", "way"), ("|v1|", "max_abs_v1"), ("|omega|", "max_abs_v2"), ("torque", "tau_peak"),
)  # fmt: skip
"""Columns of a comparison's table."""
NOTHING_JUDGED = f"A bag has no {NEVER}, so nothing is judged."


def show_drive(
    drive: RecordedDrive,
    as_json: bool,
    out: str | None = None,
    plot: str | None = None,
    animate: str | None = None,
    film: str | None = None,
) -> None:
    """Save, draw and film a drive, each where a file is named, and print it."""
    check_output(out, (".csv",), "--out of a drive")
    if film:
        raise ArgumentError(
            "--film simulates a run again on the rigid body, and a recorded drive cannot be "
            "simulated. Use --animate."
        )
    _draw([drive], plot, animate)
    if out:
        drive.save(out)
        say("wrote", out)
    if as_json:
        print_json(drive.summary())
    else:
        click.echo(drive_text(drive))


def compare_sources(
    sources: Mapping[str, Run | RecordedDrive],
    tolerance: float,
    plot: str | None,
    animate: str | None,
    as_json: bool,
) -> bool:
    """Print drives beside each other, runs as their bases tell them; False where two differ."""
    from wmr_ctrl.results.compare import compare

    drives = [_named(name, one) for name, one in sources.items()]
    _draw(drives, plot, animate)
    pair = compare(drives[0], drives[1], tolerance) if len(drives) == 2 else None
    if not as_json:
        text = drives_text(drives)
        click.echo(text if pair is None else f"{pair}\n\n{text}")
    else:
        print_json([drive.summary() for drive in drives] if pair is None else asdict(pair))
    return pair is None or pair.verdict in ("equal", "agree")


def _named(name: str, one: Run | RecordedDrive) -> RecordedDrive:
    if isinstance(one, Run):
        return drive_of(one, name)
    return RecordedDrive(name, one.times, one.columns, one.remarks)


def _draw(drives: list[RecordedDrive], plot: str | None, animate: str | None) -> None:
    if animate:  # first, since it may have nothing to show
        from wmr_ctrl.report.animate import animate_drives

        with Progress("animation") as progress:
            animate_drives(drives, animate, progress)
        say("wrote", animate)
    if plot:
        from wmr_ctrl.report.plot_drive import plot_drives

        plot_drives(drives, plot)
        say("wrote", plot)


def drive_text(drive: RecordedDrive) -> str:
    """Columns of a drive with their times, longest gaps and ranges, and what is missing."""
    rows = [
        (f"{name} [{fact.unit}]", str(fact.samples), f"{fact.last:.4g}",
         f"{1e3 * fact.longest_gap:.3g}", f"{fact.least:.4g}", f"{fact.largest:.4g}")
        for name, fact in drive.facts().items()
    ]  # fmt: skip
    way = drive.figures()["way"]
    driven = "" if way is None else f", {way:.4g} m by its poses"
    parts = [f"{drive.name}: a drive of {drive.duration:.4g} s{driven}", table(rows, COLUMNS)]
    parts.append("\n".join((wrapped(NOTHING_JUDGED), *_lacks(drive), *_remarks(drive))))
    return "\n\n".join(parts)


def drives_text(drives: list[RecordedDrive]) -> str:
    """Figures of drives as a table, then what each lacks and what is said of it."""
    rows = []
    for drive in drives:
        figures = drive.figures()
        values = [figures[key] for _, key in FIGURES]
        cells = ("-" if value is None else f"{value:.4g}" for value in values)
        rows.append((drive.name, f"{drive.duration:.4g}", *cells))
    lines = [table(rows, ("drive", "time [s]", *(word for word, _ in FIGURES))), ""]
    lines.append(wrapped(NOTHING_JUDGED))
    for drive in drives:
        lines += [wrapped(f"{drive.name}:"), *_lacks(drive), *_remarks(drive)]
    return "\n".join(lines)


def _lacks(drive: RecordedDrive) -> list[str]:
    if not drive.missing:
        return []
    return [wrapped(f"- not there: {', '.join(drive.missing)}", hang="  ")]


def _remarks(drive: RecordedDrive) -> list[str]:
    return [wrapped(f"- {text}", hang="  ") for text in drive.remarks]
