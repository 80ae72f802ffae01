"""Whether the wheel torques swing in a cycle of their own, told from the answer to noise.

A loop that answers noise spreads its torques over many frequencies, and what a reference asks for
is slow.  A limit cycle, or a loop that is about to have one, puts much of the swing into one line.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from wmr_ctrl.results.tracking import last_half, rows_of, torques

if TYPE_CHECKING:
    from wmr_ctrl.results.run import FloatArray, Run

LINE = 1 / 3
"""Share of the fast swing's power that has to be in one line."""
SWING = 0.3
"""Peak to peak swing in that line, as a share of the torques' RMS, from which it counts."""
LEAST = 1e-3
"""The same in N m: less is nothing that a drive could show."""
SLOWEST, SAMPLES = 0.5, 8
"""A cycle is faster than this [Hz], or shorter than so many samples."""
FEWEST = 32
"""Samples from which a line can be told from noise."""


@dataclass(frozen=True)
class Oscillation:
    """A swing of the wheel torques: peak to peak [N m] and frequency [Hz]."""

    swing: float
    frequency: float


def oscillation(run: Run) -> Oscillation | None:
    """The cycle of the last half's wheel torques, in step or against each other; None if none."""
    rows = rows_of(run, last_half(run.settings))
    if rows is None or rows.stop - rows.start < FEWEST:
        return None
    torque = torques(run)[rows]
    if not np.isfinite(torque).all():
        return None
    right, left = torque.T
    level = max(SWING * float(np.sqrt(np.mean(torque**2))), LEAST)
    lines = [_line(part, run.settings.control) for part in ((right + left) / 2, (right - left) / 2)]
    strong = [item for item in lines if item is not None and item.swing > level]
    return max(strong, key=lambda item: item.swing, default=None)


def _line(torque: FloatArray, period: float) -> Oscillation | None:
    """The strongest line of a torque without its trend, where it holds enough of the power."""
    k, shape = np.arange(len(torque)), np.hanning(len(torque))
    swinging = torque - np.polyval(np.polyfit(k, torque, 1), k)
    power = 2 * np.abs(np.fft.rfft(swinging * shape)) ** 2 / np.sum(shape**2) / len(torque)
    frequency = np.fft.rfftfreq(len(torque), period)
    power[frequency < min(SLOWEST, 1 / (SAMPLES * period))] = 0.0
    peak = int(power.argmax())
    wide = max(3, peak // 10)
    line, total = float(np.sum(power[max(0, peak - wide) : peak + wide + 1])), float(np.sum(power))
    if total == 0 or line < LINE * total:
        return None
    return Oscillation(2 * math.sqrt(2 * line), float(frequency[peak]))
