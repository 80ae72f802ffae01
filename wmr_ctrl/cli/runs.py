"""``wmr-ctrl run``, ``cosim`` and ``show``: one run, a run of given FMUs, a saved run or drive."""

from __future__ import annotations

import shlex
from typing import TYPE_CHECKING, Unpack

import click

from wmr_ctrl.core.errors import UnknownNameError

from . import options as opt
from .console import FMU_FAILED, Progress, print_json, say, write_file

if TYPE_CHECKING:
    from wmr_ctrl.export.api_types import CosimulationOptions
    from wmr_ctrl.results import Run
    from wmr_ctrl.world.scenario import Scenario


@opt.command("run")
def run(
    scenario: str,
    law: str | None,
    guard: bool | None,
    seed: int,
    engine: str,
    plant: str,
    assignments: tuple[str, ...],
    verbose: bool,
    as_json: bool,
    **files: str | None,
) -> None:
    """Run one law on one scenario, and print how it went.

    SCENARIO is the name of a preset (see `wmr-ctrl scenarios`) or a TOML file. Objections of
    `wmr-ctrl check`, and keys that you state without effect, are named on stderr before the run. A
    run that breaks the velocity limit, diverges, spins its wheels or falls over is a result like
    any other: the exit code is 0, and the outcome says so. Existing result files are replaced once
    the new ones are complete.
    """
    from wmr_ctrl.control.laws.registry import LAWS

    case = opt.load(scenario, assignments, guard)
    _check_engine(engine, plant)
    chosen = opt.law_of(case, law)
    opt.note_idle(case, scenario, assignments, [chosen])
    sets = (part for text in assignments for part in ("--set", text))
    guarded = () if guard is None else ("--guard" if guard else "--no-guard",)
    own = LAWS.spelled(chosen)
    why = shlex.join(("wmr-ctrl", "check", scenario, *sets, *guarded, "--law", own))
    finished = _simulated(case, chosen, law is not None, seed, engine, plant, why)
    deliver(finished, as_json, verbose, **files)


@opt.command("show")
def show_saved(
    file: str, verbose: bool, as_json: bool, topics: str | None, **files: str | None
) -> None:
    """Print how a saved run went, and draw, animate or convert it.

    RUN is a file that `wmr-ctrl run --out` or `Run.save` wrote, or a robot's own ROS 2 bag (its
    folder, .mcap or .db3; extra `logs`). For a bag, the columns are listed with their rates, gaps
    and ranges, and then the missing ones. A bag has no desired motion, so there is no verdict.
    """
    from wmr_ctrl.results import RecordedDrive
    from wmr_ctrl.results.bag_topics import load_source

    saved = load_source(file, opt.roles(topics))
    if isinstance(saved, RecordedDrive):
        from .summary import show_drive

        show_drive(saved, as_json, **files)
        return
    write_run(saved, **files)
    show(saved, as_json, verbose)


def _check_engine(engine: str, plant: str) -> None:
    from wmr_ctrl import api
    from wmr_ctrl.simulation.engines import check_plant

    if engine not in api.ENGINES:
        raise UnknownNameError("engine", engine, api.ENGINES)
    check_plant(plant)


def _simulated(
    scenario: Scenario, law: str, asked: bool, seed: int, engine: str, plant: str, why: str
) -> Run:
    """Simulate, after printing theory's objections and the command ``why`` that explains them."""
    from wmr_ctrl import api
    from wmr_ctrl.control.setup import settle
    from wmr_ctrl.results import NOT_CHECKED
    from wmr_ctrl.theory.checks import grip_warnings, warnings_heard

    setup = settle(scenario, law)
    theory = (*warnings_heard(setup, asked), *(grip_warnings(setup) if plant == "mujoco" else ()))
    theory = tuple(item for item in theory if item.key != NOT_CHECKED)  # the run's remarks say it
    for label, noun, objects in (("warning", "objection", True), ("note", "note", False)):
        keys = dict.fromkeys(item.key for item in theory if item.objects is objects)
        if keys:
            count = f"{len(keys)} {noun}{'s' * (len(keys) > 1)} of theory ({', '.join(keys)})"
            say(label, f"{count}: {why} {f'--only {next(iter(keys))}' if len(keys) == 1 else '-v'}")
    with Progress(f"{law} on {scenario.name}") as progress:
        return api.simulate(scenario, law, seed=seed, engine=engine, plant=plant, progress=progress)


def deliver(run: Run, as_json: bool, verbose: bool, **files: str | None) -> None:
    """Write a new run's files and print it; exit with code 3 if an FMU ended the run."""
    if run.monitor.failure and not run.rows:  # nothing can be drawn
        files = {name: file for name, file in files.items() if name in ("out", "report")}
    write_run(run, **files)
    show(run, as_json, verbose)
    if run.monitor.failure:
        say("error", run.monitor.failure)
        raise click.exceptions.Exit(FMU_FAILED)


def write_run(run: Run, **files: str | None) -> None:
    """Save, draw and animate a run, each if its file is named (out, plot, report, animate)."""
    write_file(files.get("out"), "save_run", run)
    write_file(files.get("plot"), "plot_run", run)
    write_file(files.get("report"), "write_run_page", run)
    write_file(files.get("animate"), "animate_runs", [run], "animation")


def show(run: Run, as_json: bool, verbose: bool = False) -> None:
    """Print a finished run: verdict and table, or the JSON document."""
    from wmr_ctrl.results import summary

    if as_json:
        print_json(summary(run))
    else:
        from .summary import summary_text

        click.echo(summary_text(run, verbose))


@opt.command("cosim")
def cosim(
    scenario: str,
    law: str | None,
    guard: bool | None,
    assignments: tuple[str, ...],
    out: str | None,
    plot: str | None,
    report: str | None,
    verbose: bool,
    as_json: bool,
    map_template: str | None,
    **options: Unpack[CosimulationOptions],
) -> None:
    """Run reference, controller and plant as FMUs, and print how it went.

    SCENARIO is the name of a preset or a TOML file. With --guard the velocity guard limits the
    torques of --controller, too; on a base that takes velocities the scenario's filter limits its
    commands. What FMUs print goes to stderr. An FMU that fails ends the run: the message names it,
    the time and the call, and the exit code is 3; what was simulated until then is printed and
    saved as usual.
    """
    from wmr_ctrl import api
    from wmr_ctrl.export.cosim.fitting import law_within

    file = options.get("controller")
    if map_template:
        from wmr_ctrl.export.cosim.map_template import write_map_template

        written = write_map_template(map_template, options.get("plant"), file)
        click.echo(f"wrote: {written}")
        return
    case = opt.load(scenario, assignments, guard)
    read = law_within(file) if file and not law else opt.law_of(case, law)
    opt.note_idle(case, scenario, assignments, [read] if read else [])
    with Progress(f"{law or 'the controller'} on {case.name}, as FMUs") as progress:
        options["progress"] = progress
        run = api.cosimulate(case, law, **options)
    deliver(run, as_json, verbose, out=out, plot=plot, report=report)
