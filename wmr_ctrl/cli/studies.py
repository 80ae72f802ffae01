"""``wmr-ctrl study`` and ``tune``: many runs by a plan, or in search of gains."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from . import options as opt
from .console import DIFFERENCE, Progress, print_json, resumable, say, short_number, table, wrapped

if TYPE_CHECKING:
    from wmr_ctrl.simulation.campaign.study_run import StudyOutcome
    from wmr_ctrl.simulation.tuning import Tuning


@opt.command("study")
def study(
    words: tuple[str, ...],
    out: str | None,
    executor: str,
    device: str,
    jobs: int | None,
    report: str | None,
    as_json: bool,
) -> None:
    """Run everything that PLAN.toml names, and write DIR/table.csv with one row per run.

    A plan names a scenario, laws, guards and seeds, values of fields ([grid]), ranges of fields
    ([sample]) and a rule to stop ([stop]). The table has the same bytes for any executor, any
    number of jobs, and after interruptions. `study plot DIR` draws its pictures. The output ends
    with the shares of runs that kept the limits and that tracked. If the guard refused every run,
    the exit code is 1.
    """
    if words[0] == "plot" and len(words) == 2:
        if report or out:
            raise click.UsageError("--out and --report belong to a study that is run.")
        from wmr_ctrl.report.study_figures import plot_study

        with Progress("drawing"):
            paths = plot_study(words[1])
        if as_json:
            print_json([str(path) for path in paths])
        for path in paths:
            say("wrote", str(path))
        return
    if len(words) != 1 or out is None:
        raise click.UsageError("give PLAN.toml and --out DIR, or `plot DIR`.")
    opt.check_folder(out, "--out")
    from wmr_ctrl import api
    from wmr_ctrl.simulation.campaign.study_plan import load_plan

    from .check_sentences import unread_k

    plan = load_plan(words[0])
    opt.check_output(report, (".html",), "--report")
    for text in unread_k(plan.loaded, plan.laws, plan.stated):
        say("note", text)
    with resumable(Path(out)), Progress("study") as progress:
        result = api.study(
            plan, out, executor=executor, device=device, jobs=jobs, progress=progress
        )
    if report:
        from wmr_ctrl.report.study_page import write_study_page

        write_study_page(result.folder, report, Path(words[0]).read_text(encoding="utf-8"))
        say("wrote", report)
    _show_study(result, as_json)
    if result.all_refused:
        raise click.exceptions.Exit(DIFFERENCE)


def _show_study(result: StudyOutcome, as_json: bool) -> None:
    """Print the numbers of runs, and the shares of runs that kept the limits and that tracked."""
    from wmr_ctrl.report.study_shares import SHARE_HEADS, shares_of
    from wmr_ctrl.report.study_table import read_study

    shares = shares_of(read_study(result.folder))
    if as_json:
        plain = {k: str(v) if k in ("folder", "table") else v for k, v in asdict(result).items()}
        print_json({**plain, "shares": [asdict(share) for share in shares]})
        return
    head, *refused = str(result).split("\n")
    click.echo("\n".join((head, *(wrapped(f"- {text}", hang="  ") for text in refused))))
    click.echo(f"\n{table([share.cells for share in shares], SHARE_HEADS)}")


ROUNDING = (
    "There was nothing to tune: the first objective is rounding. Do not take these gains; state "
    "what disturbs your robot, its noise, delays and pushes."
)


@opt.command("tune")
def tune(
    scenario: str,
    law: str,
    out: str,
    seeds: range,
    test_seeds: range,
    trials: int,
    weight: float,
    hold: tuple[str, ...],
    merit: str,
    jobs: int | None,
    assignments: tuple[str, ...],
    as_json: bool,
) -> None:
    """Search for gains that track well with little torque, even if the robot's mass differs.

    Minimises the root of the mean of position_rms^2 + (W torque_change_rms)^2 over the training
    seeds, for the scenario's robot and for 0.6 and 1.6 times the assumed mass, with the guard off;
    on a base that takes velocities position_rms alone.
    With --merit corridor the certified corridor takes the place of position_rms; gains with a
    certificate rank above all without one, which are ranked by the linear loop's deviation. Fewer
    runs that end early rank above a smaller objective. Writes the scenario with the gains found,
    and shows how they perform on test seeds and on references that were not used for training.
    """
    from wmr_ctrl.simulation import tuning

    case = opt.load(scenario, assignments)
    opt.note_idle(case, scenario, assignments, [law])
    with Progress(f"tune {law}") as progress:
        better = tuning.tune(
            case,
            law,
            out,
            seeds=seeds,
            test_seeds=test_seeds,
            trials=trials,
            weight=weight,
            hold=[key.strip() for keys in hold for key in keys.split(",")],
            merit=merit,
            jobs=jobs,
            progress=progress,
        )
    say("wrote", out)
    if as_json:
        print_json(better.to_json())
    else:
        click.echo(_text(better))


def _text(better: Tuning) -> str:
    """Summary of a tuning: gains, objective, and figures of the test seeds before and after."""
    import numpy as np

    from wmr_ctrl.core.fields.units import length
    from wmr_ctrl.simulation.tuning.gains import FLOOR
    from wmr_ctrl.simulation.tuning.search import CORRIDOR

    first, last = better.objective
    lines = [f"{key} = {', '.join(f'{v:g}' for v in value)}" for key, value in better.gains.items()]
    lines.append(f"objective on the training seeds: {first.sentence} before, {last.sentence} after")
    if first.metres < FLOOR:
        lines.append(wrapped(ROUNDING))
    if better.plan.merit == CORRIDOR:
        before, after = ("none" if most is None else length(most) for most in better.corridor)
        lines.append(f"certified corridor: {before} before, {after} after")
    v1, omega = better.scenario.limits.v_u1
    both = better.before, better.after
    position = [[*map(short_number, 1e3 * test["tracking_drive_rms"])] for test in both]
    change = [[*map(short_number, test["torque_change_rms"])] for test in both]
    fastest = [np.maximum(test["max_abs_v1"] / v1, test["max_abs_v2"] / omega) for test in both]
    lost = [test["lost"] for test in both]
    columns = {
        "reference": [row["reference"] for row in better.after.records()],
        "mass": [f"{value:g}" for value in better.after["mass"]],
        "position RMS\n[mm]": map(" -> ".join, zip(*position, strict=True)),
        "torque change\n[N m]": map(" -> ".join, zip(*change, strict=True)),
        "ended\nearly": ("{:g} -> {:g}".format(*two) for two in zip(*lost, strict=True)),
        "worst\n|v|/limit": ("{:.2f} -> {:.2f}".format(*two) for two in zip(*fastest, strict=True)),
    }
    if better.scenario.takes_velocity:
        del columns["mass"], columns["torque change\n[N m]"]
    lines += [
        "",
        "Test seeds, before -> after:",
        table(zip(*columns.values(), strict=True), tuple(columns)),
    ]
    return "\n".join(lines)
