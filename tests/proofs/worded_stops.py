"""Entries of changing limits and of stops before obstacles, sampled as worded."""

import casadi as ca
import numpy as np

from tests.proofs.worded import about, around, between, left, positive, several, share
from wmr_ctrl.control.filter import ways
from wmr_ctrl.control.filter.governor import FirstOrder


def columns(*numbers):
    """Numbers of all samples for a function of the product."""
    return map(ca.DM, numbers)


def rows(found):
    """Return a result of the product for each sample."""
    return np.array(found).ravel()


def some(rng):
    """Numbers from 0 on."""
    return positive(rng) * share(rng)


@about("filter.limits.enters", "filter.limits.inside", "filter.limits.no-larger")
def lowered(rng):
    V, low = several(rng, 2)
    high, dbar = low * (1 + share(rng)), V * share(rng)
    v_bar = V + around(rng, V)
    e1, e2 = np.sort([np.clip(share(rng), 1e-4, 1 - 1e-4) for _ in range(2)], axis=0)
    fast, slow = e1 / (1 - e1), e2 / (1 - e2)
    b = FirstOrder(*columns(V, dbar, 0, low, high, fast))
    hi = rows(ways.told_command(*columns(V, v_bar), b, ca.DM(slow)))
    u = np.minimum(around(rng, 2 * V / low), hi)
    mean = np.maximum(high * u, low * u) + dbar - some(rng)
    E, v = between(rng, e1, e2), v_bar - some(rng)
    end, size = E * v + (1 - E) * mean, slow * (V + np.abs(v_bar))
    stopped = np.maximum(V, dbar + E * (v_bar - dbar))
    enters = np.minimum(left(stopped, end, size), left(v_bar, end, size))
    slowest = e2 * v_bar + (1 - e2) * (high * hi + 1e-6 * size + dbar)
    larger = left(slowest, np.maximum(V, dbar + e2 * (v_bar - dbar)), size)
    return {
        "enters": np.where(v_bar > V, enters, 0),
        "inside": np.where(v_bar <= V, np.minimum(left(V, end, size), hi), 0),
        "no larger": np.where((v_bar >= V) & (dbar < V), larger, 0),
    }


class Drawn:
    """A stop with a ``rest``, or by the loop alone, and its numbers of all samples."""

    def __init__(self, rng, rests):
        self.tau = np.sort(several(rng, 2), axis=0)
        self.acts, rest = several(rng, 2)
        self.last, d = some(rng), some(rng) if rests else 0 * rest
        self.d, self.B = d, rest if rests else 0
        self.quick, self.A_B = [t * -np.expm1(-rest / t) if rests else t for t in self.tau]
        self.a_B = between(rng, self.quick, np.maximum(rest, self.quick))
        B = ca.DM(rest) if rests else None
        acts, last = columns(self.acts, self.last)
        self.stop = ways.Stop(tuple(columns(*self.tau)), ca.DM(d), B, acts, last, ca.DM(0))

    def needed(self, m, w, way):
        """Distance for the end of tau that needs more."""
        D, needs = self.acts + self.last, []
        for tau in self.tau:
            A = tau * -np.expm1(-D / tau)
            end = w + (m - w) * A / tau
            needs.append(way + m * D + (w - m) * A + self.A_B * (end - self.d) + self.d * self.B)
        return np.maximum(*needs)


@about("filter.free.plan", "filter.free.necessary")
def planned(rng):
    found = {}
    for rests in (True, False):
        s = Drawn(rng, rests)
        w, way, free = s.d + some(rng), *several(rng, 2)
        m = rows(s.stop.steady(ca.DM(free), [ways.Reached(*columns(0, way, w))]))
        size = (np.abs(m) + w) * (s.acts + s.last + s.A_B) + free + way + s.d * s.B
        less, more = m - some(rng), np.maximum(m + 1e-5 * size / s.acts, s.d)
        found[f"plan {rests}"] = left(free, s.needed(less, w, way), size, less * size)
        found[f"necessary {rests}"] = left(s.needed(more, w, way), free, size)
    return found


@about("filter.free.retreat", "filter.leave.roll", "filter.leave.hold")
def left_behind(rng):
    found = {}
    for rests in (True, False):
        s = Drawn(rng, rests)
        w, target, x_1 = -some(rng), -some(rng), some(rng)
        v_3 = np.maximum(w, target) - some(rng)
        free, roll = rows(s.stop.retreat(*columns(x_1, w, target))), rows(s.stop.roll)
        x_3 = s.d * s.B + (v_3 - s.d) * s.a_B
        size = (s.d + np.abs(v_3)) * (s.B + s.a_B)
        found[f"retreat {rests}"] = left(free, x_1 + np.maximum(x_3, 0), size)
        found[f"roll {rests}"] = left(roll, x_3, size)
        pull, q = positive(rng), share(rng)
        hold = rows(s.stop.hold(ca.DM(pull)))
        x_2 = -pull * (hold + share(rng) - s.tau[1] * q * share(rng))
        x_3 = s.d * s.B + (-pull * q - s.d) * s.a_B
        found[f"hold {rests}"] = left(-x_2, x_3, size, pull * (hold + s.tau[1] + s.a_B))
    return found
