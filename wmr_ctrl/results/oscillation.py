"""Whether the wheel torques swing in a cycle of their own, told from the answer to noise.

A loop that answers noise spreads its torques over many frequencies, and what a reference asks for
is slow.  A limit cycle, or a loop that is about to have one, puts much of the swing into one line
and keeps it up.  The end of a start's transient, and a few periods of noise, do one of these at
most: they are none, and where a window is too short to tell, nothing is told.
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
SHARP, SHORT_LINE, SHORT_SWING = 20, 0.75, 0.9
"""With fewer periods than the first, a line takes in much of its surroundings, and so the noise:
more of the power has to be there, and a larger swing."""
PERIODS = 4
"""Fewest periods in the window: less may be what a start leaves behind."""
KEPT = 2 / 3
"""A quarter of the window swings at least by this share of any quarter before: nothing decays."""
SWING = 0.5
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
    level, duration = float(np.sqrt(np.mean(torque**2))), len(torque) * run.settings.control
    lines = [_line(part, run.settings.control) for part in ((right + left) / 2, (right - left) / 2)]
    strong = [item for item in lines if item is not None and _is_strong(item, level, duration)]
    return max(strong, key=lambda item: item.swing, default=None)


def _is_strong(item: Oscillation, level: float, duration: float) -> bool:
    """Whether a line swings by enough of the torques' RMS ``level`` over the window."""
    needed = SWING if item.frequency * duration > SHARP - 0.5 else SHORT_SWING
    return item.swing > max(needed * level, LEAST)


def _line(torque: FloatArray, period: float) -> Oscillation | None:
    """The strongest line of a torque without its trend, where it holds enough of the power."""
    k, shape = np.arange(len(torque)), np.hanning(len(torque))
    swinging = torque - np.polyval(np.polyfit(k, torque, 1), k)
    power = 2 * np.abs(np.fft.rfft(swinging * shape)) ** 2 / np.sum(shape**2) / len(torque)
    frequency = np.fft.rfftfreq(len(torque), period)
    power[frequency < min(SLOWEST, 1 / (SAMPLES * period))] = 0.0
    peak = int(power.argmax())
    wide = max(3, peak // 10)
    band = slice(max(0, peak - wide), peak + wide + 1)
    line, total = float(np.sum(power[band])), float(np.sum(power))
    needed = LINE if peak >= SHARP else SHORT_LINE
    if total == 0 or line < needed * total or peak < PERIODS or _falls(swinging, band):
        return None
    swing = min(2 * math.sqrt(2 * line), float(np.ptp(torque)))  # a square wave's line is longer
    return Oscillation(swing, float(frequency[peak]))


def _falls(swinging: FloatArray, band: slice) -> bool:
    """Whether what is in a band of frequencies decays from quarter to quarter of the window."""
    whole = np.fft.rfft(swinging)
    within = np.zeros_like(whole)
    within[band] = whole[band]
    quarters = np.array_split(np.fft.irfft(within, len(swinging)), 4)
    swings = [float(np.sqrt(np.mean(part**2))) for part in quarters]
    return any(swings[i] < KEPT * max(swings[:i]) for i in range(1, 4))
