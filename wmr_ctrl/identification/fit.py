"""Maximum likelihood of a log: its events in order, Fisher scoring."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

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
from .logs.log import Floats, Mask
from .logs.samples import LONGEST_DELAY, Samples, forces

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

    def read(self, theta: Floats, slopes: bool = True) -> PassResult:
        """A pass through the filter."""
        kinds, blocks = self.counting()
        return self.filter(
            self.log, self._starts(), *self._given(theta), slopes=slopes, boost=self.boost,
            kinds=kinds, blocks=blocks,
        )  # fmt: skip

    def foretold(self, log: Samples, theta: Floats, start: Floats) -> Floats:
        """Means (N, state) that follow from those (F, state) at the start of each stretch alone."""
        return self.filter(log, start, *self._given(theta), slopes=False, kinds=WATCHED).mean

    def measurement_count(self) -> int:
        """Number of measurements that count."""
        return int((self.counting()[0] == COUNTED).sum())

    def counting(self) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Kinds and blocks (N,) of the measurements."""
        kinds = np.where(self.log.since > SKIPPED_TIME, COUNTED, SKIPPED).astype(np.int32)
        return kinds, blocks_of(self.log.t)

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
    tell: Tell = lambda: None,
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
