"""Memory of past samples in Systems: the last values of a quantity."""

from __future__ import annotations

from dataclasses import dataclass, replace

from wmr_ctrl.core.fields.section import quantity
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.core.symbolic import ca

from .model.system import Port, ports, stack

MOST_REMEMBERED = 500
"""Samples that a sensor or an observer may remember: each is a state that is compiled."""


@dataclass(frozen=True)
class History:
    """A quantity ``aged[j]`` samples ago for j = 0 to ``count``, with its state and update.

    Before the first sample it has its first value: the robot rested.
    """

    aged: tuple[ca.SX, ...]
    state: tuple[Port, ...]
    update: ca.SX


def history(signal: Signal, now: ca.SX, first: ca.SX, count: int) -> History:
    """The last ``count`` values of ``now``; ``first`` is 1 at the first sample, else 0."""
    name, meaning, ages = signal.name, signal.meaning, range(1, count + 1)
    state = ports(
        replace(signal, name=f"{name}_{k}", meaning=f"{meaning}, {k} samples ago") for k in ages
    )
    aged = (now, *(ca.if_else(first, now, item.sym) for item in state))
    return History(aged, state, stack(aged[:count]))


def remembered(doc: str) -> float:
    """Field of a section: time [s] that a sensor looks back, a multiple of clock.control."""
    return multiple(doc, "clock.control", usual=(0, 5), most=MOST_REMEMBERED)


def multiple(
    doc: str, of: str, usual: tuple[float, float], most: int = 0, maximum: float | None = None
) -> float:
    """Field of a section: a time [s] that is a multiple of a period or step, from 0 on."""
    said = f"{doc}, a multiple of {of}"
    return quantity(
        0.0, "s", said, minimum=0, maximum=maximum, usual=usual, multiple_of=of, most=most
    )
