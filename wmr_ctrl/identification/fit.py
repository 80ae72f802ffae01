"""Maximum likelihood of a log: starts, Fisher scoring, intervals by leaving out blocks of time."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy.stats import t as student

from wmr_ctrl.identification.graph import LOGARITHMIC
from wmr_ctrl.identification.reading import (
    BLOCKS,
    COUNTED,
    SKIPPED,
    WATCHED,
    CompiledFilter,
    Events,
    Floats,
    PassResult,
    Samples,
    events_of,
)

SKIPPED_TIME = 0.3
"""Time at the start of each stretch that does not count [s]: commands before are not known."""
DELAY_MOST, LAG_LEAST, LAG_MOST = 0.6, 5e-4, 2.0
PASSES = 40
ENOUGH = 2e-3
"""Gain in log-likelihood below which scoring ends: 6 % of a standard error."""
DAMPING = 1e-3
"""Of the first step, and at least after a step that gained nothing."""
ACCEPTED = 1.92
"""Fall of the log-likelihood at the end of an interval by the likelihood."""
FLOOR = 2e-3
"""Least relative half-width of an interval."""
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
    boost: Floats | None = None

    def events(self, theta: Floats) -> Events:
        """Events for these parameters' delay."""
        kinds, blocks = self.counting()
        delay = theta[self.filter.graph.names.index("delay")]
        args = self.log, delay, self._starts(), self.filter.wide
        return events_of(*args, self.boost, kinds, blocks)

    def read(self, theta: Floats, slopes: bool = True) -> PassResult:
        """A pass through the filter."""
        parameters = np.concatenate((theta, self.known))
        return self.filter(self.events(theta), parameters, self._covariance(), slopes)

    def foretold(self, log: Samples, theta: Floats, start: Floats) -> Floats:
        """Means (N, state) that follow from those (F, state) at the start of each stretch alone."""
        kinds = np.full(len(log.t), WATCHED, np.int32)
        delay = theta[self.filter.graph.names.index("delay")]
        events = events_of(log, delay, start, self.filter.wide, None, kinds)
        parameters = np.concatenate((theta, self.known))
        return self.filter(events, parameters, self._covariance(), slopes=False).mean

    def counted(self) -> int:
        """Number of measurements that count."""
        return int((self.counting()[0] == COUNTED).sum())

    def counting(self) -> tuple[np.ndarray, np.ndarray]:
        """Kinds and blocks (N,) of the measurements."""
        t, first = self.log.t, self.log.first
        since = t - t[first][np.searchsorted(first, np.arange(len(t)), "right") - 1]
        kinds = np.where(since > SKIPPED_TIME, COUNTED, SKIPPED).astype(np.int32)
        span = max(t[-1] - t[0], 1e-9)
        return kinds, np.minimum((t - t[0]) / span * BLOCKS, BLOCKS - 1).astype(np.int32)

    def _starts(self) -> Floats:
        log, first = self.log, self.log.first
        start = np.zeros((len(first), self.filter.graph.state))
        if log.of_speed:
            start[:, 2:4] = log.seen[first]
        else:
            start[:, :2] = log.seen[first]
            later = np.minimum(first + 5, len(log.t) - 1)
            span = np.maximum(log.t[later] - log.t[first], 1e-6)
            start[:, 2:4] = (log.seen[later] - log.seen[first]) / span[:, None]
        sent = np.searchsorted(log.command_t, log.t[first], "right") - 1
        start[:, 6:8] = log.command[np.maximum(sent, 0)]
        return start

    def _covariance(self) -> Floats:
        """Of a stretch's start: what is seen to its variance, all else hardly known; packed."""
        way = np.full(2, 1.0) if self.log.of_speed else self.log.variance
        return packed(np.concatenate((way, [0.25, 1.0, 0.0, 0.0])))


def packed(diagonal: Floats) -> Floats:
    """A diagonal matrix as its upper triangle, row after row."""
    size = len(diagonal)
    rows, columns = np.triu_indices(size)
    return np.where(rows == columns, diagonal[rows], 0.0)


@dataclass(frozen=True)
class Fit:
    """A maximum of the likelihood: parameters as searched (n,), which are free, the last pass.

    ``least``: by place, half-widths that no interval goes below.
    """

    problem: LogProblem
    theta: Floats
    free: np.ndarray
    last: PassResult
    least: Mapping[int, float] = field(default_factory=dict)

    @property
    def nll(self) -> float:
        """Minus the log of the likelihood, less a constant."""
        return float(self.last.nll.sum())

    @property
    def inside(self) -> np.ndarray:
        """Which are free (n,), less noises at an end, whose slopes would move the others."""
        least, most = ends(self.problem, self.free)
        names = self.problem.filter.graph.names
        noise = np.array([name[0] in "qsn" or name == "time" for name in names])
        return self.free & ~(noise & ((self.theta <= least) | (self.theta >= most)))

    def information(self) -> Floats:
        """Fisher information of the free parameters."""
        return self.last.fisher.sum(axis=0)[np.ix_(self.free, self.free)]


def scored(
    problem: LogProblem,
    theta: Floats,
    free: np.ndarray,
    passes: int = PASSES,
    tell: Callable[[], None] = lambda: None,
    enough: float = ENOUGH,
) -> Fit:
    """Fisher scoring from ``theta``, damped until each step lowers minus the log-likelihood.

    It ends after ``passes`` steps, or where a step gains less than ``enough``, or promises a tenth.  The damping is
    Nielsen's: as much as the last step's gain was below what was promised.
    """
    least, most = ends(problem, free)
    theta = np.clip(theta, least, most)
    result, damping, growth = problem.read(theta), DAMPING, 2.0
    for _ in range(passes):
        tell()
        gradient = result.gradient.sum(axis=0)
        # What lies at an end and would go beyond stays there, so that the others move as they are.
        held = ((theta <= least) & (gradient > 0)) | ((theta >= most) & (gradient < 0))
        moving = free & ~held
        fisher = result.fisher.sum(axis=0)[np.ix_(moving, moving)]
        scale = np.diag(fisher) + 1e-12
        better = False
        for _ in range(12):
            step = -np.linalg.solve(fisher + damping * np.diag(scale), gradient[moving])
            step = np.clip(step, -1.5, 1.5) if np.abs(step).max() > 50 else step
            trial = theta.copy()
            trial[moving] += step
            trial = np.clip(trusted(trial, theta, problem), least, most)
            step = trial[moving] - theta[moving]
            promised = -float(gradient[moving] @ step + step @ fisher @ step / 2)
            if 0 <= promised < enough / 10:
                break
            after = problem.read(trial)
            gained = float(result.nll.sum() - after.nll.sum())
            if gained >= 0:
                better, share = True, gained / max(promised, 1e-300)
                damping = max(damping * max(1 / 3, 1 - (2 * min(share, 2.0) - 1) ** 3), 1e-9)
                growth = 2.0
                break
            damping, growth = max(damping * growth, DAMPING), 2 * growth
        if not better:
            break
        theta, result = trial, after
        if gained < enough:
            break
    return Fit(problem, theta, free, result)


def ends(problem: LogProblem, free: np.ndarray) -> tuple[Floats, Floats]:
    """Least and largest (n,) of what is searched: no model is truer than FINEST of what it moves.

    Integration, rounding and effects without a name are in the cleanest of logs.
    """
    log, names = problem.log, problem.filter.graph.names
    r, half_track = problem.known[:2]
    right, left = log.command.T
    force = np.std([right + left, half_track * (right - left)], axis=1) / r
    speed = np.std(log.seen, axis=0) if log.of_speed else np.ones(2)
    noise = np.log(np.maximum(FINEST * np.concatenate((force, speed)), 1e-9)).tolist()
    least = dict(zip(("q1", "q2", "n1", "n2"), noise, strict=True))
    least |= {"s1": math.log(1e-7), "s2": math.log(1e-7), "time": math.log(0.02)}
    least |= {"delay": 0.0, "lag": LAG_LEAST}
    most = dict.fromkeys(("q1", "q2", "s1", "s2"), math.log(1e6))
    most |= {"time": math.log(60.0), "delay": DELAY_MOST, "lag": LAG_MOST}
    low, high = (
        np.where(free, [side.get(name, other) for name in names], other)
        for side, other in ((least, -np.inf), (most, np.inf))
    )
    return low, high


def trusted(trial: Floats, before: Floats, problem: LogProblem) -> Floats:
    """Logarithms no further from ``before`` than scoring can be trusted."""
    near = np.array([name in LOGARITHMIC for name in problem.filter.graph.names])
    near &= np.isfinite(before)
    new = trial.copy()
    new[near] = np.clip(trial[near], before[near] - 1.5, before[near] + 1.5)
    return new


def standard_errors(fit: Fit) -> tuple[Floats, Floats]:
    """Standard errors (n,) by the Fisher information, and by leaving out blocks of time.

    Zero where a parameter is not free.
    """
    return _two_errors(fit.last.gradient, fit.last.fisher, fit.inside)


def _two_errors(gradient: Floats, fisher: Floats, free: np.ndarray) -> tuple[Floats, Floats]:
    """Both errors from gradient (B, n) and information (B, n, n) of blocks of time.

    The second is by one Newton step for each block b that is left out, theta_b = theta + (H -
    H_b)^-1 g_b.
    """
    whole = fisher.sum(axis=0)[np.ix_(free, free)]
    tiny = 1e-10 * np.diag(np.diag(whole))
    by_fisher, left = np.zeros(len(free)), np.zeros(len(free))
    by_fisher[free] = np.sqrt(np.maximum(np.diag(np.linalg.inv(whole + tiny)), 0))
    moved = []
    for block in range(BLOCKS):
        own = fisher[block][np.ix_(free, free)]
        if not own.any():
            continue
        lacking = whole + tiny - own + 1e-9 * np.diag(np.diag(whole))
        moved.append(np.linalg.solve(lacking, gradient[block][free]))
    count = len(moved)
    spread = np.array(moved) - np.mean(moved, axis=0)
    left[free] = np.sqrt((count - 1) / count * (spread**2).sum(axis=0))
    return by_fisher, left


def errors_of(gradient: Floats, fisher: Floats, free: np.ndarray) -> Floats:
    """Half-widths (n,) of 95 % intervals: the larger of both errors'."""
    by_fisher, left = _two_errors(gradient, fisher, free)
    return np.maximum(student.ppf(0.975, BLOCKS - 1) * left, 1.96 * by_fisher)


def half_widths(fit: Fit) -> Floats:
    """Half-widths (n,) of 95 % intervals: the larger of both errors', and of the floor."""
    half = errors_of(fit.last.gradient, fit.last.fisher, fit.inside)
    for place, least in fit.least.items():
        half[place] = max(half[place], least)
    return half


def first_guess(log: Samples) -> tuple[dict[str, float], float]:
    """m, I, friction of motion and time from command to force [s], by regression.

    Second differences of way and turn over 0.1 s weigh the force by a triangle; of the shifts of
    the command the one that explains most is taken.
    """
    T = log.period
    t = np.arange(log.t[0], log.t[-1], T)
    way = np.column_stack([np.interp(t, log.t, log.seen[:, k]) for k in (0, 1)])
    if log.of_speed:
        way = np.cumsum(way, axis=0) * T
    w = max(round(0.1 / T), 3)
    rate = (way[2 * w :] - 2 * way[w:-w] + way[: -2 * w]) / (w * T) ** 2
    speed = (way[2 * w :] - way[: -2 * w]) / (2 * w * T)
    kernel = np.convolve(np.ones(w), np.ones(w)) / w**2
    gap = np.searchsorted(log.t, t)
    near = np.abs(log.t[np.minimum(gap, len(log.t) - 1)] - t) < 5 * T
    best: tuple[float, float, Floats] | None = None
    for shift in np.arange(0.0, 0.5, max(T, 0.01)):
        index = np.maximum(np.searchsorted(log.command_t, t - shift + 1e-9, "right") - 1, 0)
        force = np.column_stack(
            [np.convolve(log.command[index, k], kernel, "same")[w:-w] for k in (0, 1)]
        )
        ok = near[w:-w]
        solved, rest = [], 0.0
        for axis in (0, 1):
            x = np.column_stack((force[:, axis], np.tanh(speed[:, axis] / 0.02), speed[:, axis]))
            solution, _, _, _ = np.linalg.lstsq(x[ok], rate[ok, axis], rcond=None)
            error = rate[ok, axis] - x[ok] @ solution
            rest += float(np.sum(error**2) / max(np.sum(rate[ok, axis] ** 2), 1e-12))
            solved.append(solution)
        if best is None or rest < best[0]:
            best = rest, float(shift), np.array(solved)
    assert best is not None
    _, shift, fits = best
    m, inertia = (1 / max(item, 1e-3) for item in fits[:, 0])
    return {
        "m": m,
        "I": inertia,
        "Fc": max(-fits[0, 1] * m, 0.0),
        "Fv": max(-fits[0, 2] * m, 0.0),
        "Mv": max(-fits[1, 2] * inertia, 0.0),
        "c": 0.0,
    }, shift


def searched(values: dict[str, float], names: tuple[str, ...]) -> Floats:
    """Parameters in the order and form of the search."""
    with np.errstate(divide="ignore"):
        return np.array([np.log(values[n]) if n in LOGARITHMIC else values[n] for n in names])
