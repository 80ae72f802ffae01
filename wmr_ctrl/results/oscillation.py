"""Limit cycles of a run, distinguished from the response to noise.

A loop's response to noise spreads over many frequencies, and the motion that a reference demands is
slow.  A limit cycle, or a loop close to one, concentrates its power in one spectral line and
sustains it.  The end of a start's transient and a few periods of noise have at most one of these
properties, so they are not reported.  Nothing is reported in a window that is too short to decide.

Fast cycles are searched in the wheel torques, in phase or in opposite phase.  A slow line of torque
may be needed against a slope or a gust; a slow cycle is one of the velocities about the desired
ones, at any frequency.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .measures import torques
from .windows import rows_of, working

if TYPE_CHECKING:
    from .run import Floats, Run

LINE = 1 / 3
"""Share of the fast swing's power that has to be in one line."""
SHARP, SHORT_LINE = 20, 0.75
"""Number of periods below which a line includes much of the surrounding noise, and the larger share
of the power that it then needs."""
PERIODS = 4
"""Fewest periods in the window: less may be what a start leaves behind."""
KEPT = 2 / 3
"""A quarter of the window swings at least by this share of any quarter before: nothing decays."""
SWING = 0.9
"""Peak to peak swing in that line, as a share of the torques' RMS, from which it counts."""
LEAST = 1e-3
"""Least peak to peak swing in N m; a drive could not show a smaller one."""
SLOWEST, SAMPLES = 0.5, 8
"""A cycle of torque is faster than this [Hz], or shorter than so many samples."""
SWAY = 0.3
"""Peak to peak swing of a velocity about the desired one, as a share of its limit, that counts."""
FEWEST = 32
"""Samples from which a line can be told from noise."""
TORQUE, SPEEDS = ("torque", "N m"), (("v1", "m/s"), ("omega", "rad/s"))


@dataclass(frozen=True)
class Oscillation:
    """An oscillation of torques or of a velocity: peak to peak [unit] and frequency [Hz].

    ``quantity``: "torque" (of a wheel), "v1" or "omega" (less the desired one).
    """

    swing: float
    frequency: float
    quantity: str = TORQUE[0]
    unit: str = TORQUE[1]


def oscillation(run: Run) -> Oscillation | None:
    """The largest cycle of the wheel torques, else of a velocity, while `working`; None without."""
    rows = rows_of(run, working(run.settings))
    if rows is None or rows.stop - rows.start < FEWEST:
        return None
    strong = [*_torque_cycles(run, rows)] or [*_velocity_cycles(run, rows)]
    return max(strong, key=lambda item: item.swing, default=None)


def _torque_cycles(run: Run, rows: slice) -> list[Oscillation]:
    torque = torques(run)[rows]
    if not np.isfinite(torque).all():
        return []
    right, left = torque.T
    level, period = float(np.sqrt(np.mean(torque**2))), run.settings.control
    fast = min(SLOWEST, 1 / (SAMPLES * period))
    lines = [_line(part, period, fast) for part in ((right + left) / 2, (right - left) / 2)]
    least = max(SWING * level, LEAST)
    return [item for item in lines if item is not None and item.swing > least]


def _velocity_cycles(run: Run, rows: slice) -> list[Oscillation]:
    swings = []
    axes = zip(SPEEDS, ("v1_d", "v2_d"), run.settings.v_u1, strict=True)
    for (name, unit), desired, limit in axes:
        off = (run[name] - run[desired])[rows]
        line = _line(off, run.settings.control, 0.0) if np.isfinite(off).all() else None
        if line is not None and line.swing > SWAY * limit:
            swings.append(Oscillation(line.swing, line.frequency, name, unit))
    return swings


def fast_swing_rms(signal: Floats, period: float) -> float:
    """RMS over rows and columns of a signal's (N, n) content above `SLOWEST` [its unit].

    Content with fewer than `PERIODS` periods in the rows may be a start or a change of the motion.
    """
    power = np.abs(np.fft.rfft(signal, axis=0)) ** 2
    power[np.fft.rfftfreq(len(signal), period) < SLOWEST] = power[:PERIODS] = 0.0
    power[1 : len(power) - (len(signal) % 2 == 0)] *= 2.0  # both halves of the spectrum
    return float(np.sqrt(np.sum(power) / len(signal) ** 2 / signal.shape[1]))


def _line(signal: Floats, period: float, slowest: float) -> Oscillation | None:
    """Strongest spectral line from ``slowest`` [Hz] on, without trend; None if not narrow."""
    k, shape = np.arange(len(signal)), np.hanning(len(signal))
    swinging = signal - np.polyval(np.polyfit(k, signal, 1), k)
    power = 2 * np.abs(np.fft.rfft(swinging * shape)) ** 2 / np.sum(shape**2) / len(signal)
    frequency = np.fft.rfftfreq(len(signal), period)
    power[frequency < slowest] = 0.0
    peak = int(power.argmax())
    wide = max(3, peak // 10)
    band = slice(max(0, peak - wide), peak + wide + 1)
    line, total = float(np.sum(power[band])), float(np.sum(power))
    needed = LINE if peak >= SHARP else SHORT_LINE
    if total == 0 or line < needed * total or peak < PERIODS or _falls(swinging, band):
        return None
    swing = min(2 * math.sqrt(2 * line), float(np.ptp(signal)))  # a square wave's line is longer
    return Oscillation(swing, float(frequency[peak]))


def _falls(swinging: Floats, band: slice) -> bool:
    """True if a band of frequencies decays from quarter to quarter of the window."""
    whole = np.fft.rfft(swinging)
    within = np.zeros_like(whole)
    within[band] = whole[band]
    quarters = np.array_split(np.fft.irfft(within, len(swinging)), 4)
    swings = [float(np.sqrt(np.mean(part**2))) for part in quarters]
    return any(swings[i] < KEPT * max(swings[:i]) for i in range(1, 4))
