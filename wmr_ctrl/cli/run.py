"""``wmr-ctrl run``: one law on one scenario."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from wmr_ctrl.cli.console import print_json, say
from wmr_ctrl.cli.failures import FMU_FAILED
from wmr_ctrl.cli.options import (
    LawName,
    Seed,
    check_output,
    debug_option,
    examples,
    guard_option,
    json_option,
    load,
    scenario_argument,
    set_option,
)
from wmr_ctrl.cli.progress import Progress
from wmr_ctrl.errors import UnknownNameError

if TYPE_CHECKING:
    from wmr_ctrl.results import Run
    from wmr_ctrl.scenario import Scenario

RUNS, PLOTS, ANIMATIONS = (
    (".npz", ".csv", ".parquet"),
    (".png", ".svg", ".pdf"),
    (".gif", ".mp4", ".html"),
)
film_option = click.option(
    "--film", metavar="FILE", help="Film the rigid body in 3-D (--plant mujoco): .mp4 or .gif."
)


@click.command(
    short_help="Run one law on one scenario.",
    epilog=examples(
        "wmr-ctrl run                          # law and scenario of the paper",
        "wmr-ctrl run far-start --law mb --plot mb.png",
        "wmr-ctrl run mine.toml --set clock.control=0.02 --json",
        "wmr-ctrl run --plant mujoco --film fall.mp4",
    ),
)
@scenario_argument
@click.option(
    "--law", type=LawName(), default="nn", metavar="NAME", help="Control law; see `wmr-ctrl laws`."
)
@guard_option
@click.option("--seed", type=Seed(), default=0, metavar="S", help="Seed of all noise.")
@click.option(
    "--engine",
    default="native",
    metavar="native|numpy|fmu",
    help="Compiled C; the same graphs without a compiler, slower; or our own FMUs, coupled.",
)
@click.option(
    "--plant",
    default="ode",
    metavar="ode|mujoco",
    help="The plane model, or a rigid body on tyres (extra physics).",
)
@set_option
@click.option("--out", metavar="FILE", help="Save the run: .npz, .csv or .parquet.")
@click.option("--plot", metavar="FILE", help="Draw the run: .png, .svg or .pdf.")
@click.option("--animate", metavar="FILE", help="Film the robot on its path: .gif, .mp4 or .html.")
@film_option
@json_option("Print outcome and figures as one JSON document.")
@debug_option
def run(
    scenario: str,
    law: str,
    guard: bool | None,
    seed: int,
    engine: str,
    plant: str,
    assignments: tuple[str, ...],
    out: str | None,
    plot: str | None,
    animate: str | None,
    film: str | None,
    as_json: bool,
) -> None:
    """Run one law on one scenario, and print how it went.

    SCENARIO is the name of a preset (see `wmr-ctrl scenarios`) or a TOML file. What theory says
    against the run is printed on stderr before it. A run that breaks the velocity limit or
    diverges, spins its wheels or falls over is a result like any other: the exit code is 0, and
    the outcome says so. A file that is named for a result is replaced, once the new one is whole.
    """
    check_outputs(out, plot, animate)
    if film:
        from wmr_ctrl.report.film import check_film

        check_film(film, plant)
    case = load(scenario, assignments, guard)
    finished = _simulated(case, law, seed, engine, plant)
    write_run(finished, out, plot, animate, film)
    show(finished, as_json)
    end(finished)


def check_outputs(out: str | None, plot: str | None, animate: str | None) -> None:
    """Raise, before anything is computed, where one of the files cannot be written."""
    check_output(out, RUNS, "--out")
    if out and out.lower().endswith(".parquet"):
        from wmr_ctrl.results.frames import library

        library("pyarrow")
    check_output(plot, PLOTS, "--plot")
    check_output(animate, ANIMATIONS, "--animate")
    if animate and animate.lower().endswith(".mp4"):
        from wmr_ctrl.report.animate import find_ffmpeg

        find_ffmpeg()


def _simulated(scenario: Scenario, law: str, seed: int, engine: str, plant: str) -> Run:
    from wmr_ctrl import api
    from wmr_ctrl.checks import grip_warnings, warnings_for
    from wmr_ctrl.control.setup import settle
    from wmr_ctrl.engines import check_plant

    if engine not in api.ENGINES:
        raise UnknownNameError("engine", engine, api.ENGINES)
    check_plant(plant)
    setup = settle(scenario, law)
    for warning in (*warnings_for(setup), *(grip_warnings(setup) if plant == "mujoco" else ())):
        say("warning" if warning.objects else "note", str(warning))
    measured = engine != "native" or plant == "mujoco"
    with Progress(f"{law} on {scenario.name}", measured=measured) as progress:
        return api.simulate(scenario, law, seed=seed, engine=engine, plant=plant, progress=progress)


def write_run(
    run: Run,
    out: str | None,
    plot: str | None = None,
    animate: str | None = None,
    film: str | None = None,
) -> None:
    """Save, draw and film a run, each where a file is named."""
    if out:
        from wmr_ctrl.results import save_run

        save_run(run, out)
        say("wrote", out)
    if plot:
        from wmr_ctrl.report.plot_run import plot_run

        plot_run(run, plot)
        say("wrote", plot)
    if animate:
        from wmr_ctrl.report.animate import animate_run

        with Progress("animation") as progress:
            animate_run(run, animate, progress=progress)
        say("wrote", animate)
    if film:
        from wmr_ctrl.outputs import film_run

        with Progress("film") as progress:
            film_run(run, film, progress)
        say("wrote", film)


def end(run: Run) -> None:
    """Exit with the code of a failure, and the reason, where an FMU ended the run."""
    if run.monitor.failure:
        say("error", run.monitor.failure)
        raise click.exceptions.Exit(FMU_FAILED)


def show(run: Run, as_json: bool) -> None:
    """Print a finished run: a table, or the JSON document."""
    from wmr_ctrl.results import summary

    if as_json:
        print_json(summary(run))
    else:
        from wmr_ctrl.cli.summary import summary_text

        click.echo(summary_text(run))
