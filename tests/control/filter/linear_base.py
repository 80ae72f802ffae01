"""A base with a linear speed loop, driven by the commands that are worst for it.

It shares no code with the filter: the plant is integrated exactly by matrix exponentials, and its
commands switch where its own impulse response changes sign, seen backwards from the end.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm


@dataclass(frozen=True)
class LinearBase:
    """x' = A x + b u + e d, v = x[0]."""

    A: np.ndarray
    b: np.ndarray
    e: np.ndarray

    def impulse(self, column, times):
        """Impulse response of v at evenly spaced times from 0."""
        step, x, found = expm(self.A * (times[1] - times[0])), column, []
        for _ in times:
            found.append(x[0])
            x = step @ x
        return np.array(found)

    def fastest(self, send, d, T, samples, parts=8):
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


def held(A, B, h):
    """State and input matrices over a period of held input."""
    n, m = B.shape
    both = expm(np.block([[A, B], [np.zeros((m, n + m))]]) * h)
    return both[:n, :n], both[:n, n:]


def pi_base(M, kp, ki, c):
    """M v' = kp (u - v) + f - c v + d, f' = ki (u - v)."""
    A = np.array([[-(kp + c) / M, 1 / M], [-ki, 0.0]])
    return LinearBase(A, np.array([kp / M, ki]), np.array([1 / M, 0.0]))


def second_order_base(w0, z, K):
    """v'' + 2 z w0 v' + w0^2 v = w0^2 (K u + d)."""
    A = np.array([[0.0, 1.0], [-(w0**2), -2 * z * w0]])
    return LinearBase(A, np.array([0.0, K * w0**2]), np.array([0.0, w0**2]))
