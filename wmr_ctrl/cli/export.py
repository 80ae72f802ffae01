"""``wmr-ctrl export``: FMUs and the SSP package."""

from __future__ import annotations

import click

from wmr_ctrl.cli.console import say
from wmr_ctrl.cli.options import SCENARIO, check_folder, debug_option, examples, load, set_option


@click.command(
    short_help="Write FMUs for other simulation tools.",
    epilog=examples(
        "wmr-ctrl export plant --out fmus",
        "wmr-ctrl export nn --fmi 2 --target all --out fmus",
        "wmr-ctrl export closed-loop --law mb --scenario far-start --out fmus",
    ),
)
@click.argument("what", metavar="plant|LAW|reference|guard|closed-loop|ssp")
@click.option("--law", default="nn", metavar="NAME", help="Law of closed-loop and ssp.")
@click.option("--scenario", default=SCENARIO, metavar="S", help="Preset or TOML file.")
@set_option
@click.option("--fmi", default="both", type=click.Choice(["2", "3", "both"]), help="FMI version.")
@click.option(
    "--target", default="host", metavar="host|all|PLATFORM", help="Platforms to build for."
)
@click.option("--out", default=".", metavar="DIR", help="Folder to write into.")
@debug_option
def export(
    what: str,
    law: str,
    scenario: str,
    assignments: tuple[str, ...],
    fmi: str,
    target: str,
    out: str,
) -> None:
    """Write wmr_WHAT.fmi2.fmu and wmr_WHAT.fmi3.fmu, or wmr.ssp, into a folder.

    The files need no runtime and hold their sources, a page of documentation and a reference
    result.
    """
    from wmr_ctrl import api

    check_folder(out, "--out")
    case = load(scenario, assignments)
    for path in api.export_fmu(what, law=law, scenario=case, fmi=fmi, target=target, out=out):
        say("wrote", str(path))
