"""The late guard's formula in docs/lemmas.md, in floats, for many robots."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np


@dataclass(frozen=True)
class LateGuard:
    """Stated numbers of one axis; times in s, ``lo`` and ``hi`` the delay's bounds, ``lag`` b."""

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
    def keep(self):
        return math.exp(-self.T / self.lag) if self.lag else 0.0

    @cached_property
    def mean(self):
        """Weights [s] of command j = 1, ..., n + 1: sure, and mixed with the next."""
        if not self.window:
            return [self._group(j, lambda s: self._h(s - self.age)) for j in range(1, self.n + 2)]
        g = lambda s: (self._k(s - self.age) - self._k(s - self.L)) / self.window  # noqa: E731
        return [self._group(j, g) for j in range(1, self.n + 2)]

    @cached_property
    def rest(self):
        return [self._group(j, lambda s: self._h(s - self.L)) for j in range(1, self.n + 2)]

    @cached_property
    def mixed(self):
        return sum(w for _, w in self.mean[: self.n]) + self.mean[self.n][1] / (1 - self.keep)

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

    def push(self, force):
        return np.maximum(force + self.net, 0.0)

    def hi_of(self, y, sent, tail, way):
        """Largest safe force in direction ``way``; ``sent``: the latest first."""
        p = [self.push(way * force) for force in sent[: self.n]]
        spent = []
        for weights, share in ((self.mean, self._share), (self.rest, 1.0)):
            total = share * tail
            for j in range(self.n):
                total = total + weights[j][0] * p[j]
                if j:
                    total = total + weights[j][1] * np.maximum(p[j], p[j - 1])
            spent.append(total)
        R = self._room(y, spent, way)
        m = self.alpha * R
        if self.J:
            m = np.minimum(self.alpha * (R - self.J * p[0]), R / (1 / self.alpha + self.J))
        return self._force(m)

    def next_tail(self, tail, commands, way):
        """``commands``: the new one first."""
        if not self.lag:
            return tail
        p, (sure, mixed) = [self.push(way * force) for force in commands], self.rest[self.n]
        joined = sure * p[self.n]
        if self.J:
            joined = joined + mixed * np.maximum(p[self.n], p[self.n - 1])
        return self.keep * tail + joined

    @property
    def first_tail(self):
        """After commands of 0."""
        return sum(self.rest[self.n]) / (1 - self.keep) * max(self.net, 0.0) if self.lag else 0.0

    @property
    def _mixes(self):
        """True if the newest command may act while the one before still does."""
        return self.J > 0

    def _of_mixed(self, force):
        return (
            min(force, self.M_min * (self.u1 - 2 * self.nbar) / self.mixed)
            if self._mixes
            else force
        )

    def _room(self, y, spent, way):
        """Momentum to the limit, less what is ``spent`` from the mean and from rest."""
        return np.minimum(
            self.M_min * (self.u1 - np.maximum(way * y + self.nbar, self.f_speed)) - spent[0],
            self.M_min * (self.u1 - self.f_speed) - spent[1],
        )

    def _force(self, m):
        """Force whose push is ``m``, as large as may be sent."""
        m = np.where(m < 0, m * self.M_max / (self.T * self.M_min * self.alpha), m)
        return np.minimum(np.maximum(m - self.net, -self.brakes), self.largest)

    @property
    def _share(self):
        if not (self.lag and self.window):
            return 1.0
        return self.lag / self.window * -math.expm1(-self.window / self.lag)

    def _group(self, j, g):
        begin, sure, over = (
            j * self.T - self.hi,
            (j - 1) * self.T - self.lo,
            (j - 1) * self.T - self.hi,
        )
        return g(sure) - g(begin), g(over) - g(sure)

    def _h(self, x):
        if x <= 0:
            return self.lag - x
        return self.lag * math.exp(-x / self.lag) if self.lag else 0.0

    def _k(self, x):
        if x <= 0:
            return self.lag * x - x * x / 2
        return -(self.lag**2) * math.expm1(-x / self.lag) if self.lag else 0.0
