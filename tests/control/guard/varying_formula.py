"""The guard's formula behind a lag that varies, in floats; integrals by quadrature."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tests.control.guard.late_formula import LateGuard

NODES, SHARES = np.polynomial.legendre.leggauss(20)


@dataclass(frozen=True)
class VaryingGuard(LateGuard):
    """Drives whose time constant lies in [fast, lag] and varies [s]."""

    fast: float = 0.0

    @property
    def mixed(self):
        return self.late - self.window / 2

    @property
    def _mixes(self):
        return True

    def pieces(self, count):
        """Commands and ages [s] of every piece of ``count`` commands, the oldest first."""
        items = []
        for j in range(count, 0, -1):
            over = (j - 1) * self.T
            items.append(((j,), j * self.T - self.hi, over - self.lo))
            if j > 1:
                items.append(((j, j - 1), over - self.lo, over - self.hi))
        return items

    def share(self, s, averaged):
        if not (averaged and self.window):
            return (s <= self.L) * 1.0
        return np.clip((self.L - s) / self.window, 0.0, 1.0)

    def through(self, z, p, begin, end):
        """Z at ages between, as a function of the age."""
        falls, rises = np.maximum(z - p, 0.0), np.maximum(p - z, 0.0)

        def at(s):
            quick = np.exp((s - begin) / self.fast) if self.fast else (s == begin) * 1.0
            return p + falls * np.exp((s - begin) / self.lag) - rises * quick

        return at

    def integral(self, at, begin, end, averaged):
        """Of Z with the share of ages that count, cut where that has a corner."""
        cuts = sorted({begin, end, *(s for s in (self.age, self.L) if end < s < begin)})
        total = 0.0
        for low, high in pairwise(cuts):
            for node, weight in zip(NODES, SHARES, strict=True):
                s = (low + high) / 2 + (high - low) / 2 * node
                total = total + weight * (high - low) / 2 * self.share(s, averaged) * at(s)
        return total

    def hi_of(self, y, sent, tail, way):
        spent, z = [0.0, 0.0], tail
        for which, begin, end in self.pieces(self.n):
            if begin - end < 1e-12:
                continue
            p = np.maximum.reduce([self.push(way * sent[j - 1]) for j in which])
            at = self.through(z, p, begin, end)
            spent = [spent[i] + self.integral(at, begin, end, i == 0) for i in (0, 1)]
            z = at(end)
        room = self._room(y, spent, way) - self.lag * z
        more = lambda t: (self.lag - self.fast) * (1 - self._quick(t))  # noqa: E731
        rate, J = 1 / self.alpha, self.J
        lines = [room / (rate + J), (room + more(self.T + J) * z) / (rate + J + more(self.T + J))]
        if J:
            p = self.push(way * sent[0])
            left = room - J * p - more(J) * np.maximum(p - z, 0.0)
            z = self.through(z, p, J, 0.0)(0.0)
            lines += [left / rate, (left + more(self.T) * z) / (rate + more(self.T))]
        return self._force(np.minimum.reduce(lines))

    def next_tail(self, tail, commands, way):
        z = tail
        for which, begin, end in self.pieces(self.n + 1)[: 2 if self.n else 1]:
            if begin - end > 1e-12:
                p = np.maximum.reduce([self.push(way * commands[j - 1]) for j in which])
                z = self.through(z, p, begin, end)(end)
        return z

    @property
    def first_tail(self):
        return max(self.net, 0.0)

    def _quick(self, time):
        return float(np.exp(-time / self.fast)) if self.fast else float(time == 0)
