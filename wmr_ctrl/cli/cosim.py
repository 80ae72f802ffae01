"""``wmr-ctrl cosim``: FMUs in the loop, ours or somebody else's."""

from __future__ import annotations

import click

from wmr_ctrl.cli.console import say
from wmr_ctrl.cli.options import (
    Seed,
    check_output,
    debug_option,
    examples,
    json_option,
    load,
    scenario_argument,
    set_option,
)
from wmr_ctrl.cli.progress import Progress
from wmr_ctrl.cli.run import RUNS, show


@click.command(
    short_help="Co-simulate FMUs of plant and controller.",
    epilog=examples(
        "wmr-ctrl cosim paper-simulation --law nn",
        "wmr-ctrl cosim --plant theirs.fmu --map names.toml --out run.npz",
    ),
)
@scenario_argument
@click.option("--law", default="nn", metavar="NAME", help="Control law; see `wmr-ctrl laws`.")
@click.option("--plant", metavar="FILE.fmu", help="Plant in place of ours.")
@click.option("--controller", metavar="FILE.fmu", help="Controller in place of ours.")
@click.option("--map", "map_file", metavar="FILE.toml", help="Names and units of foreign FMUs.")
@click.option(
    "--master",
    default="gauss-seidel",
    metavar="gauss-seidel|jacobi",
    help="One after the other (as the native loop), or all at once: one step of delay.",
)
@click.option("--seed", type=Seed(), default=0, metavar="S", help="Seed of all noise.")
@set_option
@click.option("--out", metavar="FILE", help="Save the run: .npz or .csv.")
@json_option("Print outcome and figures as one JSON document.")
@debug_option
def cosim(
    scenario: str,
    law: str,
    plant: str | None,
    controller: str | None,
    map_file: str | None,
    master: str,
    seed: int,
    assignments: tuple[str, ...],
    out: str | None,
    as_json: bool,
) -> None:
    """Run reference, controller and plant as FMUs, and print how it went.

    SCENARIO is the name of a preset or a TOML file. An FMU that fails ends the run; the message
    names it and the time.
    """
    from wmr_ctrl import api
    from wmr_ctrl.results import save_run

    check_output(out, RUNS, "--out")
    case = load(scenario, assignments)
    with Progress(f"{law} on {case.name}, as FMUs") as progress:
        run = api.cosimulate(
            case, law, plant=plant, controller=controller, map_file=map_file, master=master,
            seed=seed, progress=progress,
        )  # fmt: skip
    if out:
        save_run(run, out)
        say("wrote", out)
    show(run, as_json)
