"""Maximum likelihood of a log: its events in order, Fisher scoring."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .kalman import (
    BLOCKS,
    INDEX,
    LOGARITHMIC,
    MEAN,
    NAMES,
    PIECE,
    WIDE,
    CompiledFilter,
    Events,
    PassResult,
)
from .logs.log import Floats
from .logs.samples import LONGEST_DELAY, Samples

START, PIECE_KIND, SKIPPED, COUNTED, WATCHED = range(5)
LONGEST = 0.01
"""Longest piece that is stepped over at once [s]."""
SHORTEST = 1e-9
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


def events_of(
    log: Samples,
    delay: float,
    start: Floats,
    boost: Floats | None = None,
    kinds: NDArray[np.int32] | None = None,
    blocks: NDArray[np.int32] | None = None,
) -> Events:
    """Pieces between all times at which something is seen or a command begins to act, in order.

    ``start`` (F, state): means at the beginning of each stretch.  ``boost`` (N,): factor of the
    noise up to each sample; ``kinds`` (N,) and ``blocks`` (N,) of the measurements.
    """
    count, sent = len(log.t), len(log.command_t)
    base = np.concatenate((log.t, log.command_t))
    late = np.concatenate((np.zeros(count), np.ones(sent)))
    # Commands that begin to act as something is seen come after it.
    order = np.lexsort((late, base + late * delay))
    command = np.concatenate((np.full(count, -1), np.arange(sent)))[order]
    acting = np.maximum(np.maximum.accumulate(command), 0)
    seen = np.where(order < count, order, -1)
    before = np.maximum.accumulate(seen)
    inside = (before[:-1] >= 0) & (before[:-1] < count - 1)
    begins = np.zeros(count + 1, bool)
    begins[log.first] = True
    inside &= ~begins[np.minimum(before[:-1] + 1, count)]
    h0, h1 = np.diff(base[order]), np.diff(late[order])
    length = h0 + h1 * delay
    parts = np.where(inside & (length > SHORTEST), np.ceil(length / LONGEST), 0).astype(np.int64)
    # After each event: its pieces. Before them, if it is a measurement: that, and a start.
    starts = (seen >= 0) & begins[np.maximum(seen, 0)]
    own = np.where(seen >= 0, 1, 0) + starts
    size = own.copy()
    size[:-1] += parts
    place = np.concatenate(([0], np.cumsum(size)))
    rows = np.zeros((place[-1], WIDE))
    kind = np.full(place[-1], PIECE_KIND, np.int32)
    block = np.full(place[-1], -1, np.int32)
    piece = np.repeat(np.arange(len(parts)), parts)
    inner = np.concatenate([np.arange(0)] if not len(parts) else [_ranks(parts)])
    at = place[piece] + own[piece] + inner
    following = np.minimum(before[piece] + 1, count - 1)
    factor = np.ones(len(piece)) if boost is None else boost[following]
    rows[at, : len(PIECE)] = np.column_stack(
        (log.command[acting[piece]], h0[piece] / parts[piece], h1[piece] / parts[piece], factor)
    )
    spot = place[:-1][seen >= 0] + starts[seen >= 0]
    which = seen[seen >= 0]
    rows[spot, :5] = np.column_stack(
        (log.seen[which], np.tile(log.variance, (len(which), 1)), np.full(len(which), log.of_speed))
    )
    kind[spot] = COUNTED if kinds is None else kinds[which]
    block[spot] = 0 if blocks is None else blocks[which]
    where = place[:-1][starts]
    rows[where, : start.shape[1]] = start
    kind[where] = START
    return Events(rows, kind, block, count)


def _ranks(parts: NDArray[np.int64]) -> NDArray[np.int64]:
    """0 to n - 1 for each n of ``parts``, one after the other."""
    ends = np.cumsum(parts)
    return np.arange(ends[-1] if len(ends) else 0) - np.repeat(ends - parts, parts)


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
        return events_of(self.log, theta[INDEX["delay"]], self._starts(), self.boost, kinds, blocks)

    def read(self, theta: Floats, slopes: bool = True) -> PassResult:
        """A pass through the filter."""
        parameters = np.concatenate((theta, self.known))
        return self.filter(self.events(theta), parameters, self._covariance(), slopes)

    def foretold(self, log: Samples, theta: Floats, start: Floats) -> Floats:
        """Means (N, state) that follow from those (F, state) at the start of each stretch alone."""
        kinds = np.full(len(log.t), WATCHED, np.int32)
        events = events_of(log, theta[INDEX["delay"]], start, None, kinds)
        parameters = np.concatenate((theta, self.known))
        return self.filter(events, parameters, self._covariance(), slopes=False).mean

    def measurement_count(self) -> int:
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
        log, first, start = self.log, self.log.first, at_rest(self.log)
        if log.of_speed:
            start[:, 2:4] = log.seen[first]
        else:
            start[:, :2] = log.seen[first]
            later = np.minimum(first + 5, len(log.t) - 1)
            span = np.maximum(log.t[later] - log.t[first], 1e-6)
            start[:, 2:4] = (log.seen[later] - log.seen[first]) / span[:, None]
        return start

    def _covariance(self) -> Floats:
        """Packed covariance at a stretch's start: measured values with their variance, the rest
        hardly known.
        """
        way = np.full(2, 1.0) if self.log.of_speed else self.log.variance
        return packed(np.concatenate((way, [0.25, 1.0, 0.0, 0.0])))


def at_rest(log: Samples) -> Floats:
    """Means (F, MEAN) at the beginning of each stretch of a robot at rest: the torques alone."""
    start = np.zeros((len(log.first), MEAN))
    sent = np.searchsorted(log.command_t, log.t[log.first], "right") - 1
    start[:, 6:8] = log.command[np.maximum(sent, 0)]
    return start


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
        """Free parameters (n,) without noises at an end of their range, whose slopes would move the
        others.
        """
        least, most = ends(self.problem, self.free)
        noise = np.array([name[0] in "qsn" or name == "time" for name in NAMES])
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

    It ends after ``passes`` steps, or where a step gains less than ``enough`` or promises a tenth
    of that.  The damping is Nielsen's, by the share of what was promised that a step gained.
    Slopes take most of a pass: after a step that lowered nothing they are left out of trials, until
    one is taken at once.
    """
    least, most = ends(problem, free)
    theta = np.clip(theta, least, most)
    result, damping, growth = problem.read(theta), DAMPING, 2.0
    sloped = True
    for _ in range(passes):
        tell()
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
            trial = np.clip(trusted(trial, theta), least, most)
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


def ends(problem: LogProblem, free: np.ndarray) -> tuple[Floats, Floats]:
    """Least and largest (n,) of what is searched: no model is truer than FINEST of what it moves.

    Integration, rounding and effects without a name are in the cleanest of logs.
    """
    log = problem.log
    r, half_track = problem.known[:2]
    right, left = log.command.T
    force = np.std([right + left, half_track * (right - left)], axis=1) / r
    speed = np.std(log.seen, axis=0) if log.of_speed else np.ones(2)
    noise = np.log(np.maximum(FINEST * np.concatenate((force, speed)), 1e-9)).tolist()
    least = dict(zip(("q1", "q2", "n1", "n2"), noise, strict=True))
    least |= {"s1": math.log(1e-7), "s2": math.log(1e-7), "time": math.log(0.02)}
    least |= {"delay": 0.0, "lag": LAG_LEAST}
    most = dict.fromkeys(("q1", "q2", "s1", "s2"), math.log(1e6))
    most |= {"time": math.log(60.0), "delay": LONGEST_DELAY, "lag": LAG_MOST}
    low, high = (
        np.where(free, [side.get(name, other) for name in NAMES], other)
        for side, other in ((least, -np.inf), (most, np.inf))
    )
    return low, high


def trusted(trial: Floats, before: Floats) -> Floats:
    """Logarithms no further from ``before`` than scoring can be trusted."""
    near = np.array([name in LOGARITHMIC for name in NAMES])
    near &= np.isfinite(before)
    new = trial.copy()
    new[near] = np.clip(trial[near], before[near] - 1.5, before[near] + 1.5)
    return new
