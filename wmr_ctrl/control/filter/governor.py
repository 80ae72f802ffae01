"""Largest command that keeps |v| <= V on a base with a first-order speed loop, per axis.

The base: tau v' = K(t) u(t) + d(t) - v with tau in [tau_min, tau_max], K in [K_min, K_max] and |d|
<= dbar (m/s: the speed at which a push would end), all of which may vary; u is the command that
acts.  For a command that takes over at the speed v_0 <= v_bar and acts for at most H,

    v <= E v_0 + (1 - E)(K_max u + dbar) <= V      for    u <= hi,    E >= exp(-H/tau_min),
    hi = (V - dbar + kappa (V - v_bar))/K_max,     kappa = 1/(exp(H/tau_min) - 1)

v_bar bounds the speed at any instant at which the command may take over.  It comes from odometry,
or from the last bound, propagated through all commands that may act until then.  The lower bound is
the mirror image. kappa = 0 is the memoryless clip, (V - dbar)/K_max.

The governor knows no hidden state: a second lag, a ramp or an overshooting loop breaks its bound.
Bases with those need the clip or the band.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import pairwise

import casadi as ca

NEAR = 1e-9
"""Times that are nearer to each other than this share of a period are the same."""


@dataclass(frozen=True)
class FirstOrder:
    """Numbers of one axis: V, dbar, nbar [m/s or rad/s], K [1].

    Symbols, or numbers.  ``kappa`` is 1/(exp(H/tau_min) - 1), 0 for the memoryless clip.
    """

    V: ca.SX
    dbar: ca.SX
    nbar: ca.SX
    K_min: ca.SX
    K_max: ca.SX
    kappa: ca.SX


def drive(u: ca.SX, b: FirstOrder) -> ca.SX:
    """Largest steady speed [m/s or rad/s] that the command u can cause."""
    return ca.fmax(b.K_max * u, b.K_min * u) + b.dbar


def drive_back(u: ca.SX, b: FirstOrder) -> ca.SX:
    """`drive` of the negated speed, computed from the same products of u."""
    return b.dbar - ca.fmin(b.K_max * u, b.K_min * u)


def largest_command(v_bar: ca.SX, b: FirstOrder) -> ca.SX:
    """hi: largest safe command if it takes effect at a speed of at most v_bar."""
    return (b.V - b.dbar) / b.K_max + b.kappa / b.K_max * (b.V - v_bar)


def relaxed(v: ca.SX, target: ca.SX, most: ca.SX, least: ca.SX) -> ca.SX:
    """Bound of the speed after a time in which it moves towards at most ``target``.

    ``most`` and ``least`` bound the covered share of the distance to the target, 1 -
    exp(-time/tau); ``most`` matters for a target above v, ``least`` for one below.
    """
    away = v - target
    return v + ca.fmax(-most * away, -least * away)


def admitted(r: Sequence[ca.SX], lo: Sequence[ca.SX], hi: Sequence[ca.SX]) -> list[ca.SX]:
    """Largest share, at most 1, of each axis' command r within its limits lo <= 0 <= hi."""
    limits = [ca.if_else(r[i] >= 0, hi[i], -lo[i]) for i in range(len(r))]
    return [limit / ca.fmax(ca.fabs(r[i]), limit) for i, limit in enumerate(limits)]


@dataclass(frozen=True)
class Piece:
    """A time interval in which the same commands may act: start and end [periods], command ages."""

    start: float
    end: float
    ages: tuple[int, ...]


@dataclass(frozen=True)
class Schedule:
    """Timing of commands; all times in control periods, counted from a sample.

    A command takes over between ``delay[0]`` and ``delay[1]`` after its sample, in the order in
    which they were sent; at most ``losses`` in a row are lost. Samples are 1 -+ ``jitter`` apart,
    odometry is at most ``age`` old, and a base without commands keeps its last one for ``hold`` and
    stops (0: the filter is assumed to go on).
    """

    delay: tuple[float, float] = (0.0, 0.0)
    losses: int = 0
    jitter: float = 0.0
    age: float = 0.0
    hold: float = 0.0

    @property
    def acting(self) -> float:
        """Longest time between two commands, or until the base stops on its own [periods]."""
        return max((1 + self.losses) * (1 + self.jitter), self.hold)

    @property
    def longest(self) -> float:
        """H: longest time for which one command may act [periods]."""
        return self.acting + self.spread

    @property
    def spread(self) -> float:
        """Difference of the largest and the least delay [periods]."""
        return self.delay[1] - self.delay[0]

    @property
    def shortest(self) -> float:
        """h: least time for which a command acts, unless it is lost [periods]."""
        return max(1 - self.jitter - self.spread, 0.0)

    @property
    def stops_alone(self) -> bool:
        """True if the base may stop on its own between two punctual commands."""
        apart = (1 + self.losses) * (1 + self.jitter) + self.spread
        return 0 < self.hold < apart - NEAR

    @property
    def oldest(self) -> int:
        """Largest age of a command that may still act ``age`` before a sample."""
        age = 1
        while self._last(age + 1) > NEAR - self.age:
            age += 1
        return age

    def acts(self, age: int) -> bool:
        """True if the command of this age may act at a sample."""
        return age == 1 or self._last(age) > NEAR

    def meets(self, age: int) -> bool:
        """True if the command of this age may begin, act or end at a sample."""
        return self._first(age) < NEAR and self._last(age) > -NEAR

    def _first(self, age: int) -> float:
        """Earliest time at which the command of this age may take effect."""
        return self.delay[0] - age * (1 + self.jitter)

    def _last(self, age: int) -> float:
        """Latest time until which the command of this age may act."""
        newer = age - 1 - self.losses
        return self.delay[1] - newer * (1 - self.jitter if newer > 0 else 1 + self.jitter)

    def pieces(self, start: float, end: float, newest: int, cut: float = 0.0) -> list[Piece]:
        """Pieces from ``start`` to ``end``, with commands at least ``newest`` samples old.

        No piece contains the instant ``cut`` in its interior.
        """
        ages = range(newest, self.oldest + 1)
        inner = [cut, *(t for age in ages for t in (self._first(age), self._last(age)))]
        cuts = [start, *sorted({t for t in inner if start < t < end}), end]
        merged = [cuts[0], *(b for a, b in pairwise(cuts) if b - a > NEAR)]
        return [
            Piece(a, b, tuple(
                age for age in ages if self._first(age) < b - NEAR and self._last(age) > a + NEAR
            ))
            for a, b in pairwise(merged)
        ]  # fmt: skip


@dataclass(frozen=True)
class SpeedBound:
    """Bound of one axis' speed over time, with its time constants [s] and the period."""

    schedule: Schedule
    bounds: FirstOrder
    tau: tuple[ca.SX, ca.SX]
    period: ca.SX

    def shares(self, length: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Largest and least share of the distance to its target that the base covers in a
        ``length`` of time [s].
        """
        most, least = (-ca.expm1(-length / tau) for tau in self.tau)
        return most, least

    def carried(
        self,
        v: ca.SX,
        piece: Piece,
        targets: Sequence[ca.SX],
        shares: tuple[ca.SX, ca.SX],
        cut: bool = True,
    ) -> ca.SX:
        """Bound of the speed after a piece with these shares; ``targets[age]`` of each command.

        Without ``cut`` it may exceed V.
        """
        bound = relaxed(v, self.target(piece, targets), *shares)
        return ca.fmin(bound, self.bounds.V) if cut else bound

    @property
    def stopped(self) -> list[ca.SX]:
        """Steady speed of a base that stops on its own, if it may."""
        return [self.bounds.dbar] if self.schedule.hold > 0 else []

    def target(self, piece: Piece, targets: Sequence[ca.SX]) -> ca.SX:
        """Largest steady speed that the commands of a piece can cause."""
        return largest([*(targets[age] for age in reversed(piece.ages)), *self.stopped])

    def now(self, y: ca.SX, age: ca.SX, targets: Sequence[ca.SX]) -> ca.SX:
        """Bound of the present speed from odometry y that is ``age`` [s] old.

        Pieces before that age are skipped, and the piece that contains it counts in part.
        """
        v = start = ca.fmin(y + self.bounds.nbar, self.bounds.V)
        pieces = self.schedule.pieces(-self.schedule.age, 0.0, 1) if self.schedule.age else []
        part = self.shares(self.rest(age, pieces))
        for piece in pieces:
            began, over = -age <= piece.start * self.period, -age >= piece.end * self.period
            pairs = zip(self._whole(piece), part, strict=True)
            most, least = (-ca.if_else(began, -whole, -some) for whole, some in pairs)
            v = ca.if_else(over, v, self.carried(v, piece, targets, (most, least)))
        return ca.if_else(age > 0, v, start) if pieces else start

    def rest(self, age: ca.SX, pieces: Sequence[Piece]) -> ca.SX:
        """Remaining time [s] of the piece that contains this age."""
        rest, T = ca.SX(0), self.period
        for piece in reversed(pieces):
            rest = ca.if_else(-age < piece.end * T, piece.end * T + age, rest)
        return rest

    def _whole(self, piece: Piece) -> tuple[ca.SX, ca.SX]:
        return self.shares((piece.end - piece.start) * self.period)

    def takeover(self, v: ca.SX, targets: Sequence[ca.SX]) -> ca.SX:
        """v_bar: bound of the speed at any time at which the next command may take effect."""
        return self._during(v, self.schedule.delay, 1, targets)

    def following(self, v: ca.SX, targets: Sequence[ca.SX]) -> ca.SX:
        """Bound of the speed at the next sample; ``targets[0]`` is that of the command just sent.

        It may exceed V: stored bounds are limited to V when they are used.
        """
        jitter = self.schedule.jitter
        return self._during(v, (1 - jitter, 1 + jitter), 0, targets, cut=False)

    def _during(
        self,
        v: ca.SX,
        when: tuple[float, float],
        newest: int,
        targets: Sequence[ca.SX],
        cut: bool = True,
    ) -> ca.SX:
        """Largest bound at any time between the first and last of ``when`` [periods] after a
        sample.

        The bound is monotone within each piece.  Consecutive pieces with equal commands are
        computed from the start of the first, so that they do not depend on each other.  At the end
        of each the base has covered at least the share of the distance that it had covered after
        the first.
        """
        first, last = when
        ends, ages, least = list[ca.SX](), None, ca.SX(0) if first <= NEAR else None
        began, start = 0.0, v
        pieces = self.schedule.pieces(0.0, last, newest, first) if last else []
        for piece in pieces:
            cuts = cut or piece is not pieces[-1]
            if ages not in (None, piece.ages):  # else carried from where these began to act
                began, start, least = piece.start, v, None
            ages = piece.ages
            shares = self.shares((piece.end - began) * self.period)
            v = self.carried(start, piece, targets, shares, cuts)
            if piece.end < first - NEAR:
                continue
            if least is None:
                least = shares[1]
                ends.append(v)
            else:
                ends[-1:] = [self.carried(start, piece, targets, (shares[0], least), cuts)]
        return largest(ends or [v])


def largest(items: Sequence[ca.SX]) -> ca.SX:
    """The largest of some expressions."""
    return reduce(ca.fmax, items)
