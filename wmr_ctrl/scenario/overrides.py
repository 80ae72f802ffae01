"""Overrides such as ``limits.v_u2[1] = 0.7``, put on a raw scenario before it is checked.

A key is dotted, with indices from 1.  A text value is TOML; failing that, a bare comma list is
an array, and a bare word is text.
"""

import re
import tomllib
from collections.abc import Iterable, Mapping
from copy import deepcopy
from itertools import pairwise
from pathlib import Path

from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.fields.arguments import checks_arguments
from wmr_ctrl.fields.problems import show
from wmr_ctrl.scenario.raw import (
    Raw,
    drop_unreached,
    frames_of,
    from_dict,
    in_frames,
    scenario_dict,
    with_defaults,
)
from wmr_ctrl.scenario.scenario import Scenario

Step = str | int
_PART = re.compile(r"([A-Za-z0-9_-]+)((?:\[[0-9]{1,6}\])*)")


@checks_arguments
def override(scenario: Scenario, overrides: Mapping[str, object]) -> Scenario:
    """Return the scenario with the fields of ``overrides`` replaced, checked again.

    Keys are paths such as ``"robot.m"`` or ``"changes[1].mu"``; values are TOML text or plain
    values.  Raises ScenarioError.
    """
    return from_dict(apply(scenario_dict(scenario), overrides), scenario.name)


def parse_assignments(texts: Iterable[str]) -> dict[str, str]:
    """Split texts ``KEY=VALUE`` into a mapping of overrides; of a repeated key the last counts."""
    pairs = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not equals or not key.strip():
            raise ScenarioError(f"{show(text)} is not KEY=VALUE, such as robot.m=60.")
        pairs[key.strip()] = value.strip()
    return pairs


def parse_value(text: str) -> object:
    """Return the value of an override's text: TOML, or a bare comma list, or a bare word."""
    text = text.strip()
    item = _toml_value(text)
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
    """Return a copy of ``raw`` with the overrides put on it.

    Other ``frames`` restate what is there, and say how the other overrides are meant.
    Another ``reference.kind`` starts from that kind's defaults; a shorter ``clock.duration``
    drops the changes that the run no longer reaches, unless changes are overridden too.  A
    relative ``reference.file`` is relative to the current directory.
    """
    if not overrides:
        return deepcopy(dict(raw))
    values = {
        key: parse_value(value) if isinstance(value, str) else deepcopy(value)
        for key, value in overrides.items()
    }
    result = in_frames(deepcopy(dict(raw)), values.get("frames", frames_of(raw)))
    result = _with_kind(result, values)
    result = with_defaults(result)
    for key, value in values.items():
        _assign(result, parse_key(key), value, key)
    if "clock.duration" in values and not any(key.startswith("changes") for key in values):
        drop_unreached(result)
    return result


def _with_kind(raw: Raw, values: dict[str, object]) -> Raw:
    reference = raw.get("reference")
    table = dict(reference) if isinstance(reference, Mapping) else {}
    kind = values.get("reference.kind")
    if kind is not None and kind != table.get("kind", "circle"):
        table = {"kind": kind}
    if "reference.file" in values:
        table.pop("points", None)
        values["reference.file"] = absolute(values["reference.file"], Path.cwd())
    if "reference.points" in values:
        table.pop("file", None)
    return raw | {"reference": table} if table else raw


def absolute(file: object, folder: Path) -> object:
    """Return a file's name as an absolute path; anything but text is left to the later check."""
    return str(folder / file) if isinstance(file, str) else file


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
    """Put a value in its place; missing tables are made, and an element after a list's last."""
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
        place[last] = value
    else:
        _list_at(place, last, isinstance(value, Mapping), value, key)[int(last)] = value


def _list_at(place: object, step: Step, is_table: bool, fresh: object, key: str) -> list[object]:
    """The list that has the index ``step``, perhaps with ``fresh`` as a new last table."""
    if isinstance(step, int) and isinstance(place, list):
        if step == len(place) and is_table:
            place.append(fresh)
        if 0 <= step < len(place):
            return place
    raise _no_place(place, step, key)


def _no_place(place: object, step: Step, key: str) -> ScenarioError:
    if isinstance(step, str):
        return ScenarioError(f"{key} does not exist: there is no table or array for {step} here.")
    size = len(place) if isinstance(place, list) else 0
    return ScenarioError(
        f"{key} does not exist: index {step + 1} is outside an array of {size} "
        "element(s), counted from 1. Give the whole array, or an index within it."
    )
