"""``wmr-ctrl linearize``: poles, margins and sampled-data limits."""

from __future__ import annotations

import click

from wmr_ctrl.cli.console import print_json, say
from wmr_ctrl.cli.options import (
    LawName,
    check_folder,
    debug_option,
    json_option,
    load,
    scenario_argument,
    set_option,
)
from wmr_ctrl.cli.progress import Progress


@click.command(short_help="Poles, margins and the largest stable sample time.")
@scenario_argument
@click.option(
    "--law", type=LawName(), default="nn", metavar="NAME", help="Control law; see `wmr-ctrl laws`."
)
@set_option
@click.option(
    "--at",
    type=float,
    metavar="SECONDS",
    help="Time of the reference at which figures are taken.  [default: where it drives fastest]",
)
@click.option(
    "--guard",
    is_flag=True,
    help="Switch the velocity guard on; refused where it acts on the reference at that time.",
)
@click.option(
    "--plot",
    metavar="DIR",
    help="Also draw Bode, Nyquist, poles, sample times and the barrier's pull into the folder DIR.",
)
@json_option("Print all figures as one JSON document.")
@debug_option
def linearize(
    scenario: str,
    law: str,
    assignments: tuple[str, ...],
    at: float | None,
    guard: bool,
    plot: str | None,
    as_json: bool,
) -> None:
    """Linearise the closed loop along the reference, exactly, and print what that tells.

    Around the circle and the line the loop is time-invariant in error coordinates.  Along other
    references poles and margins are those of a time, which is said; spectral radius, unless at a
    time, and largest stable period are those of a whole period of the reference, or of its worst
    point where it does not repeat.
    """
    from wmr_ctrl.linear import report_linear

    if plot:
        check_folder(plot, "--plot")
    with Progress(f"{law}, linearised") as progress:
        report = report_linear(load(scenario, assignments), law, at, guard=guard, progress=progress)
        progress.start(1, "pictures")
        paths = report.plots(plot, progress) if plot else ()
    if as_json:
        print_json(report.to_json())
    else:
        click.echo(report.table())
    for path in paths:
        say("wrote", str(path))
