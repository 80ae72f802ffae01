"""``wmr-ctrl scenarios``: the presets, and any scenario as TOML to edit."""

from __future__ import annotations

from typing import Any

import click

from wmr_ctrl.cli.console import print_json, table
from wmr_ctrl.cli.options import debug_option, examples, json_option, load, set_option


@click.command(
    short_help="List the scenarios, or print one to edit.",
    epilog=examples(
        "wmr-ctrl scenarios paper-simulation --toml > mine.toml",
        "wmr-ctrl run mine.toml",
    ),
)
@click.argument("name", required=False)
@click.option("--toml", "as_toml", is_flag=True, help="Print NAME as commented TOML (the default).")
@json_option("Print the list, or the scenario NAME, as one JSON document.")
@set_option
@debug_option
def scenarios(name: str | None, as_toml: bool, as_json: bool, assignments: tuple[str, ...]) -> None:
    """List the scenarios that come along, one line each; or print one in full.

    With NAME (a preset or a TOML file) prints every field with its unit and meaning, and every
    gain of every law: a file to edit and run.
    """
    if as_toml and as_json:
        raise click.UsageError("--toml and --json exclude each other.")
    if name is None:
        _list(as_toml, as_json, assignments)
    else:
        _print(name, as_json, assignments)


def _list(as_toml: bool, as_json: bool, assignments: tuple[str, ...]) -> None:
    from wmr_ctrl.scenario import preset_titles

    if as_toml or assignments:
        raise click.UsageError("--toml and --set need the NAME of a scenario.")
    titles = preset_titles()
    if as_json:
        print_json([{"name": name, "title": title} for name, title in titles.items()])
    else:
        click.echo(table(titles.items()))


def _print(name: str, as_json: bool, assignments: tuple[str, ...]) -> None:
    from wmr_ctrl.scenario import scenario_dict, to_toml

    scenario = load(name, assignments)
    if as_json:
        print_json({"name": scenario.name, **scenario_dict(scenario)})
    else:
        click.echo(to_toml(scenario, gains_docs=gains_docs()), nl=False)


Docs = dict[str, dict[str, tuple[Any, str, str]]]


def gains_docs() -> Docs:
    """Default, unit and meaning of every gain, by law; the kinematic loop's first."""
    from wmr_ctrl.control.setup import KINEMATICS
    from wmr_ctrl.laws import LAWS
    from wmr_ctrl.model.auxiliary import KinematicGains

    tables: dict[str, type] = {KINEMATICS: KinematicGains}
    tables |= {law: LAWS[law].gains for law in LAWS}
    return {law: _documented(gains) for law, gains in tables.items()}


def _documented(gains: type) -> dict[str, tuple[Any, str, str]]:
    from wmr_ctrl.scenario import quantities

    return {name: (what.default, what.unit, what.doc) for name, what in quantities(gains)}
