"""Content of robot files: a value, its key in a scenario, and its place in the file."""

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from enum import IntEnum
from itertools import islice
from statistics import mean
from typing import TypeAlias, TypeGuard

from wmr_ctrl.core.data import data
from wmr_ctrl.core.errors import ScenarioError, show

Value: TypeAlias = float | bool | str | tuple[float, ...]
PERIOD = "clock.control"
MULTIPLIED = {
    "separation": ("robot.l", 0.5, "separation factor"),
    "robot.r": ("robot.r", 1.0, "radius factor"),
}
"""Our key, share and multiplier of a length."""
LIMITS, TOP, LEAST = "limits.v_u1", "limits.v_max", "limits.v_min"
PAIRS = (LIMITS, TOP, LEAST, "base.accel", "base.decel")
"""Keys with a value for each axis, of which the smallest of several counts."""
NAMES = "ros."
"""Beginning of keys of frames and topics, for this project's ROS 2 nodes."""
NAMED = data(__package__, "names.toml")
LARGEST = 1e9
"""Largest size of a number, in SI units."""
STEP = 1e-3
"""Control periods are multiples of this time [s], the plant's step."""
ALIKE = 0.01
"""Share by which two values may differ that are the same."""


class Rank(IntEnum):
    """Kinds of sources; if two disagree, the first one is used."""

    CONTROLLER = 0
    GAZEBO = 1
    SMOOTHER = 2
    PLANNER = 3
    DESCRIPTION = 4


@dataclass(frozen=True)
class Found:
    """A value that a file states.

    ``key``: a scenario's key, with [1] or [2] for an axis, or "ros." and a parameter or topic of
    this project's nodes.  ``source``: file and place in it, as text.
    """

    key: str
    value: Value
    source: str
    rank: Rank

    @property
    def text(self) -> str:
        """The value as text."""
        return shown(self.value)


def shown(value: Value) -> str:
    """A value, numbers in four digits."""
    if isinstance(value, tuple):
        return f"[{', '.join(map(shown, value))}]"
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.4g}" if isinstance(value, float) else value


@dataclass(frozen=True)
class Sheet:
    """Content of all robot files: the values used, by key, and those overruled."""

    found: Mapping[str, Found]
    overruled: tuple[Found, ...] = ()


def merged(items: Sequence[Found]) -> Sheet:
    """Choose the first value of each key by rank, then by order; apply multipliers to lengths.

    Unless a file states otherwise, a base brakes as fast as it accelerates, and its backward limit
    equals the forward one.  Both axes of a pair are stored under the pair's key if both are known.
    """
    factors = {item.key: item for item in reversed(items) if item.key.endswith("factor")}
    found: dict[str, Found] = {}
    overruled = []
    for raw in sorted(items, key=lambda item: item.rank):
        item = _multiplied(raw, factors)
        first = found.setdefault(item.key, item)
        if first is not item and not _alike(first.value, item.value):
            overruled.append(item)
    for key in factors:
        del found[key]
    for axis in (1, 2):
        up, down = f"base.accel[{axis}]", f"base.decel[{axis}]"
        if up in found:
            found.setdefault(down, replace(found[up], key=down))
    _join_sides(found)
    for key in PAIRS:
        ends = [found[end] for end in (f"{key}[1]", f"{key}[2]") if end in found]
        if len(ends) == 2:
            for end in ends:
                del found[end.key]
            source = "; ".join(dict.fromkeys(end.source for end in ends))
            pair = tuple(end.value for end in ends if isinstance(end.value, float))
            found[key] = Found(key, pair, source, max(end.rank for end in ends))
    return Sheet(found, tuple(overruled))


def _join_sides(found: dict[str, Found]) -> None:
    """Replace both directions' limits by one limit if they are equal on every axis."""
    known = list[tuple[Found, Found]]()
    for axis in (1, 2):
        ends = f"{TOP}[{axis}]", f"{LEAST}[{axis}]"
        for one, other in (ends, ends[::-1]):
            if one in found and isinstance(size := found[one].value, float) and size:
                found.setdefault(other, replace(found[one], key=other, value=-size))
        if ends[0] in found:
            known.append((found[ends[0]], found[ends[1]]))
    if any(high.text != low.text.removeprefix("-") for high, low in known):
        return
    for high, low in known:
        del found[high.key], found[low.key]
        key, sources = high.key.replace(TOP, LIMITS), dict.fromkeys((high.source, low.source))
        found[key] = replace(high, key=key, source="; ".join(sources))


def _alike(one: Value, other: Value) -> bool:
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=ALIKE)
    return one == other


def _multiplied(item: Found, factors: Mapping[str, Found]) -> Found:
    """A length [m] times the controller's multiplier, a separation as half of it."""
    if item.key not in MULTIPLIED or not isinstance(item.value, float):
        return item
    key, share, factor_key = MULTIPLIED[item.key]
    factor = factors.get(factor_key)
    times = factor.value if factor is not None and isinstance(factor.value, float) else 1.0
    words = f": {'half of ' * (share != 1)}{item.text}" * (share * times != 1)
    if factor is not None and times != 1:
        words += f" times {times:g} ({factor.source})"
    value = rounded(share * times * item.value)
    return replace(item, key=key, value=value, source=f"{item.source}{words}")


Table: TypeAlias = Mapping[str, Sequence[str]]
"""Names of parameters, or elements, by our key."""


def read_table(
    params: Mapping[str, object], table: Table, where: str, rank: Rank
) -> Iterator[Found]:
    """Values of the parameters listed in a table.

    Several parameters may have one key: for limits and ramps the smallest size is used, for lengths
    the mean, for names the first.  Rates [1/s] become the period.  0 means that nothing is stated,
    except for limits backwards, where it means that the base does not reverse.
    """
    for key, names in table.items():
        given = {name: params[name] for name in names if params.get(name) is not None}
        if key.startswith(NAMES):
            texts = (Found(key, v, f"{where}{n}", rank) for n, v in given.items() if _is_name(v))
            yield from islice(texts, 1)
            continue
        stated = {name: number(value, f"{where}{name}") for name, value in given.items()}
        yield from _combined(key, {n: v for n, v in stated.items() if v is not None}, where, rank)


def _is_name(value: object) -> TypeGuard[bool | str]:
    return isinstance(value, bool) or (isinstance(value, str) and bool(value.strip()))


def _combined(key: str, stated: dict[str, float], where: str, rank: Rank) -> Iterator[Found]:
    """One value from all that are stated for a key, with a note if they differ."""
    slowest, backward = key.startswith(PAIRS), key.startswith(LEAST)
    for name, value in stated.items():
        if value < 0 and (not slowest or key.startswith(TOP)):
            raise ScenarioError(f"{where}{name} = {value:g} must be above 0.")
    sizes = [max(-v, 0.0) if backward else abs(v) for v in stated.values() if v or backward]
    if not sizes:
        return
    note = ""
    if len(set(sizes)) > 1:
        words = "smaller size of" if slowest else "mean of"
        note = f" ({words} {', '.join(f'{s:g}' for s in sizes)})"
    value, source = min(sizes) if slowest else mean(sizes), f"{where}{' and '.join(stated)}{note}"
    if key == PERIOD:
        source, value = f"{source}: {value:g} Hz", STEP * max(1, round(1 / (value * STEP)))
    yield Found(key, rounded(0.0 - value if backward else value), source, rank)


def number(value: object, place: str) -> float | None:
    """A finite number; None if the file leaves it unstated, as by ``.nan``.

    Raises ScenarioError for anything else, such as a substitution.
    """
    if isinstance(value, str):
        if "$" in value:
            raise ScenarioError(
                f"{place} = {show(value)} is a substitution that cannot be expanded here. Write "
                "the number in its place."
            )
        with suppress(ValueError):
            value = float(value)
    if isinstance(value, bool) or not isinstance(value, int | float) or abs(value) > LARGEST:
        raise ScenarioError(f"{place} = {show(value)} must be a number of usual size.")
    return None if math.isnan(value) else float(value)


def rounded(value: float) -> float:
    """A value with six digits, without rounding errors of its computation."""
    return float(f"{value:.6g}")
