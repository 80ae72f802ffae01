"""Sliders of the page: parameters in groups, each with its range.

Value, unit, meaning and bounds come from the fields that the parameters are named after.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from wmr_ctrl.control.numbers import ranges_of
from wmr_ctrl.core.data import data
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.world.scenario import Scenario
from wmr_ctrl.world.scenario.command_filter import FIRST_ORDER

from .scenes import stops

Span = tuple[float, float]


@dataclass(frozen=True)
class Group:
    """A group of sliders: title, hint, and the beginnings of its keys."""

    key: str
    title: str
    hint: str
    keys: list[str]


_DATA = data(__package__, "controls.toml")
GROUPS = [Group(**group) for group in _DATA["group"]]
"""Groups in the order of the page; a parameter belongs to the first group that names it."""
HIDDEN = tuple(_DATA["hidden"])
"""Parameters that a variant decides, or that nobody wants to move; `run` sets them all."""
DELAY = "base.delay"
"""Shown where a filter stops before obstacles; it needs a new run."""
OF_FIRST_ORDER = ("filter.gain", "filter.d")
"""Parameters that filters of other loops ignore, or use only in what is computed beforehand."""
SPANS: Mapping[str, Span] = {key: (low, high) for key, (low, high) in _DATA["spans"].items()}
"""Ranges other than a fifth to five times the value."""
ALONG: Mapping[str, Sequence[str]] = _DATA["along"]
"""Elements that keep their proportion to the one that is moved, and are not moved by themselves."""
WIDER = 5.0
AXES = ("linear", "angular")
ENDS = ("least", "most")
"""Elements of a pair that bounds one number."""


@dataclass(frozen=True)
class Control:
    """A slider: element of a parameter, its group, unit, meaning, range, and coupled parameters.

    ``bounds``: range of its field, for numbers from a link.
    """

    name: str
    group: str
    unit: str
    meaning: str
    span: Span
    bounds: Span
    log: bool
    along: Sequence[str]


def controls_of(
    scenario: Scenario, parameters: Iterable[Signal], values: Mapping[str, float]
) -> list[Control]:
    """Sliders for the parameter elements that belong to a group, in the groups' order."""
    unused = () if scenario.filter.loop == FIRST_ORDER else OF_FIRST_ORDER
    signals = {item.name: item for item in parameters if item.name not in unused}
    bounds = ranges_of(scenario, signals)
    hidden = () if stops(scenario) else (DELAY,)
    moved = {name for names in ALONG.values() for name in names}
    controls = [
        _control(signal, i, group.key, bounds.get(signal.name, (-math.inf, math.inf)), values)
        for group in GROUPS
        for signal in signals.values()
        if _group(signal.name) == group.key
        for i in range(signal.size)
    ]
    return [item for item in controls if item.name not in moved and item.name not in hidden]


def _group(name: str) -> str | None:
    if name.startswith(HIDDEN):
        return None
    return next((item.key for item in GROUPS if name.startswith(tuple(item.keys))), None)


def _control(
    signal: Signal, i: int, group: str, bounds: Span, values: Mapping[str, float]
) -> Control:
    name = signal.elements[i]
    span, value = SPANS.get(name), values[name]
    if span is None and (value == 0 or math.isinf(value)):
        span = (max(bounds[0], 0.0), 1.0)
    elif span is None:  # a fifth to five times a value, within its bounds; 0 has no sign
        low, high = sorted((value / WIDER, value * WIDER))
        span = max(low, bounds[0]), min(high, bounds[1])
    log = span[0] > 0 and span[1] / span[0] > 8
    along = ALONG.get(name, ())
    parts = ENDS if signal.meaning.startswith("bounds of") else AXES
    meaning = f"{signal.meaning} ({parts[i]})" if signal.size == 2 else signal.meaning
    return Control(name, group, signal.units[i], meaning, span, bounds, log, along)
