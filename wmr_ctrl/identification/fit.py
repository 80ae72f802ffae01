"""Maximum likelihood of a log by Fisher scoring, and intervals of what was fitted.

Intervals are by the Fisher information and by leaving out blocks of time.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit

from .kalman import (
    COUNTED,
    INDEX,
    LOGARITHMIC,
    MEAN,
    NAMES,
    SKIPPED,
    WATCHED,
    CompiledFilter,
    PassResult,
    blocks_of,
)
from .logs.log import Floats, Mask, Pair
from .logs.samples import LONGEST_DELAY, AxisLog, Samples, forces

Tell = Callable[[], None]
"""Called at each pass, to show progress."""
SKIPPED_TIME = 0.3
"""Time at the start of each stretch that does not count [s]: commands before are not known."""
LAG_LEAST, LAG_MOST = 5e-4, 2.0
PASSES = 40
ENOUGH = 2e-3
"""Gain in log-likelihood below which scoring ends: 6 % of a standard error."""
DAMPING = 1e-3
"""Damping of the first step, and the least after a step that gained nothing."""
ACCEPTED = 1.92
"""Fall of the log-likelihood at the end of an interval by the likelihood."""
FINEST = 3e-4
"""Least noise of force and speed, over how much these vary."""


@dataclass(frozen=True)
class LogProblem:
    """A log, the filter that it is read through, known numbers, and factors of the force noise.

    ``boost`` (N,): up to each sample, 1 where the noise is as elsewhere.
    """

    log: Samples
    filter: CompiledFilter
    known: Floats
    boost: Floats | float = 1.0
    tell: Tell = lambda: None

    def read(self, theta: Floats, slopes: bool = True) -> PassResult:
        """A pass through the filter."""
        kinds = np.where(self.counts, COUNTED, SKIPPED)
        return self.filter(
            self.log, self._starts(), *self._given(theta), slopes=slopes, boost=self.boost,
            kinds=kinds, blocks=blocks_of(self.log.t),
        )  # fmt: skip

    def foretold(self, log: Samples, theta: Floats, start: Floats) -> Floats:
        """Means (N, state) that follow from those (F, state) at the start of each stretch alone."""
        return self.filter(log, start, *self._given(theta), slopes=False, kinds=WATCHED).mean

    @property
    def counts(self) -> Mask:
        """Measurements (N,) that count in the likelihood."""
        return np.asarray(self.log.since > SKIPPED_TIME)

    def _starts(self) -> Floats:
        log, first, start = self.log, self.log.first, at_rest(self.log)
        if log.of_speed:
            start[:, 2:4] = log.seen[first]
        else:
            start[:, :2] = log.seen[first]
            later = np.minimum(first + 5, len(log.t) - 1)
            span = np.maximum(log.t[later] - log.t[first], 1e-6)
            start[:, 2:4] = (log.seen[later] - log.seen[first]) / span[:, None]
        return start

    def _given(self, theta: Floats) -> tuple[Floats, Floats]:
        """All parameters, and the packed covariance at a stretch's start: measured values with
        their variance, the rest hardly known.
        """
        way = np.full(2, 1.0) if self.log.of_speed else self.log.variance
        covariance = packed(np.concatenate((way, [0.25, 1.0, 0.0, 0.0])))
        return np.concatenate((theta, self.known)), covariance


def at_rest(log: Samples) -> Floats:
    """Means (F, MEAN) at the beginning of each stretch of a robot at rest: the torques alone."""
    start = np.zeros((len(log.first), MEAN))
    sent = np.searchsorted(log.command_t, log.t[log.first], "right") - 1
    start[:, 6:8] = log.command[np.maximum(sent, 0)]
    return start


def packed(diagonal: Floats) -> Floats:
    """A diagonal matrix as its upper triangle, row after row."""
    return np.diag(diagonal)[np.triu_indices(len(diagonal))]


@dataclass(frozen=True)
class Fit:
    """A maximum of the likelihood: parameters as searched (n,), which are free, the last pass.

    ``least``: by place, half-widths that no interval goes below.
    """

    problem: LogProblem
    theta: Floats
    free: Mask
    last: PassResult
    least: Mapping[int, float] = field(default_factory=dict)

    @property
    def nll(self) -> float:
        """Minus the log of the likelihood, less a constant."""
        return float(self.last.nll.sum())

    @property
    def inside(self) -> Mask:
        """Free parameters (n,) without noises at an end of their range, whose slopes would move the
        others.
        """
        least, most = ends(self.problem, self.free)
        noise = np.array([name in LOGARITHMIC - {"m", "I"} for name in NAMES])
        return self.free & ~(noise & ((self.theta <= least) | (self.theta >= most)))

    def information(self) -> Floats:
        """Fisher information of the free parameters."""
        return self.last.fisher.sum(axis=0)[np.ix_(self.free, self.free)]


def scored(
    problem: LogProblem,
    theta: Floats,
    free: Mask,
    passes: int = PASSES,
    enough: float = ENOUGH,
) -> Fit:
    """Fisher scoring from ``theta``, damped until each step lowers minus the log-likelihood.

    It ends after ``passes`` steps, or where a step gains less than ``enough`` or promises a tenth
    of that.  The damping is Nielsen's, by the share of what was promised that a step gained.
    Slopes take most of a pass: after a step that lowered nothing they are left out of trials, until
    one is taken at once.
    """
    least, most = ends(problem, free)
    theta = np.clip(theta, least, most)
    # Logarithms move no further in a step than scoring can be trusted.
    reach = np.array([1.5 if name in LOGARITHMIC else np.inf for name in NAMES])
    result, damping, growth = problem.read(theta), DAMPING, 2.0
    sloped = True
    for _ in range(passes):
        problem.tell()
        gradient = result.gradient.sum(axis=0)
        # What lies at an end and would go beyond stays there, so that the others move as they are.
        held = ((theta <= least) & (gradient > 0)) | ((theta >= most) & (gradient < 0))
        moving = free & ~held
        fisher = result.fisher.sum(axis=0)[np.ix_(moving, moving)]
        scale = np.diag(fisher) + 1e-12
        better = at_once = False
        for k in range(12):
            step = -np.linalg.solve(fisher + damping * np.diag(scale), gradient[moving])
            step = np.clip(step, -1.5, 1.5) if np.abs(step).max() > 50 else step
            trial = theta.copy()
            trial[moving] += step
            trial = np.clip(
                trial, np.maximum(least, theta - reach), np.minimum(most, theta + reach)
            )
            step = trial[moving] - theta[moving]
            promised = -float(gradient[moving] @ step + step @ fisher @ step / 2)
            if 0 <= promised < enough / 10:
                break
            after = problem.read(trial, slopes=sloped)
            gained = float(result.nll.sum() - after.nll.sum())
            if gained >= 0:
                better, at_once, share = True, k == 0, gained / max(promised, 1e-300)
                damping = max(damping * max(1 / 3, 1 - (2 * min(share, 2.0) - 1) ** 3), 1e-9)
                growth = 2.0
                break
            damping, growth, sloped = max(damping * growth, DAMPING), 2 * growth, False
        if not better:
            break
        theta, result = trial, after if sloped else problem.read(trial)
        sloped = at_once
        if gained < enough:
            break
    return Fit(problem, theta, free, result)


def ends(problem: LogProblem, free: Mask) -> tuple[Floats, Floats]:
    """Least and largest (n,) of what is searched: no model is truer than FINEST of what it moves.

    Integration, rounding and effects without a name are in the cleanest of logs.
    """
    log = problem.log
    r, half_track = problem.known[:2]
    force = np.std(forces(log.command, r, half_track), axis=0)
    speed = np.std(log.seen, axis=0) if log.of_speed else np.ones(2)
    noise = np.maximum(FINEST * np.concatenate((force, speed)), 1e-9).tolist()
    ranges = {
        "s1": (1e-7, 1e6), "s2": (1e-7, 1e6), "time": (0.02, 60.0),
        "delay": (0.0, LONGEST_DELAY), "lag": (LAG_LEAST, LAG_MOST),
        **{name: (x, 1e6) for name, x in zip(("q1", "q2"), noise[:2], strict=True)},
        **{name: (x, np.inf) for name, x in zip(("n1", "n2"), noise[2:], strict=True)},
    }  # fmt: skip
    low, high = np.full(len(NAMES), -np.inf), np.full(len(NAMES), np.inf)
    for name, pair in ranges.items():
        if free[INDEX[name]]:
            low[INDEX[name]], high[INDEX[name]] = np.log(pair) if name in LOGARITHMIC else pair
    return low, high


PHYSICAL = NAMES[:8]
"""Parameters of the robot; the others are noises."""
FLOOR = 2e-3
"""Least relative half-width of an interval."""
LEAST_BLOCKS, APART = 3, 2.0
"""Fewest blocks before and after a change, and sums of half-widths that set their values apart."""
WIDEST = 14.0
"""Largest half-width of a logarithm: from a millionth to a millionfold, all is undetermined."""


def standard_errors(fit: Fit) -> Floats:
    """Standard errors (n,): the larger of those by the information and by leaving out blocks.

    Zero where a parameter is not free.
    """
    return np.maximum(*_two_errors(fit.last.gradient, fit.last.fisher, fit.inside))


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
