"""``wmr-ctrl scenarios``: the presets, and any scenario as TOML to edit."""

from __future__ import annotations

import json
from typing import Any

import click

from wmr_ctrl.cli.console import print_json, table, wrapped
from wmr_ctrl.cli.options import debug_option, examples, json_option, load, set_option


@click.command(
    short_help="List the scenarios, or print one to edit.",
    epilog=examples(
        "wmr-ctrl scenarios paper-simulation --toml > mine.toml",
        "wmr-ctrl run mine.toml",
        "wmr-ctrl scenarios --reference waypoints",
    ),
)
@click.argument("name", required=False)
@click.option("--toml", "as_toml", is_flag=True, help="Print NAME as commented TOML (the default).")
@json_option("Print the list, or the scenario NAME, as one JSON document.")
@click.option("--reference", "kind", metavar="KIND", help="Print a reference's keys and example.")
@set_option
@debug_option
def scenarios(
    name: str | None,
    as_toml: bool,
    as_json: bool,
    kind: str | None,
    assignments: tuple[str, ...],
) -> None:
    """List the scenarios that come along, one line each; or print one in full.

    With NAME (a preset or a TOML file) prints every field with its unit and meaning, and every
    gain of every law: a file to edit and run.
    """
    if as_toml and as_json:
        raise click.UsageError("--toml and --json exclude each other.")
    if kind is not None:
        _check_alone(name, as_toml, as_json, assignments)
        click.echo(reference_text(kind))
    elif name is None:
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


def _check_alone(*others: object) -> None:
    if any(others):
        raise click.UsageError("--reference KIND stands alone.")


def reference_text(kind: str) -> str:
    """What a kind of reference is, its fields with defaults, and a table to begin with."""
    from wmr_ctrl.errors import UnknownNameError
    from wmr_ctrl.scenario import quantities
    from wmr_ctrl.world.references import REFERENCES

    if kind not in REFERENCES:
        raise UnknownNameError("kind of reference", kind, REFERENCES)
    entry = REFERENCES[kind]
    rows = [
        (
            name,
            "-" if what.default is None else json.dumps(what.default),
            f"{what.doc} [{what.unit}]",
        )
        for name, what in quantities(entry.section)
    ]
    about = [wrapped(part) for part in (entry.section.__doc__ or "").split("\n\n")]
    keys = table(rows, header=("key", "default", "meaning"))
    return "\n\n".join((*about, keys, "Example:", entry.example or _example(kind, rows)))


def _example(kind: str, rows: list[tuple[str, str, str]]) -> str:
    """A table of the scenario file with every default that there is."""
    head = ["[reference]", f'kind = "{kind}"']
    return "\n".join(head + [f"{name} = {value}" for name, value, _ in rows if value != "-"])


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
