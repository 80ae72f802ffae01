"""The guard with late velocities or behind slow drives: what was sent cannot be called back.

A command that is computed now acts only after the delay.  Until then the commands that were sent
before it act, and where the measured velocity is old they have acted since.  By the time the new
one takes over, v can have risen, and -v can have risen, by at most

    ahead = sum tau_j max(F_j + net, 0)/M_min,      back = sum tau_j max(net - F_j, 0)/M_min,

with net = dbar - f_min and the times tau_j that `lateness` gives; behind a constant delay the j-th
command acts for tau_j from now on.  The guard counts that as speed: the limit is kept by what

    reached = max(max(y + nbar, f_speed) + ahead, f_speed + ahead counted from the oldest instant)

leaves.  The second part is there for means alone: friction may have stopped the robot within the
window.  With a jitter J of the delay, the last command may act for J more.

So that the room ahead and the room behind never run out together, no command may be larger than

    largest = (M_min (v_u1 - f_speed) - max(brake + net, 0)/alpha)/delay - net,

and, with jitter, than M_min (v_u1 - 2 nbar)/mixed - net.  ``delay`` is all that counts (see
`Counting`).  A braking command is not counted in favour.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from typing import TYPE_CHECKING

import casadi as ca

from wmr_ctrl.guard.lateness import Counting, Piece
from wmr_ctrl.model.system import Port, port
from wmr_ctrl.signals import Signal

if TYPE_CHECKING:
    from wmr_ctrl.guard.guard import Bounds

Sent = Sequence[tuple[ca.SX, ca.SX | float]]
"""Forces (2, n) of which any may act [N, N m], with the periods for which they count."""


@dataclass(frozen=True)
class UnderWay:
    """What one axis' commands under way can add to v (ahead) and to -v (back) [m/s or rad/s].

    ``since_rest``: the same counted from the window's oldest instant; ``again``: what the last
    command adds where the new one comes as late as it may.  None where that makes no difference.
    """

    ahead: ca.SX
    back: ca.SX
    since_rest: UnderWay | None = None
    again: UnderWay | None = None

    def plus(self, other: UnderWay, share: float) -> UnderWay:
        """The sums with a share of others'."""
        return UnderWay(self.ahead + share * other.ahead, self.back + share * other.back)

    @property
    def mirrored(self) -> UnderWay:
        """The same seen in the other direction."""
        rest, again = (item and item.mirrored for item in (self.since_rest, self.again))
        return UnderWay(self.back, self.ahead, rest, again)

    def reached(self, fastest: ca.SX, b: Bounds) -> ca.SX:
        """Largest v+ when the new command takes over at the earliest, from ``fastest`` measured."""
        measured = fastest + self.ahead
        if self.since_rest is None:
            return measured
        return ca.fmax(measured, b.f_speed + self.since_rest.ahead)

    def left(self, room: ca.SX, b: Bounds) -> ca.SX:
        """Room [m/s or rad/s] less what either command may do until the new one is sure to act."""
        if self.again is None:
            return room
        assert b.jitter is not None
        return ca.fmin(room - self.again.ahead, room / (1 + b.alpha * b.jitter))


def under_way(sent: Sent, axis: int, b: Bounds) -> UnderWay:
    """Of forces that were sent, with the periods for which each counts."""
    ahead, back = ca.SX(0), ca.SX(0)
    for force, periods in sent:
        ways = ca.horzsplit(force[axis, :])
        ahead += periods * ca.fmax(reduce(ca.fmax, ways) + b.net, 0)
        back += periods * ca.fmax(b.net - reduce(ca.fmin, ways), 0)
    return UnderWay(ahead * b.period / b.M_min, back * b.period / b.M_min)


def largest_force(b: Bounds) -> ca.SX:
    """Of one axis, behind a delay [N or N m]; at least what it brakes with."""
    assert b.delay is not None
    held_back = ca.fmax(b.braking + b.net, 0) / b.alpha
    largest = (b.M_min * (b.u1 - b.f_speed) - held_back) / b.delay - b.net
    if b.mixed is None:
        return largest
    return ca.fmin(largest, b.M_min * (b.u1 - 2 * b.nbar) / b.mixed - b.net)


def counted(
    forces: Sequence[ca.SX], late: Counting, axis: int, b: Bounds, tail: UnderWay | None
) -> UnderWay | None:
    """What ``forces`` (2,), the latest first, and the ``tail`` of older ones count for.

    None where nothing is late.
    """
    if late.at_once:
        return None
    mean = under_way(acting(late.mean, forces), axis, b)
    if tail is not None:
        assert late.tail is not None
        mean = mean.plus(tail, late.tail.share)
    if not (late.averaged or late.jitter):
        return mean
    rest = again = None
    if late.averaged:
        rest = under_way(acting(late.rest, forces), axis, b)
        rest = rest if tail is None else rest.plus(tail, 1.0)
    if late.jitter:
        again = under_way([(forces[0], late.jitter)], axis, b)
    return UnderWay(mean.ahead, mean.back, rest, again)


def acting(pieces: Sequence[Piece], forces: Sequence[ca.SX]) -> Sent:
    """The forces of each piece with what it counts for; ``forces`` (2,), the latest first."""
    return [(ca.horzcat(*(forces[j - 1] for j in which)), time) for which, time in pieces]


class Tails:
    """State behind a lag: what commands older than those listed count for, both axes, both ways.

    Kept as a difference from where a force of 0 leads, so that it starts at 0 [N.s or N.m.s].
    """

    def __init__(self, name: str, late: tuple[Counting, Counting]) -> None:
        """``name`` of the state; there is none without a lag."""
        self.late = late
        meaning = "what older commands still do, less that of a force of 0 (ahead, back; two axes)"
        signal = Signal(name, "N.s, N.s, N.m.s, N.m.s", meaning, 4)
        self.state: tuple[Port, ...] = (port(signal),) if late[0].tail or late[1].tail else ()

    def of(self, axis: int, b: Bounds) -> UnderWay | None:
        """What they can add to the velocity of one axis."""
        tail = self.late[axis].tail
        if tail is None:
            return None
        steady = tail.steady * b.period * ca.fmax(b.net, 0)
        ahead, back = (self.state[0].sym[2 * axis + i] + steady for i in (0, 1))
        return UnderWay(ahead / b.M_min, back / b.M_min)

    def following(self, forces: Sequence[ca.SX], both: Bounds) -> ca.SX:
        """The next state; ``forces`` (2,) with the new one first."""
        rows = [self._next(axis, forces, both.axis(axis)) for axis in (0, 1)]
        return ca.vertcat(*rows) if self.state else ca.SX(0, 1)

    def _next(self, axis: int, forces: Sequence[ca.SX], b: Bounds) -> ca.SX:
        late = self.late[axis]
        if late.tail is None:
            return ca.SX.zeros(2 if self.state else 0)
        n, (sure, mixed) = late.commands, late.tail.entering
        old = [((n + 1,), sure), *([((n + 1, n), mixed)] if mixed > 0 else [])]
        joined = under_way(acting(old, forces), axis, b)
        steady = (sure + mixed) * b.period * ca.fmax(b.net, 0)
        stays = late.tail.decay * self.state[0].sym[2 * axis : 2 * axis + 2]
        return stays + ca.vertcat(joined.ahead, joined.back) * b.M_min - steady
