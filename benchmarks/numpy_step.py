"""One control step in NumPy, as one would write it for a simulation script.

Small arrays for vectors, one vectorised expression over the 64 nodes of the network, the barrier
axis by axis in its cancellation-free form.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from .setup import Setup

Array = NDArray[np.float64]


class NumpyLaws:
    """The laws MB (9) and NN (57), (58) for one Setup; vectors are ordered as in hand.h."""

    def __init__(self, setup: Setup) -> None:
        """Turn the numbers into arrays once."""
        self.setup = setup
        self.mass = np.array([setup.m, setup.inertia])
        self.top = np.array(setup.v_u1) - setup.clip
        self.rho, self.rho1 = np.array(setup.mb_rho), np.array(setup.nn_rho1)
        self.gamma, self.sigma = np.array(setup.nn_gamma), np.array(setup.nn_sigma)
        self.centres = np.array(list(product([-1.0, 1.0], repeat=6)))
        self.wheels = 0.5 * setup.r * np.array([[1.0, 1 / setup.l], [1.0, -1 / setup.l]])

    def mb_step(self, reference: Array, pose: Array, v: Array) -> Array:
        """Return the torques (2,) [N m] of the model-based law."""
        c, c_dot = self.auxiliary(reference, pose, v)
        _, va, q = self.barrier(v, c)
        friction = np.array([self.setup.mu * self.setup.m * self.setup.g, 0.0])
        friction *= np.tanh(v / self.setup.v_s)
        torque: Array = self.wheels @ (self.mass * (-self.rho * va + q * c_dot) + friction)
        return torque

    def nn_step(self, reference: Array, pose: Array, v: Array, W: Array) -> tuple[Array, Array]:
        """Return the torques (2,) [N m] of the network law and its weights (2, 64) afterwards."""
        setup = self.setup
        c, c_dot = self.auxiliary(reference, pose, v)
        w, va, q = self.barrier(v, c)
        ratio = 1.0 / np.maximum(q, 1.0 / setup.nn_ratio_cap)
        z = np.concatenate([c_dot, ratio, v])
        S = np.exp(-np.sum((z - self.centres) ** 2, axis=1) / setup.nn_eta**2)
        force = -self.rho1 * va + q * (W @ S)
        W_rate = -self.gamma[:, None] * (w[:, None] * S + self.sigma[:, None] * W)
        return self.wheels @ force, W + setup.period * W_rate

    def auxiliary(self, reference: Array, pose: Array, v: Array) -> tuple[Array, Array]:
        """Return v_c0 (7) and its exact rate, both (2,) [m/s, rad/s and per second]."""
        k1, k2, k3 = self.setup.k
        v1_d, v2_d, v1_d_dot, v2_d_dot = reference[3:]
        s, c = np.sin(pose[2]), np.cos(pose[2])
        R = np.array([[-s, c, 0.0], [-c, -s, 0.0], [0.0, 0.0, 1.0]])
        e1, e2, e3 = R @ (reference[:3] - pose)
        e1_dot = e2 * v[1] - v[0] + v1_d * np.cos(e3)
        e2_dot = -e1 * v[1] + v1_d * np.sin(e3)
        e3_dot = v2_d - v[1]
        v_c0 = np.array([v1_d * np.cos(e3) + k1 * e1, v2_d + k2 * v1_d * e2 + k3 * np.sin(e3)])
        rate1 = v1_d_dot * np.cos(e3) - v1_d * np.sin(e3) * e3_dot + k1 * e1_dot
        rate2 = v2_d_dot + k2 * (v1_d_dot * e2 + v1_d * e2_dot) + k3 * np.cos(e3) * e3_dot
        return v_c0, np.array([rate1, rate2])

    def barrier(self, v: Array, v_c0: Array) -> tuple[Array, Array, Array]:
        """Return v - v_c1, V1/A and q, each (2,)."""
        clipped = np.clip(v, -self.top, self.top)
        limits = zip(self.setup.v_u1, self.setup.v_u2, clipped, v_c0, strict=True)
        w, va, q = np.array([axis_barrier(*values) for values in limits]).T
        return w, va, q


def axis_barrier(u1: float, u2: float, v: float, c: float) -> tuple[float, float, float]:
    """Return v - v_c1, V1/A and q of one axis (10)-(20) for |v| < u1."""
    sign = -1.0 if c < 0 else 1.0
    v, c, delta = sign * v, sign * c, u1 - u2
    if c <= u2:
        w, va, q = _tracked(u1, u2, v, c)
    elif v <= u2:
        w, va, q = _behind(u1, u2, v, c)
    else:
        d = min(_gap(u1, c), delta)
        w = d - (u1 - v)
        b = max(u2 + 1 / delta - c, 0.0)
        slope = b + w * (1 + 1 / (d * (u1 - v)))
        va = (w * (0.5 * w + b) + _phi(w / d)) / slope if slope else 0.0
        q = 1 / (1 + 1 / (d * (u1 - v))) if b == 0.0 else w / slope
    return sign * w, sign * va, q


def _gap(u1: float, c: float) -> float:
    """Distance u1 - v_c1 of (18) in region 3."""
    t = c - u1
    return float(2 / (t + np.sqrt(t * t + 4)))


def _wall(u1: float, u2: float, v: float) -> tuple[float, float]:
    """Return f (15) and its slope's size."""
    if abs(v) <= u2:
        return 0.0, 0.0
    return -np.log1p(-(abs(v) - u2) / (u1 - u2)), 1 / (u1 - abs(v))


def _tracked(u1: float, u2: float, v: float, c: float) -> tuple[float, float, float]:
    """Region 1, where v_c1 = v_c0."""
    w = v - c
    if abs(v) <= u2:
        return w, 0.5 * w, 1.0
    f, slope = _wall(u1, u2, v)
    A = w + np.sign(v) * slope
    return w, (0.5 * w * w + f) / A, w / A


def _behind(u1: float, u2: float, v: float, c: float) -> tuple[float, float, float]:
    """Regions 2 and 3 with v on the near side of u2."""
    delta = u1 - u2
    f, slope = _wall(u1, u2, v)
    if c <= u2 + 1 / delta:
        n, pull = u2 - v, c - u2
        level = n * (0.5 * n + pull)
    else:
        d = _gap(u1, c)
        n, pull = (delta - d) + (u2 - v), 1 / d
        level = 0.5 * n * n + (u2 - v) / d + _phi(-(delta - d) / d)
    A = n + pull + slope
    return -n, -(level + f) / A, n / A


def _phi(y: float) -> float:
    """-ln(1 - y) - y, by its series where the difference would cancel."""
    if abs(y) < 0.05:
        return float(y * y * np.polyval(1.0 / np.arange(16, 1, -1), y))
    return float(-np.log1p(-y) - y)
