"""Speeds of many linear speed loops at once, for given commands and pushes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

SINGLE = np.ones((1, 1))
"""Parts of the command for a robot with a single limited speed."""
SQUARED, TERMS = 10, 9


def driven(
    bases: tuple[np.ndarray, np.ndarray, np.ndarray],
    send: Callable[[np.ndarray], np.ndarray],
    asked: np.ndarray,
    pushes: np.ndarray,
    T: float,
    times: np.ndarray | None = None,
    *,
    telling: bool = True,
    loops: np.ndarray = SINGLE,
    limited: np.ndarray = SINGLE,
    signed: bool = False,
) -> np.ndarray:
    """Largest speed of many robots, each with its own requested commands, sample by sample.

    ``loops`` (loops, axes): parts of the command that each loop follows. ``limited`` (speeds,
    loops): limited speeds, as combinations of the loops' speeds; if ``signed``, in that direction
    alone. ``bases``: A, b, e of the first loop of all robots, then of the second, and so on.
    ``pushes`` (loops robots, samples, parts of a period) have the same order. ``asked`` (robots,
    axes, samples): requests. ``send``: as the adversary's Sender, for a whole period or for each
    of its parts. ``times`` (robots, samples): from each sample to the next, with few different
    values; by default a period T. The filter receives them if ``telling``.
    """
    A, b, e = bases
    count, samples, parts = pushes.shape
    robots, axes, _ = asked.shape
    given = np.zeros((count, 4, 4))
    given[:, :2, :2], given[:, :2, 2], given[:, :2, 3] = A, b, e
    sizes, which = np.unique(np.full((1, 1), T) if times is None else times, return_inverse=True)
    every = np.stack([exponentials(given * (size / parts))[:, :2] for size in sizes])
    which = np.broadcast_to(which.reshape(-1, 1 if times is None else samples), (robots, samples))
    which = np.tile(which, (len(loops), 1))
    x, worst, u = np.zeros((count, 4)), np.zeros(robots), np.zeros((3, robots))
    for k in range(samples):
        u[:axes], both = asked[:, :, k].T, every[which[:, k], np.arange(count)]
        if times is not None and telling and k:
            u[2] = np.where(times[:, k - 1] > 0, times[:, k - 1], -1.0)
        sent = send(u)
        acting = np.broadcast_to(sent, (parts, *sent.shape[-2:]))
        for part in range(parts):
            x[:, 2] = (loops @ acting[part, :axes]).ravel()
            x[:, 3] = pushes[:, k, part]
            x[:, :2] = np.einsum("nij,nj->ni", both, x)
            speeds = limited @ x[:, 0].reshape(-1, robots)
            worst = np.maximum(worst, (speeds if signed else np.abs(speeds)).max(axis=0))
    return worst


def impulses(A: np.ndarray, column: np.ndarray, step: float, count: int) -> np.ndarray:
    """Impulse responses (bases, count) of v of many bases, at the middles of steps."""
    x = np.einsum("nij,nj->ni", exponentials(A * (step / 2)), column)
    ahead, found = exponentials(A * step), []
    for _ in range(count):
        found.append(x[:, 0])
        x = np.einsum("nij,nj->ni", ahead, x)
    return np.array(found).T


def exponentials(A: np.ndarray) -> np.ndarray:
    """Exponentials of a stack of matrices: the series of a small part of each, then squared.

    All at once, in a fifth of the time that SciPy takes.
    """
    small, found = A * 2.0**-SQUARED, np.eye(A.shape[-1])
    for k in range(TERMS, 0, -1):
        found = np.eye(A.shape[-1]) + small @ found / k
    for _ in range(SQUARED):
        found = found @ found
    return found
