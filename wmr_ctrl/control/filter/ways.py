"""Stopping distance of a base with a first-order speed loop, towards one side of one axis.

In a stop the command u that is sent now takes over within ``last`` and acts for at most ``acts``;
then 0 acts, and after a ``rest`` B of 0 the base stands and holds (a brake, control at standstill).
With A(t; tau) = tau (1 - exp(-t/tau)) and q = A/tau, a base with speed w when u takes over then
moves by at most

    m s + r w + d B - d A_B,    s = D - A + A_B q,    r = A + A_B (1 - q),    A_B = A(B; tau_max)

for a steady speed m = K_max u + d >= d, where D is the longest time for which u acts, and tau (in A
and q) is its least or largest value.  The largest m whose stop ends within the free distance
follows from one line for each time at which u may take over and each end of tau
(`filter.free.plan`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import Generic

import casadi as ca

from wmr_ctrl.core.signals import LARGEST
from wmr_ctrl.world.model.system import Number

from .governor import NEAR, FirstOrder, Piece, SpeedBound, largest, relaxed


def covered(time: Number, tau: Number) -> Number:
    """Distance per m/s of a speed that decays with ``tau`` for a ``time`` [s]."""
    return -tau * ca.expm1(-time / tau)


def told_command(V: ca.SX, v_bar: ca.SX, b: FirstOrder, slowest: ca.SX) -> ca.SX:
    """Largest command for a limit V that may be below v_bar, the bound of the speed.

    ``slowest``: 1/(exp(h/tau_max) - 1) of the least time for which it acts.
    """
    room = V - v_bar
    command = (V - b.dbar + ca.fmin(b.kappa * room, slowest * room)) / b.K_max
    return ca.if_else(b.dbar < V, ca.fmax(0, command), 0)


def farthest(v: ca.SX, target: ca.SX, time: ca.SX, least: ca.SX, most: ca.SX) -> ca.SX:
    """Distance in a ``time`` [s] from the speed v towards ``target``.

    ``least`` and ``most`` bound `covered` of that time.
    """
    away = v - target
    return target * time + ca.fmax(away * least, away * most)


@dataclass(frozen=True)
class Reached(Generic[Number]):
    """Bounds at the end of a piece: instant [s], distance driven since now, and speed (>= 0)."""

    instant: Number
    way: Number
    speed: Number


@dataclass(frozen=True)
class Stop(Generic[Number]):
    """Course of an axis that comes to rest; times in s.

    ``tau``: least and largest.  ``push``: d.  ``rest``: None if only the loop brakes.  ``acts``:
    longest time between commands.  ``last``: largest delay.  ``nearing``: speed at which obstacles
    approach.
    """

    tau: tuple[Number, Number]
    push: Number
    rest: Number | None
    acts: Number
    last: Number
    nearing: Number

    @property
    def fading(self) -> Number:
        """Distance during the rest per m/s of speed at its start, for the largest tau."""
        return self.tau[1] if self.rest is None else covered(self.rest, self.tau[1])

    @cached_property
    def quick(self) -> Number:
        """Distance during the rest per m/s of speed at its start, for the least tau."""
        return self.tau[0] if self.rest is None else covered(self.rest, self.tau[0])

    @property
    def creep(self) -> Number:
        """Distance due to a push during the rest."""
        return 0 * self.push if self.rest is None else self.push * self.rest

    @property
    def time(self) -> Number:
        """Longest time from a command to standstill."""
        return self.last + self.acts + (0 if self.rest is None else self.rest)

    @property
    def roll(self) -> Number:
        """Largest distance due to a push after a command away from rest is released."""
        if self.rest is None:
            return 0 * self.push
        return self.push * (self.rest - self.quick)

    def hold(self, pull: Number) -> Number:
        """Time after which a command away with this ``pull`` has gained the distance of a
        release.
        """
        return self.roll / pull + self.tau[1] - self.quick

    def room(self, free: Number) -> Number:
        """Free distance less the part that any stop needs."""
        return free - self.nearing * self.time - self.creep + self.fading * self.push

    def line(self, instant: Number, tau: Number) -> tuple[Number, Number]:
        """s and r of a command that takes over at this instant [s]."""
        longest = self.acts + (self.last - instant)
        way = covered(longest, tau)
        share = way / tau
        return longest - way + self.fading * share, way + self.fading * (1 - share)

    def steady(self, free: Number, takeovers: Sequence[Reached[Number]]) -> Number:
        """Largest steady speed m whose stop ends within ``free``; none exists below ``push``."""
        room, most = self.room(free), list[Number]()
        for at in takeovers:
            for tau in self.tau:
                s, r = self.line(at.instant, tau)
                most.append((room - at.way - r * ca.fmax(at.speed, self.push)) / s)
        least: Number = reduce(ca.fmin, most)
        return least

    def retreat(self, way: Number, speed: Number, target: Number) -> Number:
        """Free distance that a command away needs, if it drives at most to ``target`` <= 0.

        ``way``: driven before it takes over; ``speed`` <= 0: at that time.
        """
        rolls = self.creep + (ca.fmax(speed, target) - self.push) * self.quick
        return self.nearing * self.time + way + ca.fmax(0, rolls)


@dataclass(frozen=True)
class ToldBound(SpeedBound):
    """`SpeedBound` with changing limits, on a base with a brake.

    Lists are by age of the command, [0] the newest: ``most`` bounds the speed while it acts;
    ``still`` is 1 if it may act as (0, 0), during which a brake may end any motion.  ``punctual``:
    1 if all commands that may act were sent in time.
    """

    punctual: ca.SX
    most: Sequence[ca.SX] = ()
    still: Sequence[ca.SX] = ()

    @property
    def stopped(self) -> list[ca.SX]:
        """Steady speed of a base that stops on its own, if it may."""
        if self.schedule.stops_alone:
            return super().stopped
        return [ca.if_else(self.punctual, -LARGEST, push) for push in super().stopped]

    def carried(
        self,
        v: ca.SX,
        piece: Piece,
        targets: Sequence[ca.SX],
        shares: tuple[ca.SX, ca.SX],
        cut: bool = True,
    ) -> ca.SX:
        """Bound of the speed after a piece with these shares, always limited by `cap`."""
        start, target = self._lifted(v, piece), self.target(piece, targets)
        return self._lifted(ca.fmin(relaxed(start, target, *shares), self.cap(piece)), piece)

    def cap(self, piece: Piece) -> ca.SX:
        """Bound of the speed in a piece from the commands that may act in it."""
        most = largest([*(self.most[age] for age in reversed(piece.ages)), *self.stopped])
        return most if self.schedule.stops_alone else ca.if_else(self.punctual, most, self.bounds.V)

    def _lifted(self, v: ca.SX, piece: Piece) -> ca.SX:
        """A bound of the speed that also holds if a brake closes in this piece."""
        if self.schedule.stops_alone and self.still:
            return ca.fmax(v, 0)
        still = [self.still[age] for age in piece.ages if self.still]
        return ca.if_else(reduce(ca.logic_or, still), ca.fmax(v, 0), v) if still else v

    def onward(
        self, v: ca.SX, pieces: Sequence[Piece], targets: Sequence[ca.SX]
    ) -> Iterator[Reached[ca.SX]]:
        """Distance and speed at the end of each piece; backward motion counts as 0."""
        way, speed = ca.SX(0), ca.fmax(v, 0)
        for piece in pieces:
            time = (piece.end - piece.start) * self.period
            target, shares = ca.fmax(self.target(piece, targets), 0), self.shares(time)
            way += farthest(speed, target, time, *(covered(time, tau) for tau in self.tau))
            speed = ca.fmax(ca.fmin(relaxed(speed, target, *shares), self.cap(piece)), 0)
            yield Reached(piece.end * self.period, way, speed)

    def present(self, v: ca.SX) -> ca.SX:
        """Bound ``v`` of the present speed, limited by the commands that may act until the sample.

        If all others are lost, and none is late, the last one of these has ceased to act by then.
        A brake may close at the instant of the sample, after the odometry was read.
        """
        plan, lost = self.schedule, self.schedule.losses
        ages = [age for age in range(1, max(plan.oldest, 1 + lost) + 1)
                if age <= 1 + lost or plan.acts(age)]  # fmt: skip
        meeting = tuple(age for age in range(1, len(self.most)) if plan.meets(age))
        now = ca.fmin(v, self.cap(Piece(0.0, 0.0, tuple(ages))))
        return self._lifted(now, Piece(0.0, 0.0, meeting))

    def takeovers(self, v: ca.SX, targets: Sequence[ca.SX]) -> list[Reached[ca.SX]]:
        """Distance and speed at each instant at which the next command may take over."""
        first, last = self.schedule.delay
        pieces = self.schedule.pieces(0.0, last, 1, first) if last else []
        reached = list(self.onward(v, pieces, targets))
        ends = [at for at, piece in zip(reached, pieces, strict=True) if piece.end >= first - NEAR]
        return ends if first > NEAR else [Reached(ca.SX(0), ca.SX(0), ca.fmax(v, 0)), *ends]

    def until_next(self, v: ca.SX, targets: Sequence[ca.SX]) -> ca.SX:
        """Largest distance until the next sample; ``targets[0]`` is that of the command just
        sent.
        """
        jitter = self.schedule.jitter
        pieces = self.schedule.pieces(0.0, 1 + jitter, 0, 1 - jitter)
        *_, end = self.onward(v, pieces, targets)
        return end.way
