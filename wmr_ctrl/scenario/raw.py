"""Scenario from and to plain dictionaries, as TOML and JSON have them, and one put over another."""

from collections.abc import Mapping
from copy import deepcopy
from numbers import Real
from typing import Any

from wmr_ctrl.errors import ScenarioError, choices
from wmr_ctrl.fields.orientation import PAPER, checked_frames, field_inward, field_outward
from wmr_ctrl.fields.problems import UnknownKeyError, show
from wmr_ctrl.fields.section import Section, build, quantities
from wmr_ctrl.fields.values import as_list
from wmr_ctrl.scenario.scenario import OTHER_KEYS, SECTIONS, Scenario, sections
from wmr_ctrl.scenario.sections import Change
from wmr_ctrl.world.references import REFERENCES, Reference, Waypoints

Raw = dict[str, object]


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
    frames, raw = frames_of(raw), in_frames(raw, PAPER)
    values: Mapping[str, Any] = raw
    parts: dict[str, Any] = {key: build(known[key], raw[key]) for key in known if key in raw}
    effects = {key: parts.pop(key) for key in list(parts) if key not in SECTIONS}
    return Scenario(
        name=name,
        title=values.get("title", ""),
        frames=frames,
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


def scenario_dict(scenario: Scenario) -> Raw:
    """Return all of a scenario but its name, as plain values; fields left out are missing.

    ``from_dict(scenario_dict(s), s.name) == s`` for every scenario; orientations that do not come
    from a file with ``frames = "rep103"`` are off by rounding then.
    """
    raw: Raw = {"title": scenario.title}
    raw |= {key: _section_dict(getattr(scenario, key)) for key in SECTIONS}
    raw |= {key: _section_dict(part) for key, part in scenario.effects.items()}
    raw["gains"] = {
        law: {name: _plain(value) for name, value in gains.items()}
        for law, gains in scenario.gains.items()
    }
    kind = {"kind": scenario.reference_kind.name}
    raw["reference"] = kind | _section_dict(scenario.reference)
    raw["changes"] = [_section_dict(change) for change in scenario.changes]
    if scenario.frames == PAPER:
        return raw
    return in_frames(raw, scenario.frames)


def frames_of(raw: Mapping[str, object]) -> str:
    """Convention of orientations in a raw dictionary; raises ScenarioError for an unknown one."""
    return checked_frames(raw.get("frames", PAPER))


def in_frames(raw: Mapping[str, object], frames: object) -> Raw:
    """Return ``raw`` with its orientations as ``frames`` counts them, which it names then."""
    had, wanted = frames_of(raw), checked_frames(frames)
    result = dict(raw)
    if had == wanted:
        return result
    kind = REFERENCES.get(str(_kind(raw)))
    known = {**sections(), **({"reference": kind.section} if kind else {})}
    for key, section in known.items():
        table = raw.get(key)
        if isinstance(table, Mapping):
            turns = {name: what.orientation for name, what in quantities(section)}
            inside = {name: field_inward(table[name], turns.get(name, 0), had) for name in table}
            result[key] = {
                name: field_outward(value, turns.get(name, 0), wanted)
                for name, value in inside.items()
            }
    return result | {"frames": wanted}


def _section_dict(section: Section) -> Raw:
    """A section's fields that have a value, arrays as lists."""
    return {key: _plain(value) for key, value in vars(section).items() if value is not None}


def _plain(value: object) -> object:
    return [_plain(item) for item in value] if isinstance(value, tuple) else value


def merge(base: Mapping[str, object], over: Mapping[str, object]) -> Raw:
    """Return ``base`` with ``over`` put on top: tables key by key, everything else as a whole.

    Another ``reference.kind`` replaces the whole reference.  A shorter ``clock.duration`` drops
    the base's changes that the run no longer reaches.
    """
    result = _over(base, over)
    if "reference" in over and _kind(over, _kind(base)) != _kind(base):
        result["reference"] = deepcopy(over["reference"])
    if "changes" not in over and "duration" in _table(over, "clock"):
        drop_unreached(result)
    return result


def with_defaults(raw: Mapping[str, object]) -> Raw:
    """Return ``raw`` with every field that has a default filled in, so that each can be indexed."""
    defaults: Raw = {key: _section_dict(section()) for key, section in sections().items()}
    kind = REFERENCES.get(str(_kind(raw)))
    if kind is not None and kind.section is not Waypoints:  # points have no default
        defaults["reference"] = _section_dict(kind.section())
    return _over(in_frames(defaults, frames_of(raw)), raw)


def _over(base: Mapping[str, Any], over: Mapping[str, Any]) -> Raw:
    result = deepcopy(dict(base))
    for key, value in over.items():
        both = isinstance(value, Mapping) and isinstance(result.get(key), Mapping)
        result[key] = _over(result[key], value) if both else deepcopy(value)
    for name, other in (("file", "points"), ("points", "file")):
        if name in over:
            result.pop(other, None)
            break
    return result


def _table(raw: Mapping[str, object], key: str) -> Mapping[str, object]:
    table = raw.get(key)
    return table if isinstance(table, Mapping) else {}


def _kind(raw: Mapping[str, object], default: object = "circle") -> object:
    return _table(raw, "reference").get("kind", default)


def drop_unreached(raw: Raw) -> None:
    """Remove the changes at or after the run's end."""
    duration, changes = _table(raw, "clock").get("duration"), raw.get("changes")
    if isinstance(duration, Real) and isinstance(changes, list):
        raw["changes"] = [change for change in changes if not _late(change, duration)]


def _late(change: object, duration: Real) -> bool:
    time = change.get("t") if isinstance(change, Mapping) else None
    return isinstance(time, Real) and time >= duration
