"""The worst commands of all that a band admits, for one base: a linear programme.

A band admits the commands that keep its bounds of v and of -v within c, held and, a period later,
stopped.  With rises p and falls q of the command, and the parts P - Q of the command itself, each
bound is linear in them: so the largest speed that admitted commands lead to is a linear
programme's.  Of its conditions those enter that its last answer breaks, until there are none.  It
shares no code with the filter but the tables.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.optimize import linprog
from scipy.sparse import csr_matrix

from tests.control.filter.linear_base import LinearBase
from wmr_ctrl.world.model.system import System

Floats = NDArray[np.float64]
Kept = tuple[str, int, int]
"""A condition: of v or -v, held or stopped, at a sample, on a piece of the tables."""
KINDS = ("v held", "-v held", "v stopped", "-v stopped")
PIECES = 2
"""Pieces of the tables in a period."""


@dataclass(frozen=True)
class Tables:
    """What a band knows of its loop: bounds of its step response at all ages, and c."""

    low: Floats
    high: Floats
    after_low: Floats
    after_high: Floats
    c: float

    @property
    def last(self) -> int:
        """The piece that holds for ever."""
        return len(self.after_low) + PIECES - 1


def tables_of(system: System, V: float, samples: int) -> Tables:
    """Tables of the first axis, carried on behind their end as the filter does it."""
    known: Mapping[str, Floats] = {
        item.signal.name: np.ravel(np.array(item.value, dtype=float)) for item in system.params
    }
    left, fading = known["filter.left_v"][0], known["filter.fading_v"][0]
    low, high = (
        1 + way * np.append(known[f"filter.{name}_v"], left)
        for name, way in (("below", -1), ("above", 1))
    )
    last = len(low) - 1
    behind = left * fading ** (np.arange(PIECES * samples + 1) // PIECES)
    after = slice(None, last - PIECES)  # the last piece holds for ever, and what leads to it
    return Tables(
        np.r_[low[:last], 1 - behind], np.r_[high[:last], 1 + behind],
        np.r_[low[after], low[last - PIECES :].min()],
        np.r_[high[after], high[last - PIECES :].max()],
        (V * (1 - 2.0**-26) - known["filter.delta"][0]) / known["filter.gain"][1],
    )  # fmt: skip


class Worst:
    """The programme for so many samples; conditions that bind one base help with the next."""

    def __init__(self, known: Tables, samples: int) -> None:
        """Begin with the first and the last piece of each sample."""
        self.known, self.samples = known, samples
        self.rows: dict[Kept, Floats] = {}
        for k in range(samples):
            for kind in KINDS:
                self._keep((kind, k, PIECES))
                self._keep((kind, k, known.last))

    def commands(self, base: LinearBase, T: float, share: float = 1.0) -> tuple[Floats, float]:
        """The commands, and the speed that they lead to a share of a period after the last."""
        n, broken = self.samples, 1
        ahead = reached(base, T * (np.arange(n) + share))[::-1]
        while broken:
            x, speed = self._solved(np.r_[ahead, -ahead, np.zeros(2 * n)])
            broken = sum(self._keep(kept) for kept in self._broken(x))
        return np.cumsum(x[:n] - x[n : 2 * n]), speed

    def _solved(self, gain: Floats) -> tuple[Floats, float]:
        n = self.samples
        sums = np.tril(np.ones((n, n)))
        equal = np.hstack([sums, -sums, -np.eye(n), np.eye(n)])
        most = np.full(len(self.rows), self.known.c)
        found = linprog(
            -gain, csr_matrix(np.array(list(self.rows.values()))), most, csr_matrix(equal),
            np.zeros(n), method="highs",
        )  # fmt: skip
        return found.x, -found.fun

    def _keep(self, kept: Kept) -> bool:
        """Add a condition; False where it is there."""
        if kept in self.rows:
            return False
        kind, k, piece = kept
        row = np.zeros((4, self.samples))
        ages = PIECES * (k - np.arange(k + 1)) + piece
        up, down = self.known.high[ages], -self.known.low[ages]
        row[0, : k + 1], row[1, : k + 1] = (up, down) if kind[0] == "v" else (down, up)
        if kind.endswith("stopped"):
            fall, rise = (
                -self.known.after_low[piece - PIECES],
                self.known.after_high[piece - PIECES],
            )
            row[2, k], row[3, k] = (fall, rise) if kind[0] == "v" else (rise, fall)
        self.rows[kept] = row.ravel()
        return True

    def _broken(self, x: Floats) -> list[Kept]:
        """The worst condition of each kind and sample, where it is broken."""
        p, q, own, other = x.reshape(4, -1)
        known, found = self.known, list[Kept]()
        for k in range(self.samples):
            ages = PIECES * (k - np.arange(k + 1))[:, None] + np.arange(known.last + 1)
            up, down = known.high[ages], -known.low[ages]
            v, back = p[: k + 1] @ up + q[: k + 1] @ down, p[: k + 1] @ down + q[: k + 1] @ up
            fall, rise = -known.after_low, known.after_high
            values = (
                v, back, v[PIECES:] + own[k] * fall + other[k] * rise,
                back[PIECES:] + own[k] * rise + other[k] * fall,
            )  # fmt: skip
            for kind, value in zip(KINDS, values, strict=True):
                worst = int(value.argmax())
                if value[worst] > known.c * (1 + 1e-8):
                    found.append((kind, k, worst + known.last + 1 - len(value)))
        return found


def reached(base: LinearBase, times: Floats) -> Floats:
    """Step response of v at these times."""
    rest = -np.linalg.solve(base.A, base.b)
    return np.array([(rest - expm(base.A * t) @ rest)[0] for t in times])
