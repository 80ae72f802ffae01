"""Forecast of a linear loop from the commands sent to it, on pieces of time.

It bounds v - u and -v + u if the command u stays constant.  It also gives the largest commands that
keep v and -v within a limit: if kept from now on, and if followed by 0.  `band` has the sum that is
bounded here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce

import casadi as ca

PIECES = 2
"""Pieces of the tables in a period."""
FLATTEST = 2.0**-30
"""Smallest slope of a condition; by this share of c the bound may be passed, a sixteenth of what is
kept back against rounding."""
HELD = 1 + FLATTEST + 2.0**-46
"""Share of c that is allowed where a command is held: 0 that was admitted before is there, too,
whatever is rounded."""
PAST = 1 + 2.0**-29
"""Share of c at most that commands sent before an untimely sample are assumed to take: it is above
the allowed share by more than roundings add to that, so that nothing adds up from one such sample
to the next."""
SPARE = 1 + 2.0**-40
"""Factor of what is kept of the past, so that no rounding makes it too little."""


@dataclass(frozen=True)
class ResponseTable:
    """Bounds of a step response on each piece, and its decay after them.

    ``above`` bounds the response less 1 on each piece, ``below`` the negative of that, and ``left``
    both after the last piece, where it decays by ``fading`` per period.  ``after`` bounds, from the
    second period on, the response to a step one period later.
    """

    above: ca.SX
    below: ca.SX
    after: ca.SX
    left: ca.SX
    fading: ca.SX

    @property
    def low(self) -> ca.SX:
        """Lower bounds on each piece; the last one is valid for ever."""
        return 1 - ca.vertcat(self.below, self.left)

    @property
    def high(self) -> ca.SX:
        """Upper bounds on each piece; the last one is valid for ever."""
        return 1 + ca.vertcat(self.above, self.left)


@dataclass(frozen=True)
class Forecast:
    """Bounds of v - u and of -v + u on each piece and after them (``tail``), for constant u.

    ``over`` and ``under`` are due to commands since the last untimely sample, ``past_over`` and
    ``past_under`` to those before it.
    """

    over: ca.SX
    under: ca.SX
    tail: ca.SX
    u: ca.SX
    past_over: ca.SX
    past_under: ca.SX

    def changed(self, to: ca.SX, table: ResponseTable) -> Forecast:
        """The forecast if the command now changes to ``to``."""
        up, down = ca.fmax(to - self.u, 0), ca.fmax(self.u - to, 0)
        return replace(
            self,
            over=self.over + up * table.above + down * table.below,
            under=self.under + up * table.below + down * table.above,
            tail=self.tail + (up + down) * table.left,
            u=to,
        )

    def later(self, table: ResponseTable) -> Forecast:
        """The forecast one period later."""
        new = ca.repmat(self.tail, PIECES, 1)
        over, under = (ca.vertcat(item[PIECES:], new) for item in (self.over, self.under))
        return replace(self, over=over, under=under, tail=self.tail * table.fading)

    def kept(self, share: ca.SX) -> Forecast:
        """Forecast with this ``share`` (0 or 1) of the recent part; at 0 only the past part is
        left.
        """
        over, under, tail = (share * item for item in (self.over, self.under, self.tail))
        return replace(self, over=over, under=under, tail=tail)

    def mirrored(self, way: ca.SX) -> Forecast:
        """Forecast of ``way`` v, for ``way`` 1 or -1."""
        ahead = way > 0
        names = ("over", "under"), ("past_over", "past_under")
        swapped = {
            name: ca.if_else(ahead, getattr(self, name), getattr(self, other))
            for pair in names
            for name, other in (pair, pair[::-1])
        }
        return replace(self, u=way * self.u, **swapped)

    def rooms(self, most: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Distance of the bounds of v and of -v from ``most``, on each piece and after the last."""
        over, under = (ca.vertcat(item, self.tail) for item in (self.over, self.under))
        above = (most - (self.u + self.past_over)) - over
        return above, (most + (self.u - self.past_under)) - under

    def steps(self, most: ca.SX, inverse: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Largest rise and fall of a constant command that keep v and -v within ``most``.

        ``inverse``: 1/high.
        """
        above, below = self.rooms(most)
        return at_most(above * inverse), at_most(below * inverse)

    def largest(self, c: ca.SX, table: ResponseTable, inverse: Sequence[ca.SX]) -> ca.SX:
        """Largest u >= 0 with v <= c if u is kept and -v <= c if 0 follows a period later.

        ``inverse`` as `inverse_slopes` gives them.
        """
        return ca.fmax(self.u + least_of(self.stopped(c, table, inverse)), 0)

    def stopped(self, c: ca.SX, table: ResponseTable, inverse: Sequence[ca.SX]) -> ca.SX:
        """Largest change of the command that each condition on -v allows if 0 follows.

        Each condition is a line on each side of the old command, g + slope u <= c (1 + FLATTEST),
        and both lines leave the same room for the old command.
        """
        _, below = self.rooms(c * (1 + FLATTEST))
        room = below[PIECES:] - self.u * table.after
        rising, falling = inverse
        return ca.fmin(room * rising, room * falling)


def inverse_slopes(table: ResponseTable) -> list[ca.SX]:
    """Reciprocal slopes of the conditions: for a constant command, and if 0 follows a rise or a
    fall.

    Slopes are at least FLATTEST: a flat line excludes no u that the other lines admit.
    """
    low, high = table.low, table.high
    slopes = [high, table.after - low[PIECES:], table.after - high[PIECES:]]
    return [1 / ca.fmax(slope, FLATTEST) for slope in slopes]


def bounds_after(high: ca.SX) -> ca.SX:
    """Upper bounds one period before each piece from the second period on; the last for ever.

    They are at most ``high``, or exceed it by 2 FLATTEST or more.
    """
    last = [high[k] for k in range(-PIECES - 1, 0)]
    younger, own = ca.vertcat(high[: -PIECES - 1], reduce(ca.fmax, last)), high[PIECES:]
    return ca.if_else(younger > own, ca.fmax(younger, own + 2 * FLATTEST), younger)


def least_of(values: ca.SX) -> ca.SX:
    """The least element, by repeated halving, which becomes loops in C."""
    while values.numel() > 1:
        half = (values.numel() + 1) // 2
        values = ca.fmin(values[:half], values[values.numel() - half :])
    return values


def at_most(lines: ca.SX) -> ca.SX:
    """The least of all lines, but at least 0, since keeping the command is always admitted."""
    return ca.fmax(least_of(lines), 0)


@dataclass(frozen=True)
class Fading:
    """Decaying bound of the distance of v from its command, and the part due to the past.

    ``past``: the bound from commands before the last untimely sample, when the command was
    ``held``.
    """

    reach: ca.SX
    past: ca.SX
    held: ca.SX

    def aged(self, came: ca.SX, u: ca.SX, stays: ca.SX, soonest: ca.SX) -> Fading:
        """The bound at the next sample, which ``came`` on its beat (1) or was untimely (0).

        It decays by ``soonest`` in the shortest period, and otherwise by ``stays``.
        """
        reach = self.reach * ca.if_else(came, soonest, stays)
        past = ca.if_else(came, self.past * soonest, reach)
        return Fading(reach, past, ca.if_else(came, self.held, u))

    def changed(self, change: ca.SX, furthest: ca.SX) -> Fading:
        """The bound after a change of the command, which adds ``furthest`` times its size."""
        return replace(self, reach=self.reach + ca.fabs(change) * furthest)

    def bounds(self, c: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Bounds of the past part, above and below.

        While its command is kept the speed does not exceed c, except by rounding.
        """
        most = c * PAST
        return ca.fmin(most - self.held, self.past), ca.fmin(most + self.held, self.past)


def stays_of(rate: ca.SX, time: ca.SX) -> ca.SX:
    """At least exp(-rate time), with SPARE; its value at 0 for negative times and NaN."""
    x = rate * ca.if_else(time >= 0, time, 0)
    return SPARE / (1 + x + 0.5 * x * x)


def spread_of(apart: ca.SX, off: ca.SX) -> ca.SX:
    """Largest earliness and lateness (2,) of samples against this one, including itself.

    ``apart``: those of the sample before, a period and ``off`` earlier.
    """
    return ca.vertcat(ca.fmax(apart[0] + off, 0), ca.fmax(apart[1] - off, 0))
