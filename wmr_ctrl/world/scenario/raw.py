"""Scenario from and to plain dictionaries, as in TOML and JSON, and merging of two of them.

Overrides, such as ``limits.v_u2[1] = 0.7``, are applied to a raw scenario before it is checked. A
key is dotted, with indices from 1.  A text value is TOML, also with numbers such as .95 and 1.;
otherwise a bare comma list is an array, and a bare word is text.
"""

import re
import tomllib
from collections.abc import Iterable, Mapping
from contextlib import suppress
from copy import deepcopy
from itertools import pairwise
from numbers import Real
from typing import Any

from wmr_ctrl.core.errors import ScenarioError, UnknownKeyError, choices, show
from wmr_ctrl.core.fields.arguments import checks_arguments
from wmr_ctrl.core.fields.named_units import with_units
from wmr_ctrl.core.fields.orientation import PAPER, checked_frames, field_inward, field_outward
from wmr_ctrl.core.fields.section import Section, build, default, quantities
from wmr_ctrl.core.fields.unstated import Unknown, Unstated
from wmr_ctrl.core.fields.values import as_list
from wmr_ctrl.world.references import REFERENCES, Line, Reference, Waypoints

from .scenario import OTHER_KEYS, SECTIONS, MissingKeysError, Scenario, sections
from .sections import Change

Raw = dict[str, object]
STAND_IN = Line()
"""Replacement for a refused reference, so that further errors can be found."""
Step = str | int


def from_dict(raw: Mapping[str, object], name: str = "unnamed") -> Scenario:
    """Return the scenario of a raw dictionary; omitted keys take their defaults.

    Raises ScenarioError (UnknownKeyError for a key); the message starts with the key's path.
    """
    if not isinstance(raw, Mapping):
        raise ScenarioError("A scenario must be a table of tables.")
    known, errors = sections(), list[ScenarioError]()
    for key in raw:
        if key not in known and key not in OTHER_KEYS:
            errors.append(UnknownKeyError(str(key), [*known, *OTHER_KEYS]))
    frames, raw = frames_of(raw), in_frames(raw_with_units(raw), PAPER)
    values: Mapping[str, Any] = raw
    parts: dict[str, Any] = {}
    for key, section in known.items():
        if key in raw:
            parts[key] = _built(section, raw[key], errors)
        elif key in SECTIONS:
            parts[key] = default(section)
    effects = {key: parts.pop(key) for key in list(parts) if key not in SECTIONS}
    try:
        return _whole(
            errors,
            name=name,
            title=values.get("title", ""),
            law=values.get("law"),
            frames=frames,
            assumed=values.get("assumed", ()),
            gains=values.get("gains", {}),
            reference=_reference(raw.get("reference", {}), errors),
            changes=_changes(raw.get("changes", [])),
            effects=effects,
            **parts,
        )
    except ScenarioError as error:
        if not errors or error is errors[0]:
            raise
    raise errors[0]


def raw_with_units(raw: Mapping[str, object]) -> Raw:
    """A raw scenario whose numbers with a unit are converted to SI; top-level texts are kept."""
    return {k: value if isinstance(value, str) else with_units(value) for k, value in raw.items()}


def _whole(errors: list[ScenarioError], **parts: Any) -> Scenario:
    """Build the scenario from its parts; else raise the first error, extended by the others."""
    try:
        scenario = Scenario(**parts)
    except MissingKeysError as error:
        errors.append(error)
    if errors:
        first, *others = dict.fromkeys(map(str, errors))
        errors[0].args = (" ".join((first, *others)),)
        raise errors[0]
    return scenario


def _built(section: type[Section], raw: object, errors: list[ScenarioError]) -> Section:
    """Build a section from a raw table, or from its valid values, to find all errors."""
    try:
        return build(section, raw)
    except ScenarioError as error:
        whole = error
    known, good, needed = dict(quantities(section)), {}, {}
    alone = list[ScenarioError]()
    for name, value in raw.items() if isinstance(raw, Mapping) else ():
        path = f"{section.KEY}.{name}"
        try:
            if name not in known:
                raise UnknownKeyError(path, known)
            known[name].clean(value, path)
            good[name] = value
        except ScenarioError as error:
            alone.append(error)
        if name in known and isinstance(known[name].default, Unknown):
            needed[name] = known[name].default * 1  # stated, if wrongly
    of_one = str(whole) in map(str, alone)
    errors += alone if of_one else [whole]
    required = needed | {key: good[key] for key in needed.keys() & good.keys()}
    for values in (needed | good, required):
        with suppress(ScenarioError):
            return build(section, values)
    return build(section, needed)


def _reference(raw: object, errors: list[ScenarioError]) -> Reference | None:
    """The reference; None if no kind is stated, or if it is refused."""
    try:
        return _of_kind(raw)
    except ScenarioError as error:
        errors.append(error)
        stated = isinstance(raw, Mapping) and "kind" in raw
        return STAND_IN if stated else None


def _of_kind(raw: object) -> Reference | None:
    if not isinstance(raw, Mapping):
        raise ScenarioError(f"reference = {show(raw)} must be a table, written as [reference].")
    if "kind" not in raw:
        return None
    name = raw["kind"]
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
    """Return all of a scenario except its name, as plain values; omitted fields are missing.

    ``from_dict(scenario_dict(s), s.name) == s`` for every scenario.  With ``frames = "rep103"``,
    orientations that are not from a file then have rounding errors.
    """
    raw: Raw = {"title": scenario.title}
    if scenario.law is not None:
        raw["law"] = scenario.law
    if scenario.assumed:
        raw["assumed"] = list(scenario.assumed)
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
    """Return ``raw`` with its orientations converted to ``frames``, which is stored in it."""
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
    """A section's stated fields, with arrays as lists."""
    return {
        key: _plain(value)
        for key, value in vars(section).items()
        if value is not None and not isinstance(value, Unstated)
    }


def _plain(value: object) -> object:
    return [_plain(item) for item in value] if isinstance(value, tuple) else value


def copied(raw: Mapping[str, object]) -> Raw:
    """Deep copy of a raw table."""
    return {key: _copied(value) for key, value in raw.items()}


def _copied(value: object) -> object:
    if isinstance(value, Mapping):
        return copied(value)
    if type(value) is list:
        return [_copied(item) for item in value]
    with suppress(TypeError):  # what has no copy is no value either
        return value if type(value) in (str, int, float, bool) else deepcopy(value)
    return value


def merge(base: Mapping[str, object], over: Mapping[str, object]) -> Raw:
    """Return ``base``, overridden by ``over``: tables key by key, everything else as a whole.

    Another ``reference.kind`` replaces the whole reference.  A shorter ``clock.duration`` drops the
    base's changes that the run no longer reaches.  Keys stated in ``over`` are no longer assumed.
    """
    result = _over(base, over)
    _no_longer_assumed(result, base.get("assumed"), stated_in(over), over.get("assumed"))
    if "reference" in over and _kind(over, _kind(base)) != _kind(base):
        result["reference"] = _copied(over["reference"])
    if "changes" not in over and "duration" in _table(over, "clock"):
        drop_unreached(result)
    return result


def stated_in(raw: Mapping[str, object]) -> set[str]:
    """Keys that a raw scenario states; keys of gains include their law."""
    tables = {table: part for table, part in raw.items() if isinstance(part, Mapping)}
    gains = _table(raw, "gains").items()
    tables |= {f"gains.{law}": part for law, part in gains if isinstance(part, Mapping)}
    return {f"{table}.{name}" for table, part in tables.items() for name in part}


def _no_longer_assumed(
    raw: Raw, before: object, stated: Iterable[str], more: object = None
) -> None:
    """Remove the ``stated`` keys or tables from the list of assumed keys."""
    keys = as_list(before)
    if keys is not None:
        ours = tuple(stated)
        left = [k for k in keys if not any(f"{k}.".startswith(f"{own}.") for own in ours)]
        raw["assumed"] = [*left, *(as_list(more) or ())]


def with_defaults(raw: Mapping[str, object], tables: Iterable[Step]) -> Raw:
    """Return ``raw`` with the defaults of some tables filled in, so that each can be indexed."""
    known, kind = sections(), REFERENCES.get(str(_kind(raw)))
    if kind is not None and kind.section is not Waypoints:  # points have no default
        known["reference"] = kind.section
    defaults: Raw = {key: _section_dict(default(known[key])) for key in tables if key in known}
    return _over(in_frames(defaults, frames_of(raw)), raw)


def _over(base: Mapping[str, Any], over: Mapping[str, Any]) -> Raw:
    result: dict[str, Any] = copied(base)
    for key, value in over.items():
        both = isinstance(value, Mapping) and isinstance(result.get(key), Mapping)
        result[key] = _over(result[key], value) if both else _copied(value)
    for name, other in (("file", "points"), ("points", "file")):
        if name in over:
            result.pop(other, None)
            break
    return result


def _table(raw: Mapping[str, object], key: str) -> Mapping[str, object]:
    table = raw.get(key)
    return table if isinstance(table, Mapping) else {}


def _kind(raw: Mapping[str, object], default: object = None) -> object:
    return _table(raw, "reference").get("kind", default)


def drop_unreached(raw: Raw) -> None:
    """Remove the changes at or after the run's end."""
    duration, changes = _table(raw, "clock").get("duration"), raw.get("changes")
    if isinstance(duration, Real) and isinstance(changes, list):
        raw["changes"] = [change for change in changes if not _late(change, duration)]


def _late(change: object, duration: Real) -> bool:
    time = change.get("t") if isinstance(change, Mapping) else None
    return isinstance(time, Real) and time >= duration


_PART = re.compile(r"([A-Za-z0-9_-]+)((?:\[[0-9]{1,6}\])*)")


@checks_arguments
def override(scenario: Scenario, overrides: Mapping[str, object]) -> Scenario:
    """Return the scenario with the fields of ``overrides`` replaced, checked again.

    Keys are paths such as ``"robot.m"`` or ``"changes[1].mu"``; values are TOML text or plain
    values.  Raises ScenarioError.
    """
    return from_dict(apply(scenario_dict(scenario), overrides), scenario.name)


def parse_assignments(texts: Iterable[str]) -> dict[str, str]:
    """Split texts ``KEY=VALUE`` into a mapping of overrides; the last of a repeated key is used."""
    pairs = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not equals or not key.strip():
            raise ScenarioError(f"{show(text)} is not KEY=VALUE, such as robot.m=60.")
        pairs[key.strip()] = value.strip()
    return pairs


_MISSING_DIGIT = re.compile(r"(?<![\w.])(?=\.\d)|(?<=\d\.)(?!\d)")
"""Places beside a decimal point where TOML wants a digit."""


def parse_value(text: str) -> object:
    """Return the value of an override's text: TOML, or a bare comma list, or a bare word."""
    text = text.strip()
    item = _toml_value(text) or _toml_value(_MISSING_DIGIT.sub("0", text))
    if item is not None:
        return item[0]
    if "," in text and not text.startswith(("[", "{", '"', "'")):
        items = text.removesuffix(",").split(",")
        return [parse_value(item) for item in items]
    return text


def _toml_value(text: str) -> tuple[object] | None:
    try:
        table = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return None
    return (table["value"],) if set(table) == {"value"} else None


def apply(raw: Mapping[str, object], overrides: Mapping[str, object]) -> Raw:
    """Return a copy of ``raw`` with the overrides applied.

    New ``frames`` convert what is there, and define the orientations of the other overrides.
    Another ``reference.kind`` starts from that kind's defaults; a shorter ``clock.duration`` drops
    the changes that the run no longer reaches, unless changes are overridden too. A relative
    ``reference.file`` is relative to the current directory.
    """
    if not overrides:
        return copied(raw)
    values = {
        key: parse_value(value) if isinstance(value, str) else _copied(value)
        for key, value in overrides.items()
    }
    values |= {k: with_units(v) for k, v in values.items() if "." in k or not isinstance(v, str)}
    result = in_frames(copied(raw), values.get("frames", frames_of(raw)))
    result = _with_kind(result, values)
    places = {key: parse_key(key) for key in values}
    result = with_defaults(result, {steps[0] for steps in places.values()})
    for key, value in values.items():
        _assign(result, places[key], value, key)
    _no_longer_assumed(result, raw.get("assumed"), {key.partition("[")[0] for key in values})
    if "clock.duration" in values and not any(key.startswith("changes") for key in values):
        drop_unreached(result)
    return result


def _with_kind(raw: Raw, values: dict[str, object]) -> Raw:
    reference = raw.get("reference")
    table = dict(reference) if isinstance(reference, Mapping) else {}
    kind = values.get("reference.kind")
    if isinstance(kind, str) and kind != table.get("kind"):
        table = {"kind": kind}
    if "reference.file" in values:
        table.pop("points", None)
    if "reference.points" in values:
        table.pop("file", None)
    return raw | {"reference": table} if table else raw


def parse_key(key: str) -> list[Step]:
    """Split a dotted key with indices from 1 into names and indices from 0."""
    steps: list[Step] = []
    for part in key.split("."):
        match = _PART.fullmatch(part)
        if match is None:
            raise ScenarioError(f"{show(key)} is not a key such as robot.m or changes[1].mu.")
        steps.append(match[1])
        steps.extend(int(index) - 1 for index in re.findall(r"\d+", match[2]))
    return steps


def _assign(raw: Raw, steps: list[Step], value: object, key: str) -> None:
    """Assign a value; missing tables are created, and an element after a list's last is appended.

    A table with required keys keeps what ``value`` does not state; other tables are replaced.
    """
    place: object = raw
    for step, following in pairwise(steps):
        fresh: object = {} if isinstance(following, str) else []
        if isinstance(step, str) and isinstance(place, dict):
            place = place.setdefault(step, fresh)
            continue
        items = _list_at(place, step, isinstance(following, str), fresh, key)
        place = items[int(step)]
    last = steps[-1]
    if isinstance(last, str) and isinstance(place, dict):
        merged = place is raw and _requires(last) and isinstance(place.get(last), Mapping)
        place[last] = _over(place[last], value) if merged and isinstance(value, Mapping) else value
    else:
        _list_at(place, last, isinstance(value, Mapping), value, key)[int(last)] = value


def _requires(table: str) -> bool:
    """True if a table of the scenario has keys that must be stated."""
    section = SECTIONS.get(table)
    fields = quantities(section) if section else ()
    return any(isinstance(what.default, Unknown) for _, what in fields)


def _list_at(place: object, step: Step, is_table: bool, fresh: object, key: str) -> list[object]:
    """The list with the index ``step``, if necessary extended by ``fresh`` as a new last table."""
    if isinstance(step, int) and isinstance(place, list):
        if step == len(place) and is_table:
            place.append(fresh)
        if 0 <= step < len(place):
            return place
    raise _no_place(place, step, key, is_table)


def _no_place(place: object, step: Step, key: str, is_table: bool) -> ScenarioError:
    whole, _, _ = key.rpartition("[")
    if isinstance(step, str):
        return ScenarioError(f"{key} does not exist: there is no table or array for {step} here.")
    if not isinstance(place, list):
        return ScenarioError(f"{key} does not exist: {whole} is {show(place)}, which has no parts.")
    if not (place or is_table):
        return ScenarioError(
            f"{key} cannot be changed by itself, because {whole} is not stated here. Give the "
            "whole array."
        )
    size = len(place)
    return ScenarioError(
        f"{key} does not exist: index {step + 1} is outside an array of {size} "
        "element(s), counted from 1. Give the whole array, or an index within it."
    )
