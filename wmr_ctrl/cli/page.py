"""``wmr-ctrl page``: one HTML file in which the compiled loop runs live."""

from __future__ import annotations

import click

from wmr_ctrl.cli.console import say
from wmr_ctrl.cli.options import (
    SCENARIO,
    Seed,
    check_output,
    debug_option,
    examples,
    load,
    set_option,
)
from wmr_ctrl.cli.progress import Progress


@click.command(
    short_help="Write a page in which the robot can be dragged and pushed.",
    epilog=examples(
        "wmr-ctrl page --out robot.html",
        "wmr-ctrl page --out mine.html --scenario mine.toml --law nn --law prox",
    ),
)
@click.option("--out", required=True, metavar="FILE.html", help="File to write.")
@click.option("--scenario", default=SCENARIO, metavar="S", help="Preset or TOML file.")
@set_option
@click.option(
    "--law",
    "laws",
    multiple=True,
    metavar="NAME",
    help="A law that can be chosen on the page.  May be given several times.  [default: all]",
)
@click.option("--seed", type=Seed(), default=0, metavar="S", help="Seed of all noise.")
@debug_option
def page(
    out: str, scenario: str, assignments: tuple[str, ...], laws: tuple[str, ...], seed: int
) -> None:
    """Write one HTML file, without server or network, that runs the closed loop in a browser.

    It is the compiled loop of this program, with the same numbers to the bit. For the paper's
    simulation it tells a story in five steps; for another scenario it shows that. The first page
    takes a minute or two to compile.
    """
    from wmr_ctrl import api

    check_output(out, (".html",), "--out")
    case = load(scenario, assignments)
    with Progress("compiling the page") as progress:
        path = api.write_page(out, case, laws=laws or None, seed=seed, progress=progress)
    say("wrote", str(path))
