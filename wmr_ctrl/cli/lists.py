"""``wmr-ctrl scenarios`` and ``laws``: lists, and any scenario as TOML to edit."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from .console import print_json, table, wrapped
from .options import command, load

if TYPE_CHECKING:
    from wmr_ctrl.world.scenario import Scenario

Docs = dict[str, dict[str, tuple[Any, str, str]]]
"""Default, unit and meaning by law and gain."""


@command("scenarios")
def scenarios(
    name: str | None,
    as_toml: bool,
    complete: bool,
    as_json: bool,
    kind: str | None,
    assignments: tuple[str, ...],
) -> None:
    """List the built-in scenarios, one line each, or print one in full.

    With NAME (a preset or a TOML file), print every field with its unit and meaning, and every
    gain of every law: a file to edit and run. Changes of the robot during the run are left out of
    it without --complete, since they are not your robot's.
    """
    if as_toml and as_json:
        raise click.UsageError("give either --toml or --json, not both.")
    if kind is not None:
        if name or as_toml or complete or as_json or assignments:
            raise click.UsageError("--reference KIND cannot be combined with other options.")
        click.echo(reference_text(kind))
    elif name is not None:
        _print(name, as_json, complete, assignments)
    elif as_toml or complete or assignments:
        raise click.UsageError("--toml, --complete and --set need the NAME of a scenario.")
    else:
        from wmr_ctrl.world.scenario import preset_titles

        _list([{"name": name, "title": title} for name, title in preset_titles().items()], as_json)


@command("laws")
def laws(as_json: bool) -> None:
    """List the control laws, one line each."""
    from wmr_ctrl.api import law_table

    _list(law_table(), as_json)


def _list(rows: list[dict[str, str]], as_json: bool) -> None:
    if as_json:
        print_json(rows)
    else:
        click.echo(table([(row["name"], row["title"]) for row in rows]))


def reference_text(kind: str) -> str:
    """Description of a kind of reference, its fields with defaults, and a table to start from."""
    from wmr_ctrl.core.errors import UnknownNameError
    from wmr_ctrl.core.fields.section import quantities
    from wmr_ctrl.core.fields.unstated import Unstated
    from wmr_ctrl.world.references import REFERENCES

    if kind not in REFERENCES:
        raise UnknownNameError("kind of reference", kind, REFERENCES)
    entry = REFERENCES[kind]
    fields = dict(quantities(entry.section))
    values = {
        name: json.dumps(what.default)
        for name, what in fields.items()
        if what.default is not None and not isinstance(what.default, Unstated)
    }
    rows = [
        (name, values.get(name, "-"), f"{what.doc} [{what.unit}]") for name, what in fields.items()
    ]
    about = [wrapped(part) for part in (entry.section.__doc__ or "").split("\n\n")]
    keys = table(rows, header=("key", "default", "meaning"))
    defaults = [f"{name} = {value}" for name, value in values.items()]
    example = "\n".join(["[reference]", f'kind = "{kind}"', *defaults])
    return "\n\n".join((*about, keys, "Example:", entry.example or example))


def _print(name: str, as_json: bool, complete: bool, assignments: tuple[str, ...]) -> None:
    from wmr_ctrl.world.scenario import scenario_dict, title_of, to_toml
    from wmr_ctrl.world.scenario.toml_io import MARK

    scenario = load(name, assignments)
    if as_json:
        print_json({"name": scenario.name, **scenario_dict(scenario)})
        return
    asked = complete or any(item.startswith("changes") for item in assignments)
    if scenario.changes and not asked:
        click.echo(f"# {_left_out(scenario)}")
        scenario = replace(scenario, changes=())
        scenario = replace(scenario, title=title_of(scenario))
    click.echo(f"# Lines with {MARK} are of this scenario's robot, path and gains: look at each.")
    click.echo(to_toml(scenario, gains_docs=gains_docs(scenario), marked=True), nl=False)


def _left_out(scenario: Scenario) -> str:
    """Comment on the omitted changes, and on guard masses that may be meant for them."""
    times = " and ".join(f"{item.t:g} s" for item in scenario.changes)
    text = f"changes at {times} are left out; --complete writes them"
    if scenario.guard.M_min is None and scenario.guard.M_max is None:
        return text
    return (
        f"{text}\n"
        "# guard.M_min and guard.M_max may cover these changes: state the range of your robot,\n"
        "# or remove both lines, and it follows from robot.m and robot.I"
    )


def gains_docs(scenario: Scenario) -> Docs:
    """Default, unit and meaning of every gain, by law; the kinematic loop's first.

    The default of gains that follow from the robot is None.
    """
    from wmr_ctrl.control.setup import following_gains
    from wmr_ctrl.core.fields.section import quantities

    return {
        law: {
            name: (None if name in following_gains(law) else what.default, what.unit, what.doc)
            for name, what in quantities(type(gains))
        }
        for law, gains in scenario.gains_by_law().items()
    }
