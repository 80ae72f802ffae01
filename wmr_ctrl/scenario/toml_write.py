"""A scenario as TOML text: complete, each field with its unit and meaning as a comment."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

import tomlkit
from tomlkit.items import AoT, Table

from wmr_ctrl.fields.section import Section, quantities
from wmr_ctrl.scenario.change import Change
from wmr_ctrl.scenario.raw import scenario_dict
from wmr_ctrl.scenario.robot import Model
from wmr_ctrl.scenario.scenario import Scenario
from wmr_ctrl.world.references import REFERENCES

GainsDocs: TypeAlias = Mapping[str, Mapping[str, tuple[Any, str, str]]]
"""By law and gain: default value, unit, meaning."""

ORDER = ("robot", "model", "limits", "gains", "initial", "reference")


def to_toml(scenario: Scenario, comments: bool = True, gains_docs: GainsDocs | None = None) -> str:
    """Return TOML text that loads back to an equal scenario (the name is the file's).

    ``gains_docs`` tells the laws' gains: those that the scenario does not name are then printed
    too, at their defaults, so that the text holds every gain of a run.
    """
    raw: dict[str, Any] = scenario_dict(scenario)
    document = tomlkit.document()
    document.add("title", tomlkit.item(scenario.title))
    rest = [key for key in raw if key not in (*ORDER, "title", "changes")]
    for key in (*ORDER, *rest):
        table = _gains(raw[key], gains_docs or {}, comments) if key == "gains" else None
        document.add(key, _section(scenario, key, raw[key], comments) if table is None else table)
    if raw["changes"]:
        document.add("changes", _changes(scenario, raw["changes"], comments))
    elif comments:
        _no_changes(document)
    return tomlkit.dumps(document)


def _section(scenario: Scenario, key: str, raw: Mapping[str, Any], comments: bool) -> Table:
    table = tomlkit.table()
    if key == "reference":
        _add(table, "kind", raw["kind"], "one of " + ", ".join(REFERENCES) if comments else "")
    return _fields(table, _class_of(scenario, key), raw, comments)


def _class_of(scenario: Scenario, key: str) -> type[Section]:
    return Model if key == "model" else type(scenario.table(key))


def _fields(table: Table, cls: type[Section], raw: Mapping[str, Any], comments: bool) -> Table:
    for name, what in quantities(cls):
        note = _note(what.unit, what.doc) if comments else ""
        _add_or_tell(table, name, raw.get(name), note)
    return table


def _note(unit: str, doc: str) -> str:
    return f"[{unit}] {doc}" if unit else doc


def _add_or_tell(table: Table, name: str, value: Any, note: str) -> None:
    """A field; one that is left out is a comment, where there are comments."""
    if value is not None:
        _add(table, name, value, note)
    elif note:
        table.add(tomlkit.comment(f"{name} = ...  # {note}"))


def _add(table: Table, name: str, value: Any, note: str) -> None:
    item = tomlkit.item(value)
    if isinstance(value, list) and value and isinstance(value[0], list):
        item.multiline(True)
    if note:
        item.comment(note)
    table.add(name, item)


def _gains(raw: Mapping[str, Any], docs: GainsDocs, comments: bool) -> Table:
    gains = tomlkit.table(is_super_table=bool(docs or raw))
    for law in dict.fromkeys([*docs, *raw]):
        table = tomlkit.table()
        known = docs.get(law, {})
        for name in dict.fromkeys([*known, *raw.get(law, {})]):
            default, unit, doc = known.get(name, (None, "", ""))
            value = raw.get(law, {}).get(name, default)
            _add_or_tell(table, name, _listed(value), _note(unit, doc) if comments else "")
        gains.add(law, table)
    if comments and not gains:
        gains.add(
            tomlkit.comment("by law, as in [gains.mb]; those left out are the law's defaults")
        )
    return gains


def _listed(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value


def _changes(scenario: Scenario, raw: list[dict[str, Any]], comments: bool) -> AoT:
    array = tomlkit.aot()
    for values in raw:
        array.append(_fields(tomlkit.table(), Change, values, comments))
    return array


def _no_changes(document: tomlkit.TOMLDocument) -> None:
    document.add(tomlkit.nl())
    document.add(tomlkit.comment("[[changes]]  # one such table for each sudden change; none here"))
    for name, what in quantities(Change):
        document.add(tomlkit.comment(f"{name} = ...  # {_note(what.unit, what.doc)}"))
