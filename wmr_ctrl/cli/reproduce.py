"""``wmr-ctrl reproduce``: the main job."""

from __future__ import annotations

from typing import Any

import click

from wmr_ctrl.cli.console import say
from wmr_ctrl.cli.failures import DIFFERENCE
from wmr_ctrl.cli.options import check_folder, debug_option
from wmr_ctrl.cli.progress import Progress

SEEDS, QUICK = 20, 3


@click.command(short_help="Rerun the paper's Sections V and VI and judge its claims.")
@click.option("--quick", is_flag=True, help=f"{QUICK} seeds: the same claims, sooner.")
@click.option(
    "--seeds",
    type=click.IntRange(min=1),
    metavar="N",
    help=f"Runs of each law and scenario.  [default: {SEEDS}, or {QUICK} with --quick]",
)
@click.option(
    "--jobs",
    type=click.IntRange(min=1),
    metavar="N",
    help="Runs at the same time.  [default: one per processor]",
)
@click.option(
    "--with-ours",
    is_flag=True,
    help="Then compare all laws, ours too, with and without the guard: about a minute more.",
)
@click.option(
    "--with-physics",
    is_flag=True,
    help="Then put the laws on a rigid body with tyres: minutes more; needs the extra physics.",
)
@click.option("--out", default="reproduction", metavar="DIR", help="Folder for the results.")
@debug_option
@click.pass_context
def reproduce(
    ctx: click.Context,
    quick: bool,
    seeds: int | None,
    jobs: int | None,
    with_ours: bool,
    with_physics: bool,
    out: str,
) -> None:
    """Rerun the paper's Sections V and VI with all laws, and judge its claims.

    Writes DIR/report.html (one self-contained file), every panel of Fig. 3 and Fig. 5 as SVG and
    PNG, table.csv and claims.json; with --with-ours also ours.csv, and a section on what lies past
    the paper; with --with-physics rigid.csv, and a section on the robot as a rigid body on tyres.
    The exit code is 0 if every verdict is the one that this release states, 1 if not.
    """
    check_folder(out, "--out")
    from wmr_ctrl import api

    wanted: dict[str, Any] = {
        "seeds": seeds or SEEDS,
        "quick": quick and seeds is None,
        "jobs": jobs,
        "with_ours": with_ours,
        "with_physics": with_physics,
    }
    with Progress("reproduce") as progress:
        verdicts = api.reproduce(out, progress=progress, **wanted)
    say("wrote", str(verdicts.report))
    click.echo(str(verdicts))
    if not verdicts.as_expected:
        ctx.exit(DIFFERENCE)
