"""A scenario as TOML text: complete, each field with its unit and meaning as a comment."""

from collections.abc import Mapping
from typing import Any, TypeAlias

import tomlkit
from tomlkit.items import Table

from wmr_ctrl.fields.orientation import PAPER, described
from wmr_ctrl.fields.section import Section, quantities
from wmr_ctrl.scenario.raw import scenario_dict
from wmr_ctrl.scenario.scenario import Scenario
from wmr_ctrl.scenario.sections import Change, Model
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
    if comments or "frames" in raw:
        note = "how orientations are stated: paper (0 along +Y), rep103 (0 along +X)"
        _add(document, "frames", scenario.frames, note * comments)
    rest = [key for key in raw if key not in (*ORDER, "title", "frames", "changes")]
    for key in (*ORDER, *rest):
        if key == "gains":
            document.add(key, _gains(raw[key], gains_docs or {}, comments))
            continue
        table = tomlkit.table()
        if key == "reference":
            _add(table, "kind", raw[key]["kind"], f"one of {', '.join(REFERENCES)}" * comments)
        cls = Model if key == "model" else type(scenario.table(key))
        document.add(key, _fields(table, cls, raw[key], comments, scenario.frames))
    if raw["changes"]:
        array = tomlkit.aot()
        for values in raw["changes"]:
            array.append(_fields(tomlkit.table(), Change, values, comments))
        document.add("changes", array)
    elif comments:
        head = "[[changes]]  # one such table for each sudden change; none here"
        fields = (f"{name} = ...  # {_note(w.unit, w.doc)}" for name, w in quantities(Change))
        document.add(tomlkit.nl())
        for line in (head, *fields):
            document.add(tomlkit.comment(line))
    return tomlkit.dumps(document)


def _fields(
    table: Table, cls: type[Section], raw: Mapping[str, Any], comments: bool, frames: str = PAPER
) -> Table:
    for name, what in quantities(cls):
        note = _note(what.unit, described(what.doc, frames)) if comments else ""
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


def _add(table: Table | tomlkit.TOMLDocument, name: str, value: Any, note: str) -> None:
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
            listed = list(value) if isinstance(value, tuple) else value
            _add_or_tell(table, name, listed, _note(unit, doc) if comments else "")
        gains.add(law, table)
    if comments and not gains:
        gains.add(
            tomlkit.comment("by law, as in [gains.mb]; those left out are the law's defaults")
        )
    return gains
