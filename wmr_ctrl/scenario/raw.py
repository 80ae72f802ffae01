"""Scenario from and to plain dictionaries, as TOML and JSON have them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.fields.problems import UnknownKeyError, choices, show
from wmr_ctrl.fields.section import Section, build
from wmr_ctrl.fields.values import as_list
from wmr_ctrl.scenario.change import Change
from wmr_ctrl.scenario.scenario import OTHER_KEYS, SECTIONS, Scenario, sections
from wmr_ctrl.world.references import REFERENCES, Reference


def from_dict(raw: Mapping[str, object], name: str = "unnamed") -> Scenario:
    """Return the scenario of a raw dictionary; keys that are left out take their defaults.

    Raises ScenarioError (UnknownKeyError for a key), the message starting with the key's path.
    """
    if not isinstance(raw, Mapping):
        raise ScenarioError("A scenario must be a table of tables.")
    known = sections()
    for key in raw:
        if key not in known and key not in OTHER_KEYS:
            raise UnknownKeyError(str(key), [*known, *OTHER_KEYS])
    values: Mapping[str, Any] = raw
    parts: dict[str, Any] = {key: build(known[key], raw[key]) for key in known if key in raw}
    effects = {key: parts.pop(key) for key in list(parts) if key not in SECTIONS}
    return Scenario(
        name=name,
        title=values.get("title", ""),
        gains=values.get("gains", {}),
        reference=_reference(raw.get("reference", {})),
        changes=_changes(raw.get("changes", [])),
        effects=effects,
        **parts,
    )


def _reference(raw: object) -> Reference:
    if not isinstance(raw, Mapping):
        raise ScenarioError(f"reference = {show(raw)} must be a table, written as [reference].")
    name = raw.get("kind", "circle")
    if not isinstance(name, str) or name not in REFERENCES:
        near = choices(name if isinstance(name, str) else "", REFERENCES)
        raise ScenarioError(f"reference.kind = {show(name)} is not a kind of reference; {near}.")
    kind = REFERENCES[name]
    return build(kind.section, kind.read({k: v for k, v in raw.items() if k != "kind"}))


def _changes(raw: object) -> tuple[Change, ...]:
    items = as_list(raw)
    if items is None:
        raise ScenarioError(f"changes = {show(raw)} must be an array of tables, [[changes]].")
    return tuple(build(Change, item, f"changes[{i}]") for i, item in enumerate(items, start=1))


def scenario_dict(scenario: Scenario) -> dict[str, object]:
    """Return all of a scenario but its name, as plain values; fields left out are missing.

    ``from_dict(scenario_dict(s), s.name) == s`` for every scenario.
    """
    kind = {"kind": scenario.reference_kind.name}
    raw: dict[str, object] = {"title": scenario.title}
    raw |= {key: section_dict(getattr(scenario, key)) for key in SECTIONS}
    raw |= {key: section_dict(part) for key, part in scenario.effects.items()}
    raw["gains"] = {
        law: {name: _plain(value) for name, value in gains.items()}
        for law, gains in scenario.gains.items()
    }
    raw["reference"] = kind | section_dict(scenario.reference)
    raw["changes"] = [section_dict(change) for change in scenario.changes]
    return raw


def section_dict(section: Section) -> dict[str, object]:
    """Return a section's fields that have a value, arrays as lists."""
    return {key: _plain(value) for key, value in vars(section).items() if value is not None}


def _plain(value: object) -> object:
    return [_plain(item) for item in value] if isinstance(value, tuple) else value
