"""The guard with late velocities or slow drives: commands in transit cannot be recalled.

A command that is computed now acts only after the delay.  Until then the earlier commands act; if
the measured velocity is old, they have acted since its time.  By the time the new command takes
effect, v and -v can have risen by at most

    ahead = sum tau_j max(F_j + net, 0)/M_min,      back = sum tau_j max(net - F_j, 0)/M_min,

with net = dbar - f_min and the times tau_j of `lateness`; behind a constant delay the j-th command
acts for tau_j from now on.  The guard adds this to the speed: the room up to the limit is
calculated with

    reached = max(max(y + nbar, f_speed) + ahead, f_speed + ahead from the oldest instant).

The second part matters only for averaged velocities: friction may have stopped the robot within the
window.  With a jitter J of the delay, the last command may act for J more.

So that the room ahead and the room behind never run out together, no command may be larger than

    largest = (M_min (v_u1 - f_speed) - max(brake + net, 0)/alpha)/delay - net,

and, with jitter, than M_min (v_u1 - 2 nbar)/mixed - net.  ``delay`` here is the longest time that
matters (see `Counting`).  A braking command gets no credit.

If the drives' time constant varies, the push that acts is at most Z of `varying`, so v+ rises by at
most the integral of Z over M_min.  The commands in transit when the new one takes over add at most
b Z in the end, for any later time constants.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from typing import TYPE_CHECKING

import casadi as ca

from wmr_ctrl.core.signals import Signal
from wmr_ctrl.world.model.system import Port, port

from .lateness import Counting, Piece, Since
from .varying import Passage, Varying

if TYPE_CHECKING:
    from .guard import Bounds

Sent = Sequence[tuple[ca.SX, ca.SX | float]]
"""Forces (2, n) of which any may act [N, N m], with the periods for which they count."""

Number = float | ca.SX
Both = tuple[ca.SX, ca.SX]
"""Ahead and back."""


@dataclass(frozen=True)
class Lagging:
    """Z [N or N m] at the earliest (``now``) and the latest start of the new command.

    If a command's p exceeds Z, the difference counts for ``rise`` [s] beyond the time T that the
    command acts, and for ``rise_late`` [s] beyond T + J.
    """

    now: Both
    after: Both
    rise: ca.SX
    rise_late: ca.SX

    @property
    def mirrored(self) -> Lagging:
        """This value for the opposite direction."""
        now, after = self.now[::-1], self.after[::-1]
        return Lagging((now[0], now[1]), (after[0], after[1]), self.rise, self.rise_late)

    def left(self, room: ca.SX, again: ca.SX, b: Bounds) -> list[ca.SX]:
        """Bounds [m/s or rad/s] on the room, less ``again``, if p is larger than Z."""
        sure = room - again + self.rise * self.after[0] / b.M_min
        lines = [sure / (1 + b.alpha * self.rise)]
        if b.jitter is not None:
            late = room + self.rise_late * self.now[0] / b.M_min
            lines.append(late / (1 + b.alpha * (b.jitter + self.rise_late)))
        return lines


@dataclass(frozen=True)
class InFlight:
    """Largest change of v (ahead) and -v (back) by an axis' commands in transit [m/s or rad/s].

    ``since_rest``: counted from the window's oldest time.  ``again``: the last command's share if
    the new one comes as late as possible.  ``slow``: the push that acts behind a varying lag.  None
    if it makes no difference.
    """

    ahead: ca.SX
    back: ca.SX
    since_rest: InFlight | None = None
    again: InFlight | None = None
    slow: Lagging | None = None

    def plus(self, other: InFlight, share: float) -> InFlight:
        """These sums plus ``share`` times the other's."""
        return InFlight(self.ahead + share * other.ahead, self.back + share * other.back)

    @property
    def mirrored(self) -> InFlight:
        """This value for the opposite direction."""
        rest, again = (item and item.mirrored for item in (self.since_rest, self.again))
        return InFlight(self.back, self.ahead, rest, again, self.slow and self.slow.mirrored)

    def reached(self, fastest: ca.SX, b: Bounds) -> ca.SX:
        """Largest v+ at the earliest start of the new command, from ``fastest``, the largest
        measured speed.
        """
        measured = fastest + self.ahead
        if self.since_rest is None:
            return measured
        return ca.fmax(measured, b.f_speed + self.since_rest.ahead)

    def left(self, room: ca.SX, b: Bounds) -> ca.SX:
        """Room [m/s or rad/s] less the push of both commands until the new one surely acts."""
        lines, again = [room], ca.SX(0)
        if self.again is not None:
            assert b.jitter is not None
            again = self.again.ahead
            lines = [room - again, room / (1 + b.alpha * b.jitter)]
        if self.slow is not None:
            lines += self.slow.left(room, again, b)
        return reduce(ca.fmin, lines)


def in_flight(sent: Sent, axis: int, b: Bounds) -> InFlight:
    """Sums over the sent forces, each with the number of periods for which it acts."""
    ahead, back = ca.SX(0), ca.SX(0)
    for force, periods in sent:
        ways = ca.horzsplit(force[axis, :])
        ahead += periods * ca.fmax(reduce(ca.fmax, ways) + b.net, 0)
        back += periods * ca.fmax(b.net - reduce(ca.fmin, ways), 0)
    return InFlight(ahead * b.period / b.M_min, back * b.period / b.M_min)


def largest_force(b: Bounds) -> ca.SX:
    """Largest force of one axis behind a delay [N or N m], at least its braking force."""
    assert b.delay is not None
    held_back = ca.fmax(b.braking + b.net, 0) / b.alpha
    largest = (b.M_min * (b.narrow - b.f_speed) - held_back) / b.delay - b.net
    if b.mixed is None:
        return largest
    return ca.fmin(largest, b.M_min * (b.narrow - 2 * b.nbar) / b.mixed - b.net)


def delayed_push(
    forces: Sequence[ca.SX], late: Counting, axis: int, b: Bounds, tails: Tails
) -> InFlight | None:
    """Push of ``forces`` (2,), the latest first, and of the older ones in ``tails``.

    None if nothing is late.
    """
    if late.at_once:
        return None
    if late.varying:
        return _felt(forces, late, late.varying, axis, b, tails)
    mean = tails.added(in_flight(acting(late.mean, forces), axis, b), axis, b, averaged=True)
    if not (late.averaged or late.jitter):
        return mean
    rest = again = None
    if late.averaged:
        rest = tails.added(in_flight(acting(late.rest, forces), axis, b), axis, b)
    if late.jitter:
        again = in_flight([(forces[0], late.jitter)], axis, b)
    return InFlight(mean.ahead, mean.back, rest, again)


def _felt(
    forces: Sequence[ca.SX], late: Counting, numbers: Varying, axis: int, b: Bounds, tails: Tails
) -> InFlight:
    """Integrals of the push that acts behind a varying lag, plus b times its last value."""
    ahead, back = tails.followed(forces, numbers.pieces, axis, b)
    left = b.period * numbers.longest
    mean, rest = (
        InFlight((first + left * ahead.end) / b.M_min, (second + left * back.end) / b.M_min)
        for first, second in ((ahead.mean, back.mean), (ahead.rest, back.rest))
    )
    again, now = None, (ahead.end, back.end)
    after = now
    if late.jitter:
        p = [push([forces[0][axis]], b, way) for way in (1, -1)]
        times = b.period * late.jitter, b.period * numbers.rises[0]
        more = [waiting(now[i], p[i], *times) / b.M_min for i in (0, 1)]
        again = InFlight(more[0], more[1])
        after = moved(now[0], p[0], numbers.stays), moved(now[1], p[1], numbers.stays)
    rises = [b.period * time for time in numbers.rises[1:]]
    slow = Lagging(now, after, rises[0], rises[1])
    return InFlight(mean.ahead, mean.back, rest if late.averaged else None, again, slow)


def moved_since(
    sent: Sequence[ca.SX], since: Since, axis: int, b: Bounds, tails: Tails
) -> tuple[InFlight, InFlight]:
    """Motion since the previous sample that ``sent`` explains, with weights of mean and rest."""
    if since.varying:
        ahead, back = tails.followed(sent, since.varying.pieces, axis, b)
        return (
            InFlight(ahead.mean / b.M_min, back.mean / b.M_min),
            InFlight(ahead.rest / b.M_min, back.rest / b.M_min),
        )
    mean, rest = (in_flight(acting(pieces, sent), axis, b) for pieces in (since.mean, since.rest))
    return tails.added(mean, axis, b, averaged=True), tails.added(rest, axis, b)


def acting(pieces: Sequence[Piece], forces: Sequence[ca.SX]) -> Sent:
    """The forces of each piece, with their weight; ``forces`` (2,), the latest first."""
    return [(ca.horzcat(*(forces[j - 1] for j in which)), time) for which, time in pieces]


@dataclass(frozen=True)
class Followed:
    """Integral of Z over the pieces [N s or N m s], weighted for mean and rest, and its end."""

    mean: ca.SX
    rest: ca.SX
    end: ca.SX


def follow(
    start: ca.SX, forces: Sequence[ca.SX], pieces: Sequence[Passage], axis: int, b: Bounds, way: int
) -> Followed:
    """Z after each piece, from ``start``; ``forces`` (2,), the latest first; ``way`` is 1 or -1."""
    mean, rest, z = ca.SX(0), ca.SX(0), start
    for item in pieces:
        p = push([forces[j - 1][axis] for j in item.which], b, way)
        mean += b.period * integral(z, p, item.mean)
        rest += b.period * integral(z, p, item.rest)
        z = moved(z, p, item.stays)
    return Followed(mean, rest, z)


def push(forces: Sequence[ca.SX], b: Bounds, way: int) -> ca.SX:
    """Largest max(F + net, 0), or max(net - F, 0) for way -1, over the forces that may act."""
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
    """Impulse of a push p during a time, as the integral of Z and as b times its end [N s or N m
    s].
    """
    return time * p + rise * ca.fmax(p - z, 0)


class Tails:
    """State for commands older than those listed, behind a lag, for both axes and directions.

    It is their weight [N.s or N.m.s] or, for a varying lag, the push from them that acts when the
    oldest listed one begins [N or N.m].  It is stored as the difference from the value for a force
    of 0, so that it starts at 0.
    """

    def __init__(self, name: str, late: tuple[Counting, Counting]) -> None:
        """Create the state called ``name``; there is none without a lag."""
        self.late = late
        unit, meaning = "N.s, N.s, N.m.s, N.m.s", "what older commands still do"
        if late[0].varying or late[1].varying:
            unit, meaning = "N, N, N.m, N.m", "largest push of older commands that may be felt"
        signal = Signal(
            name, unit, f"{meaning}, less that of a force of 0 (ahead, back; two axes)", 4
        )
        self.state: tuple[Port, ...] = (port(signal),) if late[0].lag or late[1].lag else ()

    def added(self, sums: InFlight, axis: int, b: Bounds, *, averaged: bool = False) -> InFlight:
        """The sums of listed commands plus those of older ones."""
        tail = self.late[axis].tail
        if tail is None:
            return sums
        steady = tail.steady * b.period * ca.fmax(b.net, 0)
        ahead, back = (self.state[0].sym[2 * axis + i] + steady for i in (0, 1))
        older = InFlight(ahead / b.M_min, back / b.M_min)
        return sums.plus(older, tail.share if averaged else 1.0)

    def followed(
        self, forces: Sequence[ca.SX], pieces: Sequence[Passage], axis: int, b: Bounds
    ) -> tuple[Followed, Followed]:
        """Push ahead and back behind a varying lag, from the oldest listed command on."""
        starts = [self.state[0].sym[2 * axis + i] + ca.fmax(b.net, 0) for i in (0, 1)]
        ahead = follow(starts[0], forces, pieces, axis, b, 1)
        return ahead, follow(starts[1], forces, pieces, axis, b, -1)

    def following(self, forces: Sequence[ca.SX], both: Bounds) -> ca.SX:
        """The next state; ``forces`` (2,) start with the new one."""
        rows = [self._next(axis, forces, both.axis(axis)) for axis in (0, 1)]
        return ca.vertcat(*rows) if self.state else ca.SX(0, 1)

    def _next(self, axis: int, forces: Sequence[ca.SX], b: Bounds) -> ca.SX:
        late = self.late[axis]
        if late.varying:
            ahead, back = self.followed(forces, late.varying.entering, axis, b)
            return ca.vertcat(ahead.end, back.end) - ca.fmax(b.net, 0)
        if late.tail is None:
            return ca.SX.zeros(2 if self.state else 0)
        n, (sure, mixed) = late.commands, late.tail.entering
        old = [((n + 1,), sure), *([((n + 1, n), mixed)] if mixed > 0 else [])]
        joined = in_flight(acting(old, forces), axis, b)
        steady = (sure + mixed) * b.period * ca.fmax(b.net, 0)
        stays = late.tail.decay * self.state[0].sym[2 * axis : 2 * axis + 2]
        return stays + ca.vertcat(joined.ahead, joined.back) * b.M_min - steady
