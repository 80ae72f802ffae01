"""Entries of prox, and the corridor's assumptions on laws and guard, sampled as worded."""

import casadi as ca
import numpy as np

from tests.proofs.worded import (
    about,
    around,
    calculated,
    left,
    positive,
    same,
    several,
    share,
    signed,
)
from wmr_ctrl.control.barrier.proximal import resolvent, root
from wmr_ctrl.control.barrier.stable import smooth_barrier, stable_barrier
from wmr_ctrl.control.guard.delay import in_flight
from wmr_ctrl.control.guard.guard import MAPS, Bounds, clipped
from wmr_ctrl.control.laws.prox import prox_step
from wmr_ctrl.control.laws.velocity_loop import cut
from wmr_ctrl.world.pose_sensor import reckoned

BOTH = ((False, ""), (True, "-smooth"))


def _slope(x, u1, u2, smooth):
    """Least and largest slope of the barrier at x."""
    size = np.abs(x)
    steep = 1 / np.maximum(u1 - size, 1e-300) - (1 / (u1 - u2) if smooth else 0)
    jump = 0 * u1 if smooth else 1 / (u1 - u2)
    most = np.where(size > u2, steep, np.where(size < u2, 0, jump))
    least = np.where(size > u2, steep, 0)
    return np.where(x >= 0, least, -most), np.where(x >= 0, most, -least)


@about(*(f"prox.{name}" for name in (
    "optimal", "monotone", "short", "inside", "contracts", "linear", "margin")),
    "prox.root", "corridor.prox")  # fmt: skip
def proximal(rng):
    u1, k, E = positive(rng), positive(rng), np.clip(share(rng), 1e-4, 1 - 1e-4)
    u2 = u1 * np.clip(share(rng), 0.02, 0.98)
    c, after, along = (around(rng, 2 * u1) for _ in range(3))
    v = u1 * signed(rng)
    found = {}
    for smooth, key in BOTH:

        def step(v, c, m, t, E, u1, u2,
                 k, smooth = smooth):  # fmt: skip
            maps = [resolvent(x, y, u1, u2, smooth) for x, y in ((c, k), (c, 1), (t, 1), (m, 1))]
            return [*maps, prox_step(v, (c, m, t), (E, 1 - E), (u1, u2), smooth)]

        x, start, target, _, end = calculated(step, v, c, along, after, E, u1, u2, k)
        low, high = _slope(x, u1, u2, smooth)
        miss = (c - x) / k
        gap = 1e-9 * (1 + np.abs(c)) * (1 + 1 / (u1 - np.abs(x))) * (1 + 1 / (u1 - u2))
        inside = np.abs(x) < u1
        size = 1 + np.abs(miss) + np.abs(high)
        at = np.minimum(miss - low + gap, high - miss + gap) / size
        near_edge = np.abs(np.abs(x) - u2) < 1e-9 * u1
        kink = np.where(near_edge, 0, np.minimum(at, 0))
        found[f"optimal{key}"] = np.where(inside, kink, -1)
        found[f"inside{key}"] = u1 - np.abs(end)
        way = np.abs(after - along)
        w, w_next = np.abs(v - start), np.abs(end - target)
        found[f"contracts{key}"] = left(E * (w + way), w_next, u1, after, along, c)
        rises = [_slope(y, u1, u2, smooth) for y in (x, end)]
        later = np.where(x > end, rises[0][0] - rises[1][1], rises[1][0] - rises[0][1])
        convex = np.minimum(later, 0) / (1 + np.abs(rises[0][1]))
        found[f"monotone{key}"] = np.where(np.abs(x - end) > 1e-9 * u1, convex, 0)
        bent = 1 / (u1 - u2) if smooth else 0
        most = np.maximum(np.abs(c), u1)
        m = (u1 - u2) * share(rng)
        met = (m > 0) & (m * (m + most - u1 + k * bent) <= k)
        found[f"short{key}"] = np.where(met, left(u1 - m, np.abs(x), u1), 0)
        plain = E * (v + along - c) + (1 - E) * after
        moved = np.maximum(np.maximum(np.abs(v), np.abs(v + along - c)), np.abs(plain))
        found[f"linear{key}"] = np.where((moved <= u2) & (np.abs(c) <= u2) & (np.abs(along) <= u2),
                                         same(end, plain, u1), 0)  # fmt: skip
        most = np.maximum(np.abs(after), u1)
        met = (m > 0) & (m * (m + (1 - E) * (most - u1 + bent)) <= 1 - E)
        found[f"margin{key}"] = np.where(met, left(u1 - m, np.abs(end), u1), 0)
    t = around(rng, 3.0)
    (d,) = calculated(lambda t, k: [root(t, k)], t, k)
    found["root"] = np.where(d > 0, same(d * (d + t), k, t * d), -1)
    return found


@about(
    "prox.jury", "prox.light-model", "prox.wrong-mass", "prox.not-expansive"
)  # fmt: skip
def wrong_mass(rng):
    mu, a, L = 4 / 3 * np.maximum(share(rng), 1e-3), np.clip(share(rng), 1e-3, 1 - 1e-3), share(rng)
    L = np.clip(L, 1e-3, 1 - 1e-3)
    trace = 2 - mu * a - L * mu
    det = (1 - mu * a) * (1 - L * mu) + mu * L * a * (1 - mu)
    found = {
        "plus": same(1 + trace + det, 4 - mu * (2 * (a + L) - a * L), 4.0),
        "minus": same(1 - trace + det, mu * a * L, 4.0),
        "stable": np.minimum.reduce([1 + trace + det, 1 - trace + det, 1 - det]) + 1e-12,
    }
    for key, L0, least, p, s, g in (
        ("", 0.3, 0.25, 1 / 6, 53 / 5, 0.93),
        ("gentle", 0.07, 0.1, 0.2, 60, 0.993),
    ):
        w, q = around(rng, 1.0), around(rng, 0.3)
        mu = 5 / 8 + share(rng) * (5 / 3 - 5 / 8)
        a = least + share(rng) * (1 - least)
        next_w, next_q = (1 - mu * a) * w + mu * q, (1 - L0 * mu) * q - L0 * a * (1 - mu) * w
        size, after = (x * x + 2 * p * x * y + s * y * y for x, y in ((w, q), (next_w, next_q)))
        found[f"falls {key}"] = left(g * g * size, after)
        found[f"at least {key}"] = left(size, (w * w + q * q) / 2)
    x1, x2, slope = around(rng, 1.0), around(rng, 1.0), positive(rng)
    apart = (x1 - x2) * (1 + positive(rng) * slope)
    return found | {"near": left(np.abs(apart), np.abs(x1 - x2))}


@about(
    "corridor.mb", "corridor.kanayama", "corridor.wheels", "corridor.product",
    "corridor.reckoning", "corridor.guard", "corridor.guard-sums"
)  # fmt: skip
def off_limits(rng):
    u1 = positive(rng)
    u2 = u1 * np.clip(share(rng), 0.02, 0.98)
    v, c = (u2 * signed(rng) for _ in range(2))
    found = {}
    for name, form in (("mb", stable_barrier), ("smooth", smooth_barrier)):
        half, q = calculated(
            lambda c, v, a, b, form=form: [(x := form(c, v, a, b)).V1_over_A, x.q], c, v, u1, u2
        )
        found[name] = np.minimum(same(half, (v - c) / 2, u1), same(q, 1 + 0 * q))
    left_as_is = calculated(
        lambda a, b, *most: ca.vertsplit(cut(ca.vertcat(a, b), ca.vertcat(*most))), v, c, u2, u2
    )
    found["kanayama"] = np.minimum(same(left_as_is[0], v), same(left_as_is[1], c))
    r, l, tau = several(rng, 3)
    right, other = (tau * signed(rng) for _ in range(2))
    force, moment = (right + other) / r, l * (right - other) / r
    for key in ("linear-first", "rotation-first"):
        mapped = calculated(
            lambda F, N, l, phi, key=key: ca.vertsplit(
                MAPS[key](ca.vertcat(F, N), phi, l, ca.SX.zeros(2))), force, moment, l, 2 * tau / r,
        )  # fmt: skip
        found[key] = np.minimum(
            same(mapped[0], force, tau / r), same(mapped[1], moment, l * tau / r)
        )
    a, b, ratio = around(rng, 1.0), around(rng, 1.0), positive(rng)
    P, Q = np.abs(a + ratio * b), np.abs(a - ratio * b)
    found["product"] = left(np.maximum(P * P, Q * Q), 4 * ratio * np.abs(a * b))
    x, y, theta, dx, dy, beta, speed, omega, T = (around(rng, 1.0) for _ in range(9))
    poses = calculated(
        lambda x, y, t, dx, dy, b, v, w, T: [
            *ca.vertsplit(reckoned(ca.vertcat(x + dx, y + dy, t + b), ca.vertcat(v, w), T)
                          - reckoned(ca.vertcat(x, y, t), ca.vertcat(v, w), T)),
        ], x, y, theta, dx, dy, beta, speed, omega, T,
    )  # fmt: skip
    ahead = theta + T * omega
    apart = [dx - T * speed * (np.sin(ahead + beta) - np.sin(ahead)),
             dy + T * speed * (np.cos(ahead + beta) - np.cos(ahead)), beta]  # fmt: skip
    rows = [same(p, q, T * speed, x, y, theta, ahead) for p, q in zip(poses, apart, strict=True)]
    found["reckoning"] = np.minimum.reduce(rows)
    return found | _unguarded(rng)


def _unguarded(rng):
    M, alpha, T, u1, heavy = several(rng, 5)
    nbar, f_speed = u1 * share(rng) / 2, u1 * share(rng)
    S = M * alpha
    net = S * np.minimum(u1 - nbar, u1 - f_speed) * share(rng)
    f_min = positive(rng) * share(rng)
    near, far = S * (u1 - nbar) - net, S * (u1 - f_speed) - net
    pushed = near * signed(rng)
    force = np.clip(near * signed(rng) - pushed, -far, far)
    force = np.clip(force, -near - pushed, near - pushed)
    numbers = (
        u1,
        T,
        M,
        heavy,
        net + f_min,
        nbar,
        alpha,
        S * positive(rng) * share(rng),
        f_min,
        f_speed,
    )

    def held(*x):
        return [clipped(wish, x[-1], Bounds(*x[:10])) for wish in (x[-2], ca.SX(0))]

    given, safe = calculated(held, *numbers, force, pushed / S)
    size = S * u1
    N = net * (1 + share(rng))
    one, two = (N * signed(rng) for _ in range(2))
    times = share(rng), share(rng)

    def sums(*x):
        first, second = (ca.vertcat(item, 0) for item in x[10:12])
        known = in_flight([(first, x[12]), (ca.horzcat(second, first), x[13])], 0, Bounds(*x[:10]))
        return [known.ahead, known.back]

    counts = calculated(sums, *numbers, one, two, *times)
    found = {"guard": np.minimum(same(given, force, size), same(safe, 0 * safe, size))}
    for way, count in zip((1, -1), counts, strict=True):
        worst = np.maximum(way * one, way * two)
        most = T / M * (times[0] * (way * one + N) + times[1] * (worst + N))
        found[f"sums {way}"] = left(most, count, T / M * N)
    return found
