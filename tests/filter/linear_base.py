"""A base with a linear speed loop, driven by the commands that are worst for it.

It shares no code with the filter: the plant is integrated exactly by matrix exponentials, and its
commands switch where its own impulse response changes sign, seen backwards from the end.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

SINGLE = np.ones((1, 1))
"""Speeds of robots of which one axis counts."""


@dataclass(frozen=True)
class LinearBase:
    """x' = A x + b u + e d, v = x[0]."""

    A: np.ndarray
    b: np.ndarray
    e: np.ndarray

    def impulse(self, column: np.ndarray, times: np.ndarray) -> np.ndarray:
        """Impulse response of v at evenly spaced times from 0."""
        step, x, found = expm(self.A * (times[1] - times[0])), column, []
        for _ in times:
            found.append(x[0])
            x = step @ x
        return np.array(found)

    def fastest(
        self, send: Callable[[float], float], d: float, T: float, samples: int, parts: int = 8
    ) -> float:
        """Largest |v| under commands that ``send`` lets through, and pushes of at most d."""
        times = np.arange(samples * parts) * (T / parts)
        ahead = np.sign(self.impulse(self.b, times[::parts] + 0.5 * T / parts))[::-1]
        pushed = np.sign(self.impulse(self.e, times + 0.5 * T / parts))[::-1]
        step = held(self.A, np.c_[self.b, self.e], T / parts)
        x, worst = np.zeros(len(self.b)), 0.0
        for k in range(samples):
            u = send(10.0 * ahead[k])
            for part in range(parts):
                given = np.array([u, d * pushed[k * parts + part]])
                x = step[0] @ x + step[1] @ given
                worst = max(worst, abs(x[0]))
        return worst


def driven(
    bases: tuple[np.ndarray, np.ndarray, np.ndarray],
    send: Callable[[np.ndarray], np.ndarray],
    asked: np.ndarray,
    pushes: np.ndarray,
    T: float,
    force: float = np.inf,
    times: np.ndarray | None = None,
    *,
    telling: bool = True,
    speeds: np.ndarray = SINGLE,
) -> np.ndarray:
    """Largest |v| of many bases (A, b, e stacked) for what each asks for, sample by sample.

    ``asked`` (bases, axes, samples), ``pushes`` (bases, samples, parts of a period); ``send`` as
    the adversary's Sender.  With a ``force`` the largest share of it that a PI loop asks for
    counts, too, if that is larger.  ``times`` (bases, samples): from each sample to the next, of
    few sizes; by default a period T.  The filter is told them, unless not ``telling``.

    ``speeds`` (speeds, axes): of a robot each follows its parts of the command as a base of its
    own.  Then bases are those of the first speed, of the second ...; ``times`` are of robots.
    """
    A, b, e = bases
    count, samples, parts = pushes.shape
    robots, axes, _ = asked.shape
    given = np.zeros((count, 4, 4))
    given[:, :2, :2], given[:, :2, 2], given[:, :2, 3] = A, b, e
    sizes, which = np.unique(np.full((1, 1), T) if times is None else times, return_inverse=True)
    every = np.stack([expm(given * (size / parts))[:, :2] for size in sizes])
    which = np.broadcast_to(which.reshape(-1, 1 if times is None else samples), (robots, samples))
    which = np.tile(which, (len(speeds), 1))
    x, worst, u = np.zeros((count, 4)), np.zeros(count), np.zeros((3, robots))
    for k in range(samples):
        u[:axes], both = asked[:, :, k].T, every[which[:, k], np.arange(count)]
        if times is not None and telling and k:
            u[2] = np.where(times[:, k - 1] > 0, times[:, k - 1], -1.0)
        x[:, 2] = (speeds @ send(u)[:axes]).ravel()
        for part in range(parts):
            x[:, 3] = pushes[:, k, part]
            if np.isfinite(force):  # F = kp (u - v) + f jumps with the command
                F = b[:, 0] / e[:, 0] * (x[:, 2] - x[:, 0]) + x[:, 1]
                worst = np.maximum(worst, np.abs(F) / force)
            x[:, :2] = np.einsum("nij,nj->ni", both, x)
            worst = np.maximum(worst, np.abs(x[:, 0]))
    return worst


def impulses(A: np.ndarray, column: np.ndarray, step: float, count: int) -> np.ndarray:
    """Impulse responses (bases, count) of v of many bases, at the middles of steps."""
    x = np.einsum("nij,nj->ni", expm(A * (step / 2)), column)
    ahead, found = expm(A * step), []
    for _ in range(count):
        found.append(x[:, 0])
        x = np.einsum("nij,nj->ni", ahead, x)
    return np.array(found).T


def held(A: np.ndarray, B: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
    """State and input matrices over a period of held input."""
    n, m = B.shape
    both = expm(np.block([[A, B], [np.zeros((m, n + m))]]) * h)
    return both[:n, :n], both[:n, n:]


def pi_base(M: float, kp: float, ki: float, c: float) -> LinearBase:
    """M v' = kp (u - v) + f - c v + d, f' = ki (u - v)."""
    A = np.array([[-(kp + c) / M, 1 / M], [-ki, 0.0]])
    return LinearBase(A, np.array([kp / M, ki]), np.array([1 / M, 0.0]))


def second_order_base(w0: float, z: float, K: float) -> LinearBase:
    """v'' + 2 z w0 v' + w0^2 v = w0^2 (K u + d)."""
    A = np.array([[0.0, 1.0], [-(w0**2), -2 * z * w0]])
    return LinearBase(A, np.array([0.0, K * w0**2]), np.array([0.0, w0**2]))
