"""Forecast of a linear loop from the commands that it was sent, piece by piece of time.

Bounds of v - u and of -v + u, if the command u stays, and the largest commands that keep v and -v
within a limit: if held from now on, and if 0 follows.  `band` has the sum that they bound.
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
"""Share of c that is counted on at most of what was sent before an untimely sample: it is above
what is allowed by more than roundings add to that, so that nothing adds up from one such sample to
the next."""
SPARE = 1 + 2.0**-40
"""Factor of what is kept of the past, so that no rounding makes it too little."""


@dataclass(frozen=True)
class ResponseTable:
    """Bounds of a step response on each piece, and how it fades behind them.

    ``above`` bounds it less 1 on each piece, ``below`` the negative of that, and ``left`` both
    behind them, where that fades by ``fading`` a period.  ``after`` bounds, from the second period
    on, the response to a step a period later.
    """

    above: ca.SX
    below: ca.SX
    after: ca.SX
    left: ca.SX
    fading: ca.SX

    @property
    def low(self) -> ca.SX:
        """Lower bounds on each piece, the last one for ever."""
        return 1 - ca.vertcat(self.below, self.left)

    @property
    def high(self) -> ca.SX:
        """Upper bounds on each piece, the last one for ever."""
        return 1 + ca.vertcat(self.above, self.left)


@dataclass(frozen=True)
class Forecast:
    """Bounds of v - u and of -v + u on each piece, if the command stays u; the tail's; u itself.

    They are ``over`` and ``under``, of what was sent since the last untimely sample, and
    ``past_over`` and ``past_under``, of what was sent before.
    """

    over: ca.SX
    under: ca.SX
    tail: ca.SX
    u: ca.SX
    past_over: ca.SX
    past_under: ca.SX

    def changed(self, to: ca.SX, table: ResponseTable) -> Forecast:
        """The same with another command from now on."""
        up, down = ca.fmax(to - self.u, 0), ca.fmax(self.u - to, 0)
        return replace(
            self,
            over=self.over + up * table.above + down * table.below,
            under=self.under + up * table.below + down * table.above,
            tail=self.tail + (up + down) * table.left,
            u=to,
        )

    def later(self, table: ResponseTable) -> Forecast:
        """The same as seen a period later."""
        new = ca.repmat(self.tail, PIECES, 1)
        over, under = (ca.vertcat(item[PIECES:], new) for item in (self.over, self.under))
        return replace(self, over=over, under=under, tail=self.tail * table.fading)

    def kept(self, share: ca.SX) -> Forecast:
        """The same where ``share`` is 1; where it is 0, all is past."""
        over, under, tail = (share * item for item in (self.over, self.under, self.tail))
        return replace(self, over=over, under=under, tail=tail)

    def mirrored(self, way: ca.SX) -> Forecast:
        """The forecast of way v, way being 1 or -1."""
        ahead = way > 0
        names = ("over", "under"), ("past_over", "past_under")
        swapped = {
            name: ca.if_else(ahead, getattr(self, name), getattr(self, other))
            for pair in names
            for name, other in (pair, pair[::-1])
        }
        return replace(self, u=way * self.u, **swapped)

    def rooms(self, most: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Room left below ``most`` on each piece and beyond them, above and below."""
        over, under = (ca.vertcat(item, self.tail) for item in (self.over, self.under))
        above = (most - (self.u + self.past_over)) - over
        return above, (most + (self.u - self.past_under)) - under

    def steps(self, most: ca.SX, inverse: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Largest rise and fall of the command, held from now on, that keep v and -v within most.

        ``inverse``: 1/high.
        """
        above, below = self.rooms(most)
        return at_most(above * inverse), at_most(below * inverse)

    def largest(self, c: ca.SX, table: ResponseTable, inverse: Sequence[ca.SX]) -> ca.SX:
        """Largest u >= 0 behind which -v <= c if 0 follows a period later; v <= c if it was held.

        ``inverse`` as `inverse_slopes` gives them.
        """
        return ca.fmax(self.u + least_of(self.stopped(c, table, inverse)), 0)

    def stopped(self, c: ca.SX, table: ResponseTable, inverse: Sequence[ca.SX]) -> ca.SX:
        """Largest change of the command that each condition on -v allows, where 0 follows.

        Each is a line on each side of the old command, g + slope u <= c (1 + FLATTEST), and both
        leave the same room for the old command itself.
        """
        _, below = self.rooms(c * (1 + FLATTEST))
        room = below[PIECES:] - self.u * table.after
        rising, falling = inverse
        return ca.fmin(room * rising, room * falling)


def inverse_slopes(table: ResponseTable) -> list[ca.SX]:
    """1 over the slopes of all conditions: for a command held; where 0 follows a rise, and a fall.

    Slopes are at least FLATTEST: a line that is flat leaves every u that the others do.
    """
    low, high = table.low, table.high
    slopes = [high, table.after - low[PIECES:], table.after - high[PIECES:]]
    return [1 / ca.fmax(slope, FLATTEST) for slope in slopes]


def bounds_after(high: ca.SX) -> ca.SX:
    """Upper bounds a period before each piece from the second period on; the last for ever.

    They are no higher than ``high``, or higher by 2 FLATTEST or more.
    """
    last = [high[k] for k in range(-PIECES - 1, 0)]
    younger, own = ca.vertcat(high[: -PIECES - 1], reduce(ca.fmax, last)), high[PIECES:]
    return ca.if_else(younger > own, ca.fmax(younger, own + 2 * FLATTEST), younger)


def least_of(values: ca.SX) -> ca.SX:
    """The least element, by halves, which are loops in C."""
    while values.numel() > 1:
        half = (values.numel() + 1) // 2
        values = ca.fmin(values[:half], values[values.numel() - half :])
    return values


def at_most(lines: ca.SX) -> ca.SX:
    """The least of all lines, and at least 0: holding on is always admitted."""
    return ca.fmax(least_of(lines), 0)


@dataclass(frozen=True)
class Fading:
    """Largest distance of v from its command at the sample, which fades; its part from the past.

    ``past``: the same of what was sent before the last untimely sample, at which the command was
    ``held``.
    """

    reach: ca.SX
    past: ca.SX
    held: ca.SX

    def aged(self, came: ca.SX, u: ca.SX, stays: ca.SX, soonest: ca.SX) -> Fading:
        """The same at the next sample, a period later if it ``came`` on its beat, else untimely.

        Of it ``soonest`` stays in the shortest period, and else ``stays``.
        """
        reach = self.reach * ca.if_else(came, soonest, stays)
        past = ca.if_else(came, self.past * soonest, reach)
        return Fading(reach, past, ca.if_else(came, self.held, u))

    def changed(self, change: ca.SX, furthest: ca.SX) -> Fading:
        """The same behind a change of the command, of which ``furthest`` times its size is left."""
        return replace(self, reach=self.reach + ca.fabs(change) * furthest)

    def bounds(self, c: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Bounds of what is past, above and below.

        While its command is held nothing exceeds c but for roundings.
        """
        most = c * PAST
        return ca.fmin(most - self.held, self.past), ca.fmin(most + self.held, self.past)


def stays_of(rate: ca.SX, time: ca.SX) -> ca.SX:
    """At least exp(-rate time), with SPARE; that of 0 for a time that is negative or no number."""
    x = rate * ca.if_else(time >= 0, time, 0)
    return SPARE / (1 + x + 0.5 * x * x)


def spread_of(apart: ca.SX, off: ca.SX) -> ca.SX:
    """Largest earliness and lateness of samples against the one at hand, itself among them (2,).

    ``apart``: the same of the sample before it, since which a period and ``off`` have passed.
    """
    return ca.vertcat(ca.fmax(apart[0] + off, 0), ca.fmax(apart[1] - off, 0))
