"""Maximum likelihood of a log by Fisher scoring, with intervals.

Intervals come from the Fisher information and from leaving out blocks of time.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np
from scipy.special import stdtrit

from wmr_ctrl.core.data import data, with_tuples

from .kalman import (
    COUNTED,
    INDEX,
    LOGARITHMIC,
    LOGS,
    MEAN,
    NAMES,
    SKIPPED,
    WATCHED,
    CompiledFilter,
    Pass,
    PassResult,
    blocks_of,
)
from .logs.log import Floats, Mask, Pair
from .logs.samples import LONGEST_DELAY, AxisLog, Samples, forces, speeds

SKIPPED_TIME = 0.3
"""Time at the start of each stretch that does not count [s]: commands before are not known."""
RANGES: Mapping[str, Pair] = with_tuples(data(__package__, "fit.toml")["ranges"]) | {
    "delay": (0.0, LONGEST_DELAY)
}
LAG_LEAST = RANGES["lag"][0]
NOISES = [INDEX[name] for name in ("q1", "q2", "n1", "n2")]
PASSES = 40
ENOUGH = 2e-3
"""Gain in log-likelihood below which scoring ends: 6 % of a standard error."""
DAMPING = 1e-3
"""Damping of the first step."""
LESS = 8.0
"""Growth of the damping after a step without gain."""
ACCEPTED = 1.92
"""Fall of the log-likelihood at the end of an interval by the likelihood."""
FINEST = 3e-4
"""Least noise of force and speed, relative to their variation."""


@dataclass(frozen=True)
class LogProblem:
    """A log, the Kalman filter that reads it, and known numbers."""

    log: Samples
    filter: CompiledFilter
    known: Floats

    def read(self, theta: Floats, slopes: bool = True) -> PassResult:
        """One pass of the filter over the log."""
        kinds = np.where(self.counts, COUNTED, SKIPPED)
        return self.filter(
            self.log, self._starts(), *self._given(theta), slopes=slopes, kinds=kinds,
            blocks=blocks_of(self.log.t),
        )  # fmt: skip

    def foretold(self, log: Samples, theta: Floats, start: Floats) -> Floats:
        """Means (N, state) predicted from those (F, state) at the start of each stretch alone."""
        return self.filter(log, start, *self._given(theta), slopes=False, kinds=WATCHED).mean

    @property
    def counts(self) -> Mask:
        """Mask (N,) of the measurements in the likelihood."""
        return np.asarray(self.log.since > SKIPPED_TIME)

    def _starts(self) -> Floats:
        log, first, start = self.log, self.log.first, at_rest(self.log)
        start[:, 2:4] = speeds(log)[first]
        if not log.of_speed:
            start[:, :2] = log.seen[first]
        return start

    def _given(self, theta: Floats) -> tuple[Floats, Floats]:
        """All parameters, and the packed covariance at a stretch's start: measured values with
        their variance, others with a large one.
        """
        way = np.full(2, 1.0) if self.log.of_speed else self.log.variance
        covariance = packed(np.concatenate((way, [0.25, 1.0, 0.0, 0.0])))
        return np.concatenate((theta, self.known)), covariance


def at_rest(log: Samples) -> Floats:
    """Means (F, MEAN) at each stretch's beginning, for a robot at rest: 0 except for torques."""
    start = np.zeros((len(log.first), MEAN))
    sent = np.searchsorted(log.command_t, log.t[log.first], "right") - 1
    start[:, 6:8] = log.command[np.maximum(sent, 0)]
    return start


def packed(diagonal: Floats) -> Floats:
    """A diagonal matrix as its upper triangle, row after row."""
    return np.diag(diagonal)[np.triu_indices(len(diagonal))]


@dataclass(frozen=True)
class Fit:
    """A maximum of the likelihood: searched parameters (n,), the mask of free ones, the last pass.

    ``least`` (n,): lower limits of half-widths.
    """

    problem: LogProblem
    theta: Floats
    free: Mask
    last: PassResult
    least: Floats | float = 0.0

    @property
    def nll(self) -> float:
        """Minus the log of the likelihood, less a constant."""
        return float(self.last.nll.sum())

    @property
    def inside(self) -> Mask:
        """Mask (n,) of the free parameters, except noise parameters at a bound.

        The gradients of those would bias the other parameters.
        """
        least, most = ends(self.problem, self.free)
        noise = LOGS & np.array([name not in PHYSICAL for name in NAMES])
        return self.free & ~(noise & ((self.theta <= least) | (self.theta >= most)))

    def information(self) -> Floats:
        """Fisher information of the free parameters."""
        return self.last.fisher.sum(axis=0)[np.ix_(self.free, self.free)]


P = TypeVar("P", bound=Pass)


def climbed(
    read: Callable[[Floats, bool], P], theta: Floats, free: Mask, ends: tuple[Floats, Floats],
    reach: Floats | float, passes: int, enough: float,
) -> tuple[Floats, P]:  # fmt: skip
    """Fisher scoring from ``theta``, damped until each step lowers the negative log-likelihood.

    ``read`` gives a pass, with gradients if asked.  No step exceeds ``reach`` or leaves ``ends``.
    The search ends after ``passes`` successful steps, after as many failed ones, or when a step
    gains less than ``enough`` or promises a tenth of that.  Gradients take most of a pass: after a
    failed step, trials omit them until one succeeds.
    """
    least, most = ends
    theta = np.clip(theta, least, most)
    result, damping, sloped = read(theta, True), DAMPING, True
    for _ in range(2 * passes):
        gradient = result.gradient.sum(axis=0)
        # What lies at an end and would go beyond stays there, so that the others move as they are.
        held = ((theta <= least) & (gradient > 0)) | ((theta >= most) & (gradient < 0))
        moving = free & ~held
        fisher = result.fisher.sum(axis=0)[np.ix_(moving, moving)]
        damped = fisher + damping * np.diag(np.diag(fisher) + 1e-12)
        step = -np.linalg.solve(damped, gradient[moving])
        step = np.clip(step, -1.5, 1.5) if np.abs(step).max(initial=0.0) > 50 else step
        trial = theta.copy()
        trial[moving] += step
        trial = np.clip(trial, np.maximum(least, theta - reach), np.minimum(most, theta + reach))
        step = trial[moving] - theta[moving]
        promised = -float(gradient[moving] @ step + step @ fisher @ step / 2)
        if 0 <= promised < enough / 10:
            break
        after = read(trial, sloped)
        gained = float(np.sum(result.nll) - np.sum(after.nll))
        if not gained >= 0:
            damping, sloped = LESS * max(damping, DAMPING), False
            continue
        theta, result = trial, after if sloped else read(trial, True)
        damping, sloped = damping / 3, True
        if gained < enough:
            break
    return theta, result


def scored(
    problem: LogProblem,
    theta: Floats,
    free: Mask,
    passes: int = PASSES,
    enough: float = ENOUGH,
) -> Fit:
    """A maximum of the likelihood near ``theta``; logarithms move no further in a step than scoring
    can be trusted.
    """
    both, reach = ends(problem, free), np.where(LOGS, 1.5, np.inf)
    theta, last = climbed(problem.read, theta, free, both, reach, passes, enough)
    return Fit(problem, theta, free, last)


def ends(problem: LogProblem, free: Mask) -> tuple[Floats, Floats]:
    """Lower and upper bounds (n,) of the search; noise is at least FINEST times its signal.

    Even the cleanest logs contain errors of integration, rounding and unmodelled effects.
    """
    log, ranges = problem.log, np.array([RANGES[name] for name in NAMES]).T
    force = np.std(forces(log.command, *problem.known[:2]), axis=0)
    speed = np.std(log.seen, axis=0) if log.of_speed else np.ones(2)
    ranges[0, NOISES] = np.maximum(FINEST * np.concatenate((force, speed)), 1e-9)
    with np.errstate(divide="ignore"):
        ranges[:, LOGS] = np.log(ranges[:, LOGS])
    ranges[:, ~free] = [[-np.inf], [np.inf]]
    return ranges[0], ranges[1]


PHYSICAL = NAMES[:8]
"""Parameters of the robot; the others are noises."""
FLOOR = 2e-3
"""Least relative half-width of an interval."""
LEAST_BLOCKS = 3
"""Fewest blocks before and after a change."""
APART = 2.0
"""Distance of values that differ, in sums of their half-widths."""
LEAST_TOLD = 1e-12
"""Information on a number that the log does not tell at all."""
WIDEST = 14.0
"""Largest half-width of a logarithm: from a millionth to a millionfold, all is undetermined."""


def errors_of(gradient: Floats, fisher: Floats, free: Mask) -> Floats:
    """Half-widths (n,) of 95 % intervals, from the larger of both standard errors.

    ``gradient`` (B, n) and ``fisher`` (B, n, n) are of blocks of time.  The second error is by one
    Newton step for each block b that is left out, theta_b = theta + (H - H_b)^-1 g_b.
    """
    by_fisher, left = np.zeros((2, len(free)))
    own, whole = fisher[:, free][:, :, free], _whole(fisher, free)
    by_fisher[free] = np.sqrt(np.maximum(np.diag(np.linalg.inv(whole)), 0))
    if (told := own.any(axis=(1, 2))).any():
        ridge = 1e-9 * np.diag(np.maximum(np.diag(whole), LEAST_TOLD))
        moved = np.linalg.solve(whole + ridge - own[told], gradient[told][:, free, None])
        left[free] = np.sqrt((told.sum() - 1) * moved.var(axis=0)[:, 0])
    return np.maximum(stdtrit(len(fisher) - 1, 0.975) * left, 1.96 * by_fisher)


def _whole(fisher: Floats, free: Mask) -> Floats:
    """Total information on the free parameters, with a small ridge on its diagonal.

    Without the ridge, rounding would move parameters that a log cannot separate by more than their
    intervals.
    """
    whole = fisher.sum(axis=0)[np.ix_(free, free)]
    return np.asarray(whole + 1e-10 * np.diag(np.maximum(np.diag(whole), LEAST_TOLD)))


class Fitted(NamedTuple):
    """Parameters (n,), mask of free ones, and per block of time gradient (B, n) and information."""

    theta: Floats
    free: Mask
    gradient: Floats
    fisher: Floats

    def of(self, part: slice) -> tuple[Floats, Floats]:
        """Parameters and half-widths (n,) from some blocks, by one Newton step; LinAlgError if
        these blocks do not determine a parameter.
        """
        free, gradient, fisher = self.free, self.gradient[part], self.fisher[part]
        step = np.zeros(len(free))
        step[free] = -np.linalg.solve(_whole(fisher, free), gradient.sum(axis=0)[free])
        return self.theta + step, errors_of(gradient + fisher @ step, fisher, free)


class Change(NamedTuple):
    """A parameter's values before and after a time [s], with their half-widths."""

    time: float
    values: Pair
    halves: Pair


def changes(fit: Fitted, names: Sequence[str], log: Samples | AxisLog) -> dict[str, Change]:
    """Parameters among ``names`` that changed during the log, each at the time that shows it best.

    All except delays are logarithms.  The log is split at the ends of blocks; the values of both
    parts differ by APART times both half-widths, and by a relevant amount: a twentieth, or a
    control period.
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
    """Half-widths (n,) of 95 % intervals: the largest of both errors and of the lower limit."""
    return np.maximum(errors_of(fit.last.gradient, fit.last.fisher, fit.inside), fit.least)


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
    """Plant step [s]: an integer fraction of a control period, at most one millisecond."""
    return period / math.ceil(period / 1e-3 - 1e-9)
