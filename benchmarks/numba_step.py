"""One control step of the network law in scalar numba, as one would write it for speed in Python.

Scalars and explicit loops, the 64 nodes as products of 12 exponentials, no fast-math.  Importing
this module needs numba; `numba_peer` does it where numba is installed.
"""

# ruff: noqa: ANN001, ANN201 - numba finds the types
from __future__ import annotations

from math import copysign, cos, exp, log1p, sin, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

from .setup import Pair, Setup

NODES = 64


class Law(NamedTuple):
    """Numbers that a step reads; names as in `Setup`."""

    v_u1: Pair
    v_u2: Pair
    clip: float
    k: tuple[float, float, float]
    rho1: Pair
    keep: Pair
    learn: Pair
    eta2: float
    ratio_cap: float
    thrust: float
    moment: float


def law_of(setup: Setup) -> Law:
    """The numbers of a Setup; keep and learn are those of an Euler step of the weights (58)."""
    gain, leak, period = np.array(setup.nn_gamma), np.array(setup.nn_sigma), setup.period
    keep, learn = (tuple(map(float, pair)) for pair in (1 - period * gain * leak, -period * gain))
    return Law(
        setup.v_u1, setup.v_u2, setup.clip, setup.k, setup.nn_rho1, keep, learn,
        setup.nn_eta**2, setup.nn_ratio_cap, 0.5 * setup.r, 0.5 * setup.r / setup.l,
    )  # fmt: skip


@njit
def nn_step(law, row, W, S):
    """Torques right and left [N m] for a row of hand.h; W (2, 64) is updated.

    S (64,) is scratch of the caller: numba's arrays live on the heap.
    """
    c1, c2, rate1, rate2 = auxiliary(law, row)
    v1, v2 = row[10], row[11]
    w1, va1, q1 = barrier(law.v_u1[0], law.v_u2[0], law.clip, v1, c1)
    w2, va2, q2 = barrier(law.v_u1[1], law.v_u2[1], law.clip, v2, c2)
    lowest = 1.0 / law.ratio_cap
    nodes((rate1, rate2, 1.0 / max(q1, lowest), 1.0 / max(q2, lowest), v1, v2), law.eta2, S)
    learned1, learned2 = recall_and_learn(law, w1, w2, W, S)
    force = law.thrust * (q1 * learned1 - law.rho1[0] * va1)
    half = law.moment * (q2 * learned2 - law.rho1[1] * va2)
    return force + half, force - half


@njit
def auxiliary(law, row):
    """v_c0 (7) and its exact rate."""
    k1, k2, k3 = law.k
    v1_d, v2_d, v1_d_dot, v2_d_dot = row[3], row[4], row[5], row[6]
    s, c = sin(row[9]), cos(row[9])
    dx, dy, e3 = row[0] - row[7], row[1] - row[8], row[2] - row[9]
    e1, e2 = c * dy - s * dx, -c * dx - s * dy
    s3, c3 = sin(e3), cos(e3)
    e1_dot = e2 * row[11] - row[10] + v1_d * c3
    e2_dot = v1_d * s3 - e1 * row[11]
    e3_dot = v2_d - row[11]
    rate1 = v1_d_dot * c3 - v1_d * s3 * e3_dot + k1 * e1_dot
    rate2 = v2_d_dot + k2 * (v1_d_dot * e2 + v1_d * e2_dot) + k3 * c3 * e3_dot
    return v1_d * c3 + k1 * e1, v2_d + k2 * v1_d * e2 + k3 * s3, rate1, rate2


@njit
def nodes(z, eta2, S):
    """S(Z) (64,): each input doubles the corners that are there, the last input first."""
    S[0], count = 1.0, 1
    for d in range(5, -1, -1):
        low, high = exp(-((z[d] + 1.0) ** 2) / eta2), exp(-((z[d] - 1.0) ** 2) / eta2)
        for j in range(count):
            S[count + j] = high * S[j]
            S[j] = low * S[j]
        count *= 2


@njit
def recall_and_learn(law, w1, w2, W, S):
    """W'S of both axes with the old weights, which then take one step of (58)."""
    sum1 = sum2 = 0.0
    step1, step2 = law.learn[0] * w1, law.learn[1] * w2
    for j in range(NODES):
        s, old1, old2 = S[j], W[0, j], W[1, j]
        sum1 += old1 * s
        sum2 += old2 * s
        W[0, j] = law.keep[0] * old1 + step1 * s
        W[1, j] = law.keep[1] * old2 + step2 * s
    return sum1, sum2


@njit
def barrier(u1, u2, clip, v, c):
    """v - v_c1, V1/A and q of one axis (10)-(20)."""
    sign = copysign(1.0, c)
    v = sign * min(max(v, clip - u1), u1 - clip)
    c = abs(c)
    if c <= u2:
        w, va, q = tracked(u1, u2, v, c)
    elif v <= u2:
        w, va, q = behind(u1, u2, v, c)
    else:
        w, va, q = beyond(u1, u2, v, c)
    return sign * w, sign * va, q


@njit
def tracked(u1, u2, v, c):
    """Region 1, where v_c1 = v_c0."""
    w = v - c
    if abs(v) <= u2:
        return w, 0.5 * w, 1.0
    f, slope = wall(u1, u2, abs(v))
    A = w + copysign(slope, v)
    return w, (0.5 * w * w + f) / A, w / A


@njit
def behind(u1, u2, v, c):
    """Regions 2 and 3 with v on the near side of u2."""
    delta = u1 - u2
    if c <= u2 + 1.0 / delta:
        n, pull = u2 - v, c - u2
        level = n * (0.5 * n + pull)
    else:
        d = gap(u1, c)
        n, pull = (delta - d) + (u2 - v), 1.0 / d
        level = 0.5 * n * n + (u2 - v) / d + phi(-(delta - d) / d)
    slope = n + pull
    if v < -u2:
        f, steep = wall(u1, u2, -v)
        level, slope = level + f, slope + steep
    return -n, -level / slope, n / slope


@njit
def beyond(u1, u2, v, c):
    """Regions 2 and 3 with v between u2 and u1."""
    delta = u1 - u2
    d = min(gap(u1, c), delta)
    w, b, steep = d - (u1 - v), max(u2 + 1.0 / delta - c, 0.0), 1.0 + 1.0 / (d * (u1 - v))
    slope = b + w * steep
    va = (w * (0.5 * w + b) + phi(w / d)) / slope if slope != 0.0 else 0.0
    return w, va, 1.0 / steep if b == 0.0 else w / slope


@njit
def gap(u1, c):
    """Distance u1 - v_c1 of (18) in region 3."""
    t = c - u1
    return 2.0 / (t + sqrt(t * t + 4.0))


@njit
def wall(u1, u2, speed):
    """f (15) and its slope's size beyond u2."""
    return -log1p(-(speed - u2) / (u1 - u2)), 1.0 / (u1 - speed)


@njit
def phi(y):
    """-ln(1 - y) - y, by its series where the difference would cancel."""
    if abs(y) >= 0.05:
        return -log1p(-y) - y
    total = 0.0
    for n in range(16, 1, -1):
        total = total * y + 1.0 / n
    return y * y * total
