"""Gains as a scenario names them: raw values by law and gain, only their types checked.

Which gains a law has, their bounds and defaults is the law's own matter.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.fields.frozen import Frozen
from wmr_ctrl.fields.problems import show
from wmr_ctrl.fields.values import Quantity, Range, as_list

Gain: TypeAlias = float | bool | str | tuple[float, ...]
Gains: TypeAlias = Mapping[str, Mapping[str, Gain]]

_NUMBER = Quantity(None, "", "a gain", Range(), "number")


def clean_gains(raw: object) -> Gains:
    """Return gains with numbers as floats and arrays as tuples of floats, hashable.

    Raises ScenarioError for anything that is not a table of tables of numbers, arrays of
    numbers, texts or flags.
    """
    if not isinstance(raw, Mapping):
        raise ScenarioError(f"gains = {show(raw)} must be a table of laws, as in [gains.mb].")
    return Frozen((str(law), _law(gains, f"gains.{law}")) for law, gains in raw.items())


def _law(gains: object, path: str) -> Mapping[str, Gain]:
    if not isinstance(gains, Mapping):
        raise ScenarioError(f"{path} = {show(gains)} must be a table of gains, as in [{path}].")
    return Frozen((str(name), _gain(value, f"{path}.{name}")) for name, value in gains.items())


def _gain(value: object, path: str) -> Gain:
    if isinstance(value, (bool, str)):
        return value
    items = as_list(value)
    if items is not None:
        return tuple(_number(item, f"{path}[{i}]") for i, item in enumerate(items, start=1))
    return _number(value, path)


def _number(value: object, path: str) -> float:
    number: float = _NUMBER.clean(value, path)
    return number
