"""Zonotopes c + G xi, |xi_k| <= 1, many at once: rows of two numbers of them, and fewer columns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wmr_ctrl.checks.world import Floats
from wmr_ctrl.corridor.affine import SUMS as SUMS
from wmr_ctrl.corridor.affine import Spanned

COARSE = 1e-12
"""Share by which products of such matrices and their sums can err."""
Ends = tuple[Floats, Floats]
"""Of intervals, (C, 2) each."""


@dataclass(frozen=True)
class Rows:
    """Two numbers of each of C cells, both axes': ``c`` + ``rows`` xi, give or take ``error``."""

    c: Floats
    rows: Floats
    error: Floats

    @classmethod
    def of(cls, c: Floats, rows: Floats) -> Rows:
        """Without an error."""
        return cls(c, rows, np.zeros_like(c))

    @property
    def ends(self) -> Ends:
        """Of the intervals that hold them."""
        radius = (np.abs(self.rows).sum(axis=2) + self.error) * SUMS + COARSE * np.abs(self.c)
        return self.c - radius, self.c + radius

    def plus(self, other: Rows, times: Floats | float = 1.0) -> Rows:
        """With another one added, each so many times."""
        times = np.broadcast_to(times, self.c.shape)
        one, two = alike([self.rows, times[:, :, None] * other.rows])
        far = times * other.c
        lost = np.abs(self.c) + np.abs(far) + (np.abs(one) + np.abs(two)).sum(axis=2)
        return Rows(
            self.c + far, one + two, self.error + np.abs(times) * other.error + COARSE * lost
        )

    def of_axis(self, axis: int) -> Rows:
        """Of one axis alone."""
        one = slice(axis, axis + 1)
        return Rows(self.c[:, one], self.rows[:, one], self.error[:, one])

    def times(self, by: Floats) -> Rows:
        """So many times each."""
        none = Rows(np.zeros_like(self.c), np.zeros((*self.c.shape, 0)), np.zeros_like(self.c))
        return none.plus(self, by)

    def between(self, v: Rows, slope: Floats, known: Ends) -> Ends:
        """Ends from the cell, and from what is ``known`` of v, by which it has the ``slope``."""
        low, high = self.ends
        left, right = self.plus(v, -slope).ends
        by = slope * known[0], slope * known[1]
        return (
            np.maximum(low, left + np.minimum(*by) - COARSE),
            np.minimum(high, right + np.maximum(*by) + COARSE),
        )


def radius_of(G: Floats) -> Floats:
    """Half-widths (C, n) of the boxes around zonotopes with such columns."""
    return np.asarray(np.abs(G).sum(axis=2) * SUMS)


def linear(forms: Spanned, radius: Floats) -> tuple[Floats, Floats, Floats]:
    """Of boxes of such half-widths: middles (C, out), slopes (C, out, in) and errors (C, out)."""
    wide = radius[:, None] > 0
    slope = np.where(wide, forms.L / np.where(wide, radius[:, None], 1.0), 0.0)
    return forms.c, slope, forms.r * SUMS + forms.size * COARSE


def alike(parts: list[Floats]) -> list[Floats]:
    """With columns of zeros, as many columns in each."""
    most = max(item.shape[2] for item in parts)
    return [
        np.concatenate([item, np.zeros((*item.shape[:2], most - item.shape[2]))], axis=2)
        for item in parts
    ]


def with_errors(G: Floats, error: Floats, first: int = 0) -> Floats:
    """With one more column for each error, in the rows from ``first`` on."""
    more = np.zeros((len(G), G.shape[1], error.shape[1]))
    places = np.arange(error.shape[1])
    more[:, first + places, places] = error
    return np.concatenate([G, more], axis=2)


def reduced(G: Floats, scale: Floats, columns: tuple[int, int]) -> Floats:
    """With as few columns as are kept where there are more: the smallest become a box."""
    G = G[:, :, (G != 0).any(axis=(0, 1))]
    if G.shape[2] <= columns[1]:
        return G
    size = (np.abs(G) / scale[:, None]).max(axis=1).mean(axis=0)
    order = np.argsort(-size)
    first, left = order[: columns[0]], order[columns[0] :]
    box = box_of(G[:, :, left] / scale[:, None]) * scale[:, None]
    return np.concatenate([G[:, :, first], box], axis=2)


def box_of(G: Floats) -> Floats:
    """Columns (C, n, n) of boxes, along the principal axes, that hold zonotopes (C, n, columns)."""
    axes = np.linalg.eigh(G @ G.transpose(0, 2, 1))[1]
    size = np.abs(axes.transpose(0, 2, 1) @ G).sum(axis=2)
    size = size * SUMS + size.max(axis=1, keepdims=True) * COARSE
    return np.asarray(axes * size[:, None, :])
