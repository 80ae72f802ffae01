"""The push that may be felt behind drives whose time constant varies: Z of `varying`, as a graph.

One axis, both directions (ahead, back).  Since the push that is felt is at most Z, v+ rises by at
most the integral of Z over M_min; what is under way when the new command takes over ends up, for
any time constants to come, in at most b Z more.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from typing import TYPE_CHECKING

import casadi as ca

from wmr_ctrl.guard.varying import Passage

if TYPE_CHECKING:
    from wmr_ctrl.guard.guard import Bounds

Number = float | ca.SX
Both = tuple[ca.SX, ca.SX]
"""Ahead and back."""


@dataclass(frozen=True)
class Lagging:
    """Z [N or N m] when the new command may first take over, ``now``, and when it is sure to.

    A command of larger p than Z counts for ``rise`` [s] more of the difference than for the time T
    that it acts, for ``rise_late`` more than for T + J.
    """

    now: Both
    after: Both
    rise: ca.SX
    rise_late: ca.SX

    @property
    def mirrored(self) -> Lagging:
        """The same seen in the other direction."""
        now, after = self.now[::-1], self.after[::-1]
        return Lagging((now[0], now[1]), (after[0], after[1]), self.rise, self.rise_late)

    def left(self, room: ca.SX, again: ca.SX, b: Bounds) -> list[ca.SX]:
        """What may be left of the room [m/s or rad/s] less ``again``, for a p larger than Z."""
        sure = room - again + self.rise * self.after[0] / b.M_min
        lines = [sure / (1 + b.alpha * self.rise)]
        if b.jitter is not None:
            late = room + self.rise_late * self.now[0] / b.M_min
            lines.append(late / (1 + b.alpha * (b.jitter + self.rise_late)))
        return lines


@dataclass(frozen=True)
class Followed:
    """What Z integrates to over the pieces [N s or N m s], as mean and rest count, and its end."""

    mean: ca.SX
    rest: ca.SX
    end: ca.SX


def follow(
    start: ca.SX, forces: Sequence[ca.SX], pieces: Sequence[Passage], axis: int, b: Bounds, way: int
) -> Followed:
    """From ``start`` through the pieces; ``forces`` (2,), the latest first; ``way`` 1 or -1."""
    mean, rest, z = ca.SX(0), ca.SX(0), start
    for item in pieces:
        p = push([forces[j - 1][axis] for j in item.which], b, way)
        mean += b.period * integral(z, p, item.mean)
        rest += b.period * integral(z, p, item.rest)
        z = moved(z, p, item.stays)
    return Followed(mean, rest, z)


def push(forces: Sequence[ca.SX], b: Bounds, way: int) -> ca.SX:
    """Largest max(F + net, 0), or max(net - F, 0) for -1, of forces of which any may act."""
    if way > 0:
        return ca.fmax(reduce(ca.fmax, forces) + b.net, 0)
    return ca.fmax(b.net - reduce(ca.fmin, forces), 0)


def moved(z: ca.SX, p: ca.SX, stays: tuple[Number, Number]) -> ca.SX:
    """Z after a piece under a push p."""
    return p + stays[0] * ca.fmax(z - p, 0) - stays[1] * ca.fmax(p - z, 0)


def integral(z: ca.SX, p: ca.SX, weights: tuple[Number, Number, Number]) -> ca.SX:
    """Weighted integral of Z over a piece, in periods times p's unit."""
    return weights[0] * p + weights[1] * ca.fmax(z - p, 0) - weights[2] * ca.fmax(p - z, 0)


def waiting(z: ca.SX, p: ca.SX, time: Number, rise: Number) -> ca.SX:
    """What a push p adds in a time to the integral of Z and b times its end [N s or N m s]."""
    return time * p + rise * ca.fmax(p - z, 0)
