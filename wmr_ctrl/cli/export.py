"""``wmr-ctrl export``: FMUs and the SSP package."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, cast

import click

from wmr_ctrl.cli.console import say
from wmr_ctrl.cli.options import SCENARIO, check_folder, debug_option, examples, load, set_option

if TYPE_CHECKING:
    from wmr_ctrl.api_types import ExportOptions


@click.command(
    short_help="Write FMUs for other simulation tools.",
    epilog=examples(
        "wmr-ctrl export plant --out fmus",
        "wmr-ctrl export nn --fmi 2 --target all --out fmus",
        "wmr-ctrl export closed-loop --law mb --scenario far-start --out fmus",
        "wmr-ctrl export ssp --flat --law pid --out package",
        "wmr-ctrl export ssp --plant theirs.fmu --map names.toml --out package",
        "wmr-ctrl export modelica --out models",
        "wmr-ctrl export simulink --law mb --out kit",
    ),
)
@click.argument("what", metavar="plant|LAW|reference|guard|closed-loop|ssp|modelica|simulink")
@click.option("--law", default="nn", metavar="NAME", help="Law of closed-loop, ssp and simulink.")
@click.option("--scenario", default=SCENARIO, metavar="S", help="Preset or TOML file.")
@set_option
@click.option("--fmi", default="both", type=click.Choice(["2", "3", "both"]), help="FMI version.")
@click.option(
    "--target", default="host", metavar="host|all|PLATFORM", help="Platforms to build for."
)
@click.option("--plant", metavar="FILE.fmu", help="ssp: plant in place of ours, with a map.")
@click.option("--controller", metavar="FILE.fmu", help="ssp: controller in place of ours.")
@click.option("--map", "map_file", metavar="FILE.toml", help="ssp: names and units of these.")
@click.option(
    "--know-delay", is_flag=True, help="ssp: build the law for torques that act a period late."
)
@click.option(
    "--flat", is_flag=True, help="ssp: without connectors of the system, for ecos and libcosim."
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
    plant: str | None,
    controller: str | None,
    map_file: str | None,
    know_delay: bool,
    flat: bool,
    out: str,
) -> None:
    """Write wmr_WHAT.fmi2.fmu and wmr_WHAT.fmi3.fmu, wmr.ssp or WheeledRobot.mo into a folder.

    FMUs need no runtime and hold their sources, a page of documentation and a reference result.
    The Modelica package has plant, every law and a loop of each, as equations and functions; the
    Simulink kit an S-function of one law, and a script that builds the loop.
    """
    from wmr_ctrl import api
    from wmr_ctrl.outputs import read_by

    options: ExportOptions = {
        "law": law, "fmi": fmi, "target": target, "plant": plant, "controller": controller,
        "map_file": map_file, "delay_known": know_delay, "flat": flat, "out": out,
    }  # fmt: skip
    _refuse_unread(what, [name for name in options if name not in read_by(what)])
    check_folder(out, "--out")
    options["scenario"] = load(scenario, assignments)
    given = {name: value for name, value in options.items() if name in read_by(what)}
    paths = api.export_fmu(what, **cast("ExportOptions", given))
    for path in paths:
        say("wrote", str(path))


def _refuse_unread(what: str, names: Sequence[str]) -> None:
    """Refuse options that this output would not read."""
    context = click.get_current_context()
    for name in ("know_delay" if name == "delay_known" else name for name in names):
        if context.get_parameter_source(name) is click.core.ParameterSource.COMMANDLINE:
            hint = "--" + name.removesuffix("_file").replace("_", "-")
            raise click.BadParameter(f"{what} does not read it. Leave it out.", param_hint=hint)
