"""Writer of `identify`: the keys found, each with its interval and the name of its log."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import tomlkit

from wmr_ctrl.core.fields.units import rounded
from wmr_ctrl.world.scenario import scenario_dict, to_toml
from wmr_ctrl.world.scenario.raw import stated_in
from wmr_ctrl.world.scenario.toml_io import is_path

if TYPE_CHECKING:
    from .bounds import BaseIdentification, Origin

DIGITS = 4


def toml_of(result: BaseIdentification, folder: Path | None = None) -> str:
    """TOML text of the scenario, without missing keys and without values that its base file states.

    ``folder``: where the file will be, for the relative path of the base file; absolute if None.
    """
    assumed = [key for key in result.scenario.assumed if key not in result.missing]
    shown = [name for name, item in result.parameters.items() if not math.isnan(item.value)]
    ours = (key for key, names in result.places.items() if {*names} & {*shown})
    only = {*result.words, *ours, *assumed, *result.origin.values}
    stated = replace(result.scenario, assumed=tuple(assumed))
    now = scenario_dict(stated)
    document = tomlkit.parse(to_toml(stated, only=only))
    said = {key: result.words.get(key) or "assumed, nobody stated it" for key in assumed}
    for key, names in result.places.items():
        found = [_interval(result, name) for name in names if name in shown]
        if found:
            said[key] = f"{'; '.join(found)}; from {result.name}, {result.seconds:.3g} s"
    for key, text in said.items():
        table, name = key.split(".")
        if name in document.get(table, {}):
            entry = document[table][name]
            entry.comment(f"{entry.trivia.comment.lstrip('# ')}: {text}")
    same = (key for key, value in result.origin.values.items() if _at(now, key) == value)
    for key in (*result.missing, *same):
        *tables, name = key.split(".")
        part = document
        for table in tables:
            part = part.get(table, {})
        if name in part:
            part.remove(name)
    for table in [name for name, part in document.items() if part == {}]:
        document.remove(table)
    limit = {"guard": "guard.dbar", "filter": "filter.d"}[result.bounds.section]
    head = [
        f"from the log {result.name} by wmr-ctrl identify, with 95 % intervals as comments",
        f"{limit}: {result.bounds.sentence}",
        *result.remarks,
    ]
    text = "".join(f"# {line}\n" for line in head) + "\n"
    if result.origin.source:
        text += f"extends = {tomlkit.item(_source(result.origin, folder)).as_string()}\n"
    return text + tomlkit.dumps(document)


def _interval(result: BaseIdentification, name: str) -> str:
    item = result.parameters[name]
    low, high = outward(item.low, item.high)
    return f"{name} {low:g} to {high:g} {result.described()[name][1]}, {item.verdict}"


def _source(origin: Origin, folder: Path | None) -> str:
    if not is_path(origin.source):
        return origin.source
    place = os.path.abspath(origin.source)
    return place if folder is None else Path(os.path.relpath(place, folder)).as_posix()


def _at(raw: Mapping[str, object], key: str) -> object:
    value: object = raw
    for name in key.split("."):
        value = value.get(name) if isinstance(value, Mapping) else None
    return value


def values_in(raw: Mapping[str, object], source: Mapping[str, object]) -> dict[str, object]:
    """The values in ``raw`` of all keys that ``source`` states, by key."""
    return {key: _at(raw, key) for key in stated_in(source)}


def four_digits(value: float, up: bool | None = None) -> float:
    """A number rounded to four digits: to the nearest, or up, or down."""
    return float(f"{value:.{DIGITS}g}" if up is None else rounded(value, DIGITS, up))


def outward(low: float, high: float) -> tuple[float, float]:
    """An interval with its ends rounded to four digits, outwards except for rounding errors."""
    return four_digits(low, up=False), four_digits(high, up=True)
