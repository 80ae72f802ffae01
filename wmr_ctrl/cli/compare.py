"""``wmr-ctrl compare``: laws on one scenario, or saved runs and drives, side by side."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.units import limits_in_words

from . import options as opt
from .console import (
    DIFFERENCE,
    LEAST,
    Progress,
    print_json,
    say,
    short_number,
    table,
    wrapped,
    write_file,
)

if TYPE_CHECKING:
    from wmr_ctrl.results import RecordedDrive, Run

HEADER: tuple[str, ...] = ("law", "RMS", "max", "|v1|", "|omega|", "peak", "change", "outcome")
TORQUES = ("tau_peak", "torque_change_rms")
COLUMNS = (
    ("tracking_drive_rms", 1e3),
    ("tracking_drive_max", 1e3),
    ("max_abs_v1", 1.0),
    ("max_abs_v2", 1.0),
    *((name, 1.0) for name in TORQUES),
)
"""Figures of the table's columns, and their factor."""


@opt.command("compare")
@click.pass_context
def compare(
    ctx: click.Context,
    sources: tuple[str, ...],
    laws: tuple[str, ...],
    guard: bool | None,
    seed: int,
    assignments: tuple[str, ...],
    tolerance: float,
    plot: str | None,
    animate: str | None,
    topics: str | None,
    as_json: bool,
) -> None:
    """Compare laws on one scenario, or saved runs, side by side.

    With --law, SCENARIO (a preset or TOML file) is run with each of the laws, and a table shows the
    figures of all. For saved runs the same table is printed. For two runs, their differences are
    listed as well: which columns differ, by how much and when. The exit code is then 0 if they are
    equal or agree within the tolerance, and 1 if they differ or have no sample in common. A robot's
    own ROS 2 bag may take the place of a run; then the figures that a bag can have are shown side
    by side: pose, velocities, commands, torques and wheels.
    """
    from wmr_ctrl.results import Run
    from wmr_ctrl.results.compare import compare as difference

    from .summary import draw_drives, drives_of, drives_text

    loaded = (
        dict(_simulated(sources, laws, seed, assignments, guard))
        if laws
        else _loaded(sources, opt.roles(topics))
    )
    runs = {name: one for name, one in loaded.items() if isinstance(one, Run)}
    drives = drives_of(loaded) if len(runs) < len(loaded) else []
    if drives:
        draw_drives(drives, plot, animate)
        if as_json:
            print_json([drive.summary() for drive in drives])
        else:
            click.echo(drives_text(drives))
        return
    write_file(plot, "plot_runs", [*runs.values()])
    write_file(animate, "animate_runs", [*runs.values()], "animation")
    pair = None
    if not laws and len(runs) == 2:
        first, second = runs.values()
        pair = difference(first, second, tolerance)
    if not as_json:
        text = comparison_text(runs)
        click.echo(text if pair is None else f"{pair}\n\n{text}")
    elif pair is None:
        print_json({name: run.summary() for name, run in runs.items()})
    else:
        print_json(asdict(pair))
    if pair is not None and pair.verdict not in ("equal", "agree"):
        ctx.exit(DIFFERENCE)


def _simulated(
    sources: Sequence[str],
    names: Sequence[str],
    seed: int,
    assignments: Sequence[str],
    guard: bool | None,
) -> Iterator[tuple[str, Run]]:
    from wmr_ctrl import api
    from wmr_ctrl.control.laws.registry import LAWS

    from .check_answers import laws_for

    if len(sources) > 1:
        raise ArgumentError(
            f"--law runs one scenario, and {len(sources)} were named. Name one preset or TOML "
            "file, or compare saved runs without --law."
        )
    source = sources[0] if sources else opt.SCENARIO
    scenario = opt.load(source, assignments, guard)
    for name in names:
        LAWS[name]  # raises for a name that is none, before anything runs
    if {*LAWS} <= {*names}:
        possible = laws_for(scenario)
        if lost := [name for name in LAWS if name not in possible]:
            say("note", f"without {', '.join(lost)}, which need what the scenario does not state.")
        names = [name for name in names if name not in lost]
    opt.note_idle(scenario, source, assignments, names)
    for name in names:
        with Progress(f"{name} on {scenario.name}"):
            yield name, api.simulate(scenario, name, seed=seed)


def _loaded(sources: Sequence[str], topics: Mapping[str, str]) -> dict[str, Run | RecordedDrive]:
    from wmr_ctrl.results.bag import is_bag
    from wmr_ctrl.results.bag_topics import load_source

    if len(sources) == 1 and (Path(sources[0]).suffix.lower() in opt.RUNS or is_bag(sources[0])):
        raise click.UsageError("Missing argument 'RUN_B': give two or more saved runs to compare.")
    if len(sources) < 2:
        raise click.UsageError(
            "Missing option '--law': name the laws to compare on a scenario, such as "
            "--law prox,mb or --law all, or two saved runs."
        )
    runs: dict[str, Run | RecordedDrive] = {}
    for source in sources:  # a run may be compared with itself
        name = source if source not in runs else f"{source} ({len(runs) + 1})"
        runs[name] = load_source(source, topics if is_bag(source) else None)
    return runs


def comparison_text(runs: dict[str, Run]) -> str:
    """Figures of runs by name as a table, a line that explains its columns, and the remarks."""
    from wmr_ctrl.report.run_rows import takes_velocities
    from wmr_ctrl.results import driving, labouring

    from .summary import changes_of

    def each(words: Callable[[Run], str]) -> str:
        return " or ".join(dict.fromkeys(map(words, runs.values())))

    about = (
        f"RMS, max: distance from the desired position over the {each(driving)} [mm]. |v1|, "
        f"|omega|: largest over the run, limits {each(_limits)}."
    )
    rows = [HEADER, *(_row(name, run) for name, run in runs.items())]
    if all(map(takes_velocities, runs.values())):
        rows = [(*row[:-3], row[-1]) for row in rows]
    else:
        about += (
            " peak: largest wheel torque of the run; change: its RMS from sample to sample over "
            f"the {each(labouring)} [N m]."
        )
    said = dict.fromkeys(text for run in runs.values() for text in changes_of(run))
    lines = [
        *map(wrapped, said),
        table(rows[1:], rows[0]),
        "",
        wrapped(about),
    ]
    for name, run in runs.items():
        keys = dict.fromkeys(item.key for item in run.remarks if item.key != run.outcome.value)
        if keys:
            lines.append(wrapped(f"- {name}: {', '.join(keys)}", hang="  "))
    return "\n".join(lines)


def _limits(run: Run) -> str:
    return limits_in_words(run.settings.sides)


def _row(name: str, run: Run) -> tuple[str, ...]:
    from wmr_ctrl.report.run_rows import takes_velocities
    from wmr_ctrl.results import FIGURES, values_of
    from wmr_ctrl.theory.checks.outlook import scenario_of_run
    from wmr_ctrl.theory.checks.unknown_zero import finest

    values: dict[str, Any] = values_of(run, [FIGURES[figure] for figure, _ in COLUMNS])
    least = finest(scenario_of_run(run))
    if takes_velocities(run):  # nobody commands its torques
        values |= dict.fromkeys(TORQUES)
    known = ((figure, factor, values[figure]) for figure, factor in COLUMNS)
    cells = (
        "-" if value is None else
        short_number(factor * value, factor * least if figure.startswith("tracking") else LEAST)
        for figure, factor, value in known
    )  # fmt: skip
    return (name, *cells, run.outcome.value)
