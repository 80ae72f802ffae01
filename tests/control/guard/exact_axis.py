"""Robots of one axis each, side by side and exactly: friction, push, mass, lag and late commands.

Nothing here comes from the product.  A control period has PARTS equal parts.  In each the acting
force is constant or, behind a lag, an exponential.  There is no friction, or dry friction, or a
grip that stops the robot instantly.  Velocity and its integral are exact, except in the part in
which dry friction stops or starts a robot, which is divided into many.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

PARTS, PIECES = 8, 64


@dataclass
class Robots:
    """Velocities ``v``, forces behind the lag ``acting`` and time constants ``lag`` (0: none)."""

    v: np.ndarray
    acting: np.ndarray
    lag: np.ndarray

    def move(self, force, push, mass, grip, h):
        """Advance by ``h`` [s] with dry friction ``grip`` (inf: a stop); return the integral
        of v.
        """
        slow = self.lag > 0
        lag = np.where(slow, self.lag, 1.0)
        gap = np.where(slow, self.acting - force, 0.0)
        held, dry = np.isinf(grip), np.where(np.isinf(grip), 0.0, grip)
        way = np.where(self.v != 0, np.sign(self.v), np.sign(force + gap + push))
        rate = (force + push - way * dry) / mass
        after = gap * lag * -np.expm1(-h / lag) / mass
        end = self.v + rate * h + after
        total = self.v * h + rate * h * h / 2 + lag * (gap * h / mass - after)
        stuck = (self.v == 0) & (np.abs(force + gap + push) <= dry)
        for i in np.nonzero((dry > 0) & (stuck | (end * way < 0)))[0]:
            end[i], total[i] = _stopping(
                self.v[i], force[i] + push[i], gap[i], lag[i], dry[i], mass[i], h
            )
        self.v, total = np.where(held, 0.0, end), np.where(held, 0.0, total)
        self.acting = np.where(slow, force + gap * np.exp(-h / lag), force)
        return total


def _stopping(v, force, gap, lag, dry, mass, h):
    """Velocity and distance of one robot that dry friction stops or releases."""
    total, piece = 0.0, h / PIECES
    for _ in range(PIECES):
        mean = force + gap * lag * -np.expm1(-piece / lag) / piece
        gap *= np.exp(-piece / lag)
        way = np.sign(v) or np.sign(mean)
        if v == 0.0 and abs(mean) <= dry:
            continue
        new = v + piece * (mean - way * dry) / mass
        new = 0.0 if new * way < 0 else new
        total, v = total + piece * (v + new) / 2, new
    return v, total
