"""Intervals of what was fitted, by the Fisher information and by leaving out blocks of time."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit

from .fit import Fit
from .kalman import INDEX, LOGARITHMIC
from .logs.log import Floats, Mask, Pair
from .logs.samples import AxisLog, Samples

PHYSICAL = ("m", "I", "Fc", "Fv", "c", "Mv", "delay", "lag")
FLOOR = 2e-3
"""Least relative half-width of an interval."""
LEAST_BLOCKS, APART = 3, 2.0
"""Fewest blocks before and after a change, and sums of half-widths that set their values apart."""
WIDEST = 14.0
"""Largest half-width of a logarithm: from a millionth to a millionfold, all is undetermined."""


def standard_errors(fit: Fit) -> tuple[Floats, Floats]:
    """Standard errors (n,) by the Fisher information, and by leaving out blocks of time.

    Zero where a parameter is not free.
    """
    return _two_errors(fit.last.gradient, fit.last.fisher, fit.inside)


def _two_errors(gradient: Floats, fisher: Floats, free: Mask) -> tuple[Floats, Floats]:
    """Both errors from gradient (B, n) and information (B, n, n) of blocks of time.

    The second is by one Newton step for each block b that is left out, theta_b = theta + (H -
    H_b)^-1 g_b.
    """
    whole = _whole(fisher, free)
    by_fisher, left = np.zeros(len(free)), np.zeros(len(free))
    by_fisher[free] = np.sqrt(np.maximum(np.diag(np.linalg.inv(whole)), 0))
    moved = []
    for block in range(len(fisher)):
        own = fisher[block][np.ix_(free, free)]
        if not own.any():
            continue
        lacking = whole - own + 1e-9 * np.diag(np.diag(whole))
        moved.append(np.linalg.solve(lacking, gradient[block][free]))
    if not moved:
        return by_fisher, left
    count = len(moved)
    spread = np.array(moved) - np.mean(moved, axis=0)
    left[free] = np.sqrt((count - 1) / count * (spread**2).sum(axis=0))
    return by_fisher, left


def _whole(fisher: Floats, free: Mask) -> Floats:
    """Information of all blocks on what is free, and a little more of each number by itself.

    Without that, what a log does not tell apart would move by roundings, further than any interval.
    """
    whole = fisher.sum(axis=0)[np.ix_(free, free)]
    return np.asarray(whole + 1e-10 * np.diag(np.diag(whole)))


def errors_of(gradient: Floats, fisher: Floats, free: Mask) -> Floats:
    """Half-widths (n,) of 95 % intervals: the larger of both errors'."""
    by_fisher, left = _two_errors(gradient, fisher, free)
    return np.maximum(stdtrit(len(fisher) - 1, 0.975) * left, 1.96 * by_fisher)


class Fitted(NamedTuple):
    """Parameters (n,), which are free, and by blocks of time gradient (B, n) and information."""

    theta: Floats
    free: Mask
    gradient: Floats
    fisher: Floats

    def of(self, part: slice) -> tuple[Floats, Floats]:
        """Parameters and half-widths (n,) by some blocks, by one Newton step; LinAlgError where
        these do not tell one.
        """
        free, gradient, fisher = self.free, self.gradient[part], self.fisher[part]
        step = np.zeros(len(free))
        step[free] = -np.linalg.solve(_whole(fisher, free), gradient.sum(axis=0)[free])
        return self.theta + step, errors_of(gradient + fisher @ step, fisher, free)


class Change(NamedTuple):
    """A parameter that was another before a time [s] than after it, with both half-widths."""

    time: float
    values: Pair
    halves: Pair


def changes(fit: Fitted, names: Sequence[str], log: Samples | AxisLog) -> dict[str, Change]:
    """Parameters of ``names`` that were not the same all along, at the time that shows it best.

    All but delays are logarithms.  The log is cut where blocks end; values of both parts are apart
    by APART times both half-widths and by what matters: a twentieth, or a control period.
    """
    count, best = len(fit.fisher), np.full(len(names), APART)
    ends, found = np.linspace(log.t[0], log.t[-1], count + 1), {}
    least = [log.period if name.startswith("delay") else math.log(1.05) for name in names]
    for block in range(LEAST_BLOCKS, count - LEAST_BLOCKS + 1):
        try:
            (before, wide), (after, narrow) = fit.of(slice(block)), fit.of(slice(block, count))
        except np.linalg.LinAlgError:
            continue
        for k in np.flatnonzero(fit.free).tolist():
            apart, both = abs(after[k] - before[k]), wide[k] + narrow[k]
            if apart > least[k] and apart > best[k] * both:
                best[k] = apart / both
                pair, halves = (before[k], after[k]), (wide[k], narrow[k])
                found[names[k]] = Change(float(ends[block]), pair, halves)
    return found


def half_widths(fit: Fit) -> Floats:
    """Half-widths (n,) of 95 % intervals: the larger of both errors', and of the floor."""
    half = errors_of(fit.last.gradient, fit.last.fisher, fit.inside)
    for place, least in fit.least.items():
        half[place] = max(half[place], least)
    return half


def intervals_of(fit: Fit) -> dict[str, tuple[float, float, float]]:
    """Value, low and high of each physical parameter, in SI units."""
    half = half_widths(fit)
    step = plant_step(fit.problem.log.period)
    intervals = {}
    for name in PHYSICAL:
        value, width = float(fit.theta[INDEX[name]]), float(half[INDEX[name]])
        if name in LOGARITHMIC:
            value, width = math.exp(value), min(max(width, FLOOR), WIDEST)
            intervals[name] = (value, value * math.exp(-width), value * math.exp(width))
            continue
        least = step / 2 if name in ("delay", "lag") else FLOOR * abs(value)
        width = max(width, least)
        intervals[name] = (value, value - width, value + width)
    return intervals


def plant_step(period: float) -> float:
    """Step of the plant [s]: a whole part of a control period, of one millisecond at most."""
    return period / math.ceil(period / 1e-3 - 1e-9)
