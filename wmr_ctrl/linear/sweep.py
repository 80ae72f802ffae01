"""Sine sweeps through the nonlinear loop, to lay over the linear Bode plot."""

from __future__ import annotations

import math

import control as ct
import numpy as np

from wmr_ctrl.linear.numbers import Floats
from wmr_ctrl.linear.stepper import Stepper

SETTLE, MEASURE = 4, 4
"""Periods that are waited, and then measured, at least."""


def whole_periods(period: float, frequency: float) -> float:
    """The frequency [rad/s] next to ``frequency`` whose period is a whole number of samples."""
    return 2 * math.pi / (period * max(4, round(2 * math.pi / (frequency * period))))


def sweep(
    loop: Stepper,
    axis: int,
    amplitude: float,
    frequencies: Floats,
    output: int,
    settle: float = 10.0,
) -> tuple[Floats, np.ndarray]:
    """Frequencies [rad/s] as used, and the complex gain of the output's first harmonic.

    A sine of ``amplitude`` [N or N m] disturbs force ``axis`` (0, 1); ``output`` is an index into
    (e1, e2, e3, v1, omega); ``settle`` [s] is waited at least.
    """
    used = np.array([whole_periods(loop.period, float(w)) for w in frequencies])
    gains = [_gain(loop, axis, amplitude, float(w), output, settle) for w in used]
    return used, np.array(gains)


def _gain(
    loop: Stepper, axis: int, amplitude: float, w: float, output: int, settle: float
) -> complex:
    samples = round(2 * math.pi / (w * loop.period))
    waited = max(SETTLE, math.ceil(settle / (samples * loop.period))) * samples
    k = np.arange(waited + MEASURE * samples)
    push = np.zeros((len(k), 2))
    push[:, axis] = amplitude * np.sin(2 * math.pi * k / samples)
    course = loop.run(loop.point.s, len(k) * loop.period, push)
    turning = np.exp(-2j * math.pi * k[waited:] / samples)
    first = 2j * np.mean(course.s[waited:, output] * turning)
    return complex(first / amplitude)


def linear_gain(loop: ct.StateSpace, axis: int, frequencies: Floats, output: int) -> np.ndarray:
    """The same gain of a linear sampled loop from `wmr_ctrl.linear.closed_loop`."""
    points = np.exp(1j * np.asarray(frequencies) * loop.dt)
    return np.array([np.atleast_2d(loop(point))[output, axis] for point in points])
