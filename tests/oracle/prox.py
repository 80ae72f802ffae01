"""Sampled-data barrier law, from its definition."""

import math

from tests.oracle.barrier import barrier, distance
from tests.oracle.prediction import LawWithObserver
from tests.oracle.smooth import smooth_barrier


class Prox(LawWithObserver):
    """F = M1 (v+ - v)/T + F1(v+) + f, v+ the implicit step of V1's gradient flow."""

    def __init__(self, gains, scenario):
        super().__init__(gains, scenario)
        self.smooth, self.level = gains["barrier"] == "smooth", gains["transport"] == "level"

    def act(self, sight):
        """Generalised force (thrust [N], moment [N m]); first updates the observer."""
        (force, moment), sight = self.look(sight)
        ends = [self._end(i, sight) for i in (0, 1)]
        drag = self.observer.friction(ends[0])
        return (
            self.bot.m * (ends[0] - sight.v[0]) / self.T + drag + force,
            self.bot.I * (ends[1] - sight.v[1]) / self.T + moment,
        )

    def _end(self, i, sight):
        """v+ of axis ``i``."""
        c, c_next = sight.v_c0[i], sight.v_c0[i] + self.T * sight.v_c0_dot[i]
        followed = c + self.T * sight.v_c0_dot_reference[i]
        start = self._carried(i, sight.v[i], c, c_next if self.level else followed)
        half = self.gains["rho"][i] * self.T / 2.0
        keep, rest = math.exp(-half), -math.expm1(-half)
        return self._near(i, keep * start + rest * c_next, rest)

    def _carried(self, i, v, c, target):
        """v transported from c to ``target`` so that V1 does not rise."""
        if target == c:
            return v
        x, x_next, u1 = self._near(i, c, 1.0), self._near(i, target, 1.0), self.limits.v_u1[i]
        w = v - x
        nearer = (x_next - x) * (1.0 if w > 0.0 else -1.0)
        if abs(v) >= u1:
            share = 0.0 if nearer > 0.0 else 1.0
        elif abs(x_next + w) >= u1:
            share = 0.0
        else:
            share = self._share(w, self._V1(i, v, c), self._V1(i, x_next + w, target) - w * w / 2.0)
        if nearer > 0.0 and abs(w) - nearer >= share * abs(w):
            return v
        return x_next + share * w

    @staticmethod
    def _share(w, level, excess):
        """The largest s up to 1 with s^2 w^2/2 + s excess <= level."""
        divisor = excess + math.sqrt(max(excess * excess + 2.0 * w * w * level, 0.0))
        return min(1.0, 2.0 * level / divisor) if divisor > 0.0 else 1.0

    def _V1(self, i, v, c):
        form = smooth_barrier if self.smooth else barrier
        return form(v, c, self.limits.v_u1[i], self.limits.v_u2[i]).V1

    def _near(self, i, c, k):
        return nearest(c, k, self.limits.v_u1[i], self.limits.v_u2[i], self.smooth)


def nearest(c, k, u1, u2, smooth=False):
    """The x that minimises (x - c)^2/2 + k f(x), |x| < u1 [m/s or rad/s]."""
    return math.copysign(_right(abs(c), k, u1, u2, smooth), c)


def _right(c, k, u1, u2, smooth):
    if c <= u2:
        return c
    delta = u1 - u2
    if smooth:
        d = distance(c - u1 + k / delta, k)
        return u2 + (c - u2) / (1.0 + k / (d * delta))
    if c <= u2 + k / delta:
        return u2
    return u1 - distance(c - u1, k)
