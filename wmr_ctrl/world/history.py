"""History: what a sensor remembers of the samples before this one, as state of its System."""

from __future__ import annotations

from dataclasses import dataclass

from wmr_ctrl.model.system import Port, port
from wmr_ctrl.signals import Signal
from wmr_ctrl.symbolic import ca

MOST_REMEMBERED = 500
"""Samples that a sensor or an observer may remember: each is a state that is compiled."""


@dataclass(frozen=True)
class History:
    """A quantity ``aged[j]`` samples ago for j = 0 to ``count``, the state for it and its update.

    Before the first sample it was what it is then: the robot stood still.
    """

    aged: tuple[ca.SX, ...]
    state: tuple[Port, ...]
    update: ca.SX


def history(signal: Signal, now: ca.SX, first: ca.SX, count: int) -> History:
    """The last ``count`` values of ``now``; ``first`` is 1 at the first sample, else 0."""
    state = tuple(
        port(Signal(f"{signal.name}_{age}", signal.unit, f"{signal.meaning}, {age} samples ago",
                    signal.size))
        for age in range(1, count + 1)
    )  # fmt: skip
    aged = (now, *(ca.if_else(first, now, item.sym) for item in state))
    return History(aged, state, ca.vertcat(*aged[:count]) if count else ca.SX(0, 1))
