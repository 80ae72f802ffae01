"""``wmr-ctrl cosim``: FMUs in the loop, ours or somebody else's."""

from __future__ import annotations

from typing import TYPE_CHECKING, Unpack

import click

from wmr_ctrl.cli import options as opt
from wmr_ctrl.cli.progress import Progress
from wmr_ctrl.cli.runs import check_outputs, deliver, figures_option, plot_option, save_option

if TYPE_CHECKING:
    from wmr_ctrl.api_types import CosimulationOptions


@click.command(
    short_help="Co-simulate FMUs of plant and controller.",
    epilog=opt.examples(
        "wmr-ctrl cosim paper-simulation --law nn",
        "wmr-ctrl cosim --plant theirs.fmu --map names.toml --out run.npz",
        "wmr-ctrl cosim --controller theirs.fmu --map names.toml --guard",
        "wmr-ctrl cosim --law prox --guard --master jacobi --know-delay",
    ),
)
@opt.scenario_argument
@click.option(
    "--law",
    type=opt.LawName(),
    metavar="NAME",
    help="Control law; see `wmr-ctrl laws`. Not with a foreign controller.  [default: that of the "
    "controller if it is ours, else nn]",
)
@opt.guard_option
@click.option("--plant", metavar="FILE.fmu", help="Plant to use instead of ours.")
@click.option("--controller", metavar="FILE.fmu", help="Controller to use instead of ours.")
@click.option("--map", "map_file", metavar="FILE.toml", help="Names and units of foreign FMUs.")
@click.option(
    "--master",
    default="gauss-seidel",
    metavar="gauss-seidel|jacobi",
    help="Step the FMUs one after the other (like the native loop), or all at once, which delays "
    "the torque by one step.",
)
@click.option(
    "--know-delay",
    "delay_known",
    is_flag=True,
    help="With jacobi: build the controller for torques that act one control period late.",
)
@opt.seed_option
@opt.set_option
@save_option
@plot_option
@figures_option
@opt.debug_option
def cosim(
    scenario: str,
    law: str | None,
    guard: bool | None,
    assignments: tuple[str, ...],
    out: str | None,
    plot: str | None,
    as_json: bool,
    **options: Unpack[CosimulationOptions],
) -> None:
    """Run reference, controller and plant as FMUs, and print how it went.

    SCENARIO is the name of a preset or a TOML file. With --guard the velocity guard limits the
    torques of --controller, too. An FMU that fails ends the run: the message names it, the time and
    the call, and the exit code is 3; what was simulated until then is printed and saved as usual.
    """
    from wmr_ctrl import api

    check_outputs(out, plot)
    case = opt.load(scenario, assignments, guard)
    with Progress(f"{law or 'the controller'} on {case.name}, as FMUs") as progress:
        options["progress"] = progress
        run = api.cosimulate(case, law, **options)
    deliver(run, as_json, out=out, plot=plot)
