"""The guard's formula behind late velocities and drives, in floats; integrals by quadrature."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

NODES, SHARES = np.polynomial.legendre.leggauss(20)


@dataclass(frozen=True)
class LateGuard:
    """Stated numbers of one axis; times in s, ``lo`` and ``hi`` the delay's bounds.

    The time constant of the drives is ``lag``, or varies in [fast, lag].
    """

    T: float
    u1: float
    M_min: float
    M_max: float
    net: float
    nbar: float
    f_speed: float
    brake: float
    alpha: float
    age: float = 0.0
    window: float = 0.0
    lo: float = 0.0
    hi: float = 0.0
    lag: float = 0.0
    fast: float | None = None

    @property
    def J(self):
        return self.hi - self.lo

    @property
    def L(self):
        return self.age + self.window

    @property
    def late(self):
        return self.L + self.hi + self.lag

    @cached_property
    def n(self):
        return math.ceil((self.L + self.hi) / self.T - 1e-9)

    @cached_property
    def mixed(self):
        """Time [s] in which either of two commands may act, as weighted in the mean."""
        if self.fast is not None:
            return self.late - self.window / 2
        older = math.ceil(40 * self.lag / self.T) + 1
        spent, z = self._spent(0.0, self._pieces(self.n + older), lambda which: len(which) - 1.0)
        return float(np.sum(spent[0] + self.lag * z)) + self.J

    @cached_property
    def brakes(self):
        cap = self.M_min * (self.u1 - self.f_speed) / (1 / self.alpha + self.late)
        return min(self.brake, self._of_mixed(cap) - self.net)

    @cached_property
    def largest(self):
        if not self.late:
            return math.inf
        spent = max(self.brakes + self.net, 0) / self.alpha
        most = (self.M_min * (self.u1 - self.f_speed) - spent) / self.late
        return self._of_mixed(most) - self.net

    def hi_of(self, y, sent, tail, way):
        """Largest safe force in direction ``way``; ``sent``: the latest first.

        ``tail``: push behind the lag due to commands older than the listed ones.
        """
        spent, z = self._spent(tail, self._pieces(self.n), self._most(sent, way))
        room = (
            np.minimum(
                self.M_min * (self.u1 - np.maximum(way * y + self.nbar, self.f_speed)) - spent[0],
                self.M_min * (self.u1 - self.f_speed) - spent[1],
            )
            - self.lag * z
        )
        rate, J = 1 / self.alpha, self.J
        more = lambda t: (self.lag - self._quick) * (1 - _left(t, self._quick))  # noqa: E731
        lines = [room / (rate + J), (room + more(self.T + J) * z) / (rate + J + more(self.T + J))]
        if J:
            p = self._push(way * sent[0])
            left = room - J * p - more(J) * np.maximum(p - z, 0.0)
            z = self._behind(z, p, J)(0.0)
            lines += [left / rate, (left + more(self.T) * z) / (rate + more(self.T))]
        m = np.minimum.reduce(lines)
        m = np.where(m < 0, m * self.M_max / (self.T * self.M_min * self.alpha), m)
        return np.minimum(np.maximum(m - self.net, -self.brakes), self.largest)

    def next_tail(self, tail, commands, way):
        """Tail at the next sample; ``commands``: the new one first."""
        oldest = self._pieces(self.n + 1)[: 2 if self.n else 1]
        return self._spent(tail, oldest, self._most(commands, way))[1]

    @property
    def first_tail(self):
        """Tail after commands of 0."""
        return max(self.net, 0.0)

    @property
    def tail_unit(self):
        """Number that the product stores for a tail of 1.

        Behind a constant lag, it is the remaining time integral of that tail [s].
        """
        if self.fast is not None:
            return 1.0
        return self.lag * math.exp((self.hi + self.L - self.n * self.T) / self.lag)

    def _push(self, force):
        return np.maximum(force + self.net, 0.0)

    def _most(self, sent, way):
        return lambda which: np.maximum.reduce([self._push(way * sent[j - 1]) for j in which])

    def _of_mixed(self, force):
        """Limit a force if the newest command may act while the previous command still acts."""
        if self.J == 0 and self.fast is None:
            return force
        return min(force, self.M_min * (self.u1 - 2 * self.nbar) / self.mixed)

    def _pieces(self, count):
        """Commands and ages [s] of every piece of ``count`` commands, the oldest first."""
        items = []
        for j in range(count, 0, -1):
            over = (j - 1) * self.T
            items.append(((j,), j * self.T - self.hi, over - self.lo))
            if j > 1:
                items.append(((j, j - 1), over - self.lo, over - self.hi))
        return items

    def _spent(self, z, pieces, push):
        """Momentum of a push behind the lag, for the mean and from rest, and its last value."""
        spent = [0.0, 0.0]
        for which, begin, end in pieces:
            if begin - end > 1e-12:
                at = self._behind(z, push(which), begin)
                spent = [spent[i] + self._integral(at, begin, end, i == 0) for i in (0, 1)]
                z = at(end)
        return spent, z

    @property
    def _quick(self):
        return self.lag if self.fast is None else self.fast

    def _behind(self, z, p, begin):
        """A push p behind the lag, with the value z at one age, as a function of the age."""
        falls, rises = np.maximum(z - p, 0.0), np.maximum(p - z, 0.0)
        return lambda s: (
            p + falls * _left(begin - s, self.lag) - rises * _left(begin - s, self._quick)
        )

    def _integral(self, at, begin, end, averaged):
        """Integrate ``at`` times the share of ages that count, in pieces between its corners."""
        cuts = sorted({begin, end, *(s for s in (self.age, self.L) if end < s < begin)})
        total = 0.0
        for low, high in pairwise(cuts):
            s = (low + high) / 2 + (high - low) / 2 * NODES[:, None]
            share = (s <= self.L) * 1.0
            if averaged and self.window:
                share = np.clip((self.L - s) / self.window, 0.0, 1.0)
            total = total + (high - low) / 2 * (SHARES @ (share * at(s)))
        return total


def _left(time, lag):
    """Remaining share behind a lag after a time."""
    return np.exp(-time / lag) if lag else (time == 0) * 1.0
