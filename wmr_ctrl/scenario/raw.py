"""Scenario from and to plain dictionaries, as TOML and JSON have them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.fields.problems import UnknownKeyError, choices, show
from wmr_ctrl.fields.section import Section, build
from wmr_ctrl.fields.values import as_list
from wmr_ctrl.scenario.change import Change
from wmr_ctrl.scenario.csv_points import read_points
from wmr_ctrl.scenario.reference import KINDS, Reference, Waypoints, kind_name
from wmr_ctrl.scenario.scenario import SECTIONS, Scenario

OTHER_KEYS = ("title", "gains", "reference", "changes")


def from_dict(raw: Mapping[str, Any], name: str = "unnamed") -> Scenario:
    """Return the scenario of a raw dictionary; keys that are left out take their defaults.

    Raises ScenarioError (UnknownKeyError for a key), the message starting with the key's path.
    """
    if not isinstance(raw, Mapping):
        raise ScenarioError("A scenario must be a table of tables.")
    for key in raw:
        if key not in SECTIONS and key not in OTHER_KEYS:
            raise UnknownKeyError(str(key), [*SECTIONS, *OTHER_KEYS])
    parts: dict[str, Any] = {key: build(SECTIONS[key], raw[key]) for key in SECTIONS if key in raw}
    return Scenario(
        name=name,
        title=raw.get("title", ""),
        gains=raw.get("gains", {}),
        reference=_reference(raw.get("reference", {})),
        changes=_changes(raw.get("changes", [])),
        **parts,
    )


def _reference(raw: object) -> Reference:
    if not isinstance(raw, Mapping):
        raise ScenarioError(f"reference = {show(raw)} must be a table, written as [reference].")
    kind = raw.get("kind", "circle")
    if not isinstance(kind, str) or kind not in KINDS:
        found = choices(kind if isinstance(kind, str) else "", KINDS)
        raise ScenarioError(f"reference.kind = {show(kind)} is not a kind of reference; {found}.")
    values = {key: value for key, value in raw.items() if key != "kind"}
    cls = KINDS[kind]
    return build(cls, _with_points(values) if cls is Waypoints else values)


def _with_points(values: dict[str, Any]) -> dict[str, Any]:
    if "file" not in values:
        return values
    file = values.pop("file")
    if not isinstance(file, str):
        raise ScenarioError(f"reference.file = {show(file)} must be the path of a CSV file.")
    if "points" in values:
        raise ScenarioError("reference.file and reference.points exclude each other: keep one.")
    return {"points": read_points(Path(file)), **values}


def _changes(raw: object) -> tuple[Change, ...]:
    items = as_list(raw)
    if items is None:
        raise ScenarioError(f"changes = {show(raw)} must be an array of tables, [[changes]].")
    return tuple(build(Change, item, f"changes[{i}]") for i, item in enumerate(items, start=1))


def scenario_dict(scenario: Scenario) -> dict[str, Any]:
    """Return all of a scenario but its name, as plain values; fields left out are missing.

    ``from_dict(scenario_dict(s), s.name) == s`` for every scenario.
    """
    kind = {"kind": kind_name(scenario.reference)}
    raw: dict[str, Any] = {"title": scenario.title}
    raw |= {key: section_dict(getattr(scenario, key)) for key in SECTIONS}
    raw["gains"] = {
        law: {name: _plain(value) for name, value in gains.items()}
        for law, gains in scenario.gains.items()
    }
    raw["reference"] = kind | section_dict(scenario.reference)
    raw["changes"] = [section_dict(change) for change in scenario.changes]
    return raw


def section_dict(section: Section) -> dict[str, Any]:
    """Return a section's fields that have a value, arrays as lists."""
    return {key: _plain(value) for key, value in vars(section).items() if value is not None}


def _plain(value: object) -> object:
    return [_plain(item) for item in value] if isinstance(value, tuple) else value
