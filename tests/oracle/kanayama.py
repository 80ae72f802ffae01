"""Kanayama's kinematic law above a velocity loop with observer, from their definitions."""

import math

from tests.oracle.prediction import LawWithObserver


class Kanayama(LawWithObserver):
    """F = M1 a + F1(v + T a) + f, a = v_d' + (1 - exp(-rate T))/T (command - v)."""

    def __init__(self, gains, scenario):
        super().__init__(gains, scenario)
        self.tops = tuple(gains["share"] * u1 for u1 in scenario.limits.v_u1)
        self.command = None

    def act(self, sight):
        """Generalised force (thrust [N], moment [N m]); first updates observer and command."""
        (force, moment), sight = self.look(sight)
        wanted, last = self._wanted(sight), self.command or sight.v
        self.command = (self._follow(0, wanted[0], last[0]), self._follow(1, wanted[1], last[1]))
        a1, a2 = (self._acceleration(i, sight) for i in (0, 1))
        drag = self.observer.friction(sight.v[0] + self.T * a1)
        return self.bot.m * a1 + drag + force, self.bot.I * a2 + moment

    def _wanted(self, sight):
        (e1, e2, e3), target, (kx, ky, kt) = sight.e, sight.target, self.gains["k"]
        return (
            target.v1 * math.cos(e3) + kx * e1,
            target.v2 + target.v1 * (ky * e2 + kt * math.sin(e3)),
        )

    def _follow(self, i, wanted, last):
        """Command of one axis, moved towards the wanted velocity within both limits."""
        inside = min(max(wanted, -self.tops[i]), self.tops[i])
        most = self.gains["a_max"][i] * self.T
        return last + min(max(inside - last, -most), most)

    def _acceleration(self, i, sight):
        pull = -math.expm1(-self.gains["rate"][i] * self.T) / self.T
        ahead = (sight.target.v1_dot, sight.target.v2_dot)[i]
        return float(ahead + pull * (self.command[i] - sight.v[i]))


class Pursuit(Kanayama):
    """Arc to a point ahead of the reference, followed by the same velocity loop."""

    def _wanted(self, sight):
        ahead, left, way = self._point(sight)
        (e1, _, _), own = sight.e, self.gains
        kappa = 2 * left / max(ahead**2 + left**2, way * way / 4)
        pace = max(sight.target.v1 + own["k"] * e1, 0.0)
        v = min(pace, max(pace / max(abs(kappa) * own["radius"], 1.0), own["slowest"]))
        if ahead < math.cos(own["turn_from"]) * math.hypot(ahead, left):
            return 0.0, math.copysign(min(own["turn"], self.tops[1]), left)
        share = max(1.0, v / self.tops[0], abs(kappa * v) / self.tops[1])
        return v / share, kappa * v / share

    def _point(self, sight):
        """Position ahead and left of the robot [m], and the distance along the arc [m]."""
        (e1, e2, e3), target, (nearest, farthest) = sight.e, sight.target, self.gains["distance"]
        way = min(max(self.gains["lookahead"] * target.v1, nearest), farthest)
        bent = way * target.v2 * target.v1 / max(target.v1**2, 1e-12)
        half = min(max(bent, -1.5), 1.5) / 2
        chord = way * (math.sin(half) / half if half else 1.0)
        return e1 + chord * math.cos(e3 + half), e2 + chord * math.sin(e3 + half), way
