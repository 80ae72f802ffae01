"""A base with a linear speed loop, driven by the commands that are worst for it.

It shares no code with the filter: the plant is integrated exactly by matrix exponentials, and its
commands switch where its own impulse response changes sign, seen backwards from the end.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import expm

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class LinearBase:
    """x' = A x + b u + e d, v = x[0]."""

    A: Floats
    b: Floats
    e: Floats

    def impulse(self, column: Floats, times: Floats) -> Floats:
        """Impulse response of v at evenly spaced times from 0."""
        step, x, found = expm(self.A * (times[1] - times[0])), column, []
        for _ in times:
            found.append(x[0])
            x = step @ x
        return np.array(found)

    def signs(self, column: Floats, times: Floats) -> Floats:
        """Signs of the impulse response backwards from the end: inputs that lead farthest."""
        return np.sign(self.impulse(column, times))[::-1]

    def speeds(
        self,
        send: Callable[[int], float],
        times: Sequence[float],
        pushes: ArrayLike = 0.0,
        parts: int = 8,
    ) -> Floats:
        """Speeds (len(times) parts,) while ``send(k)`` acts in each period ``times[k]`` [s].

        ``pushes``: one, or one for each part of each period.
        """
        pushes = np.broadcast_to(pushes, len(times) * parts)
        x, found, B = np.zeros(len(self.b)), [], np.c_[self.b, self.e]
        for k, time in enumerate(times):
            u, step = send(k), held(self.A, B, time / parts)
            for push in pushes[k * parts : (k + 1) * parts]:
                x = step[0] @ x + step[1] @ np.array([u, push])
                found.append(x[0])
        return np.array(found)

    def fastest(
        self, send: Callable[[float], float], d: float, T: float, samples: int, parts: int = 8
    ) -> float:
        """Largest |v| under commands that ``send`` lets through, and pushes of at most d."""
        h, every = T / parts, np.arange(samples * parts)
        ahead = self.signs(self.b, (every[::parts] + 0.5) * h)
        pushes = d * self.signs(self.e, (every + 0.5) * h)
        asked = self.speeds(lambda k: send(10.0 * ahead[k]), [T] * samples, pushes, parts)
        return float(np.abs(asked).max())


def held(A: Floats, B: Floats, h: float) -> tuple[Floats, Floats]:
    """State and input matrices of a period with held input."""
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
