"""Likeliest speed loop of one axis of a base: an output-error fit of each kind.

What is left over is an autoregressive process, by whose inverse residuals and slopes are whitened;
the loop is chosen by the criterion of Schwarz.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from wmr_ctrl.identification.axis import AxisLog, foretold, shifted_gain
from wmr_ctrl.identification.fit import ACCEPTED, DELAY_MOST, FINEST, FLOOR, errors_of
from wmr_ctrl.identification.reading import BLOCKS, Floats

LOOPS: Mapping[str, tuple[str, ...]] = {
    "first-order": ("gain", "tau", "delay"),
    "pi": ("wn", "zeta", "delay"),
    "second-order": ("gain", "wn", "zeta", "delay"),
}
"""Parameters of each loop; all but the delay are searched as logarithms."""
PLACE = {"gain": 0, "tau": 1, "wn": 1, "zeta": 2, "accel": 3, "delay": 4}
"""Columns of a set of parameters."""
ORDER = 6
"""Order of the autoregression."""
SPEEDS = (0.03, 0.1, 0.3)
"""Time constants that fits are started from [s]."""
DAMPINGS = (0.35, 1.0)
RANGES = {"gain": (0.02, 50.0), "tau": (5e-3, 20.0), "wn": (0.05, 60.0), "zeta": (0.02, 2.0),
          "accel": (0.01, 1e3)}  # fmt: skip
GAIN_OF_BIC = 4.0
SCREENED = 12
PASSES = 30
ENOUGH = 0.01
MOST_VAGUE = 0.5
"""Half-width of a logarithm from which on a number is no reason for a richer loop."""
SCREEN_SECONDS = 30.0
SMOOTHED = 0.1
"""Time over which deviations are averaged before the largest counts as a push [s]: shorter ones
are the sensors'."""
AT_ONCE = 16
"""Sets of parameters that are followed at once through a whole log."""


@dataclass(frozen=True)
class LoopFit:
    """A fit of one loop: its parameters as searched by ``names``, and what they leave over.

    ``gradient`` (B, n) and ``fisher`` (B, n, n) of minus the log of the likelihood, by blocks of
    time; ``left`` (N,): speed less what was foretold.
    """

    log: AxisLog
    loop: str
    names: tuple[str, ...]
    theta: Floats
    left: Floats
    nll: float
    gradient: Floats = field(repr=False)
    fisher: Floats = field(repr=False)

    @property
    def bic(self) -> float:
        """The criterion of Schwarz."""
        return 2 * self.nll + len(self.theta) * math.log(max(int(self.log.counted.sum()), 2))

    @property
    def values(self) -> dict[str, float]:
        """Parameters in SI units."""
        return {
            name: float(x if name == "delay" else math.exp(x))
            for name, x in zip(self.names, self.theta, strict=True)
        }

    @property
    def vague(self) -> bool:
        """True where a number of the loop or its limit is hardly told: the loop has too many."""
        half = self.half_widths(0.0)
        return any(h > MOST_VAGUE for n, h in zip(self.names, half, strict=True) if n != "delay")

    def deviation(self) -> Floats:
        """Speed less what was foretold (N,), averaged over SMOOTHED; 0 where nothing counts."""
        wide = max(round(SMOOTHED / self.log.period), 1)
        left = np.where(self.log.counted, self.left, 0.0)
        return np.convolve(left, np.ones(wide) / wide, "same")

    def standard_errors(self) -> Floats:
        """Standard errors (n,) of what is searched, by the Fisher information."""
        return np.sqrt(np.diag(np.linalg.pinv(self.fisher.sum(axis=0))))

    def half_widths(self, least_delay: float) -> Floats:
        """Half-widths (n,) of 95 % intervals of what is searched."""
        shown = np.diag(self.fisher.sum(axis=0)) > 0
        floor = [least_delay if name == "delay" else FLOOR for name in self.names]
        half = np.maximum(errors_of(self.gradient, self.fisher, shown), floor)
        return np.where(shown, half, np.inf)


def _set(names: tuple[str, ...], theta: Floats) -> Floats:
    by = {n: x if n == "delay" else math.exp(x) for n, x in zip(names, theta, strict=True)}
    loop = (by["tau"], 1.0) if "tau" in by else (by["wn"], by["zeta"])
    return np.array([by.get("gain", 1.0), *loop, by.get("accel", math.inf), by["delay"]])


def _bounded(names: tuple[str, ...], theta: Floats) -> Floats:
    ends = [(0.0, DELAY_MOST) if n == "delay" else tuple(np.log(RANGES[n])) for n in names]
    return np.clip(theta, *np.array(ends).T)


def _whitener(
    left: Floats, counted: np.ndarray, order: int = ORDER
) -> tuple[Callable[[Floats], Floats], np.ndarray]:
    """Filter that whitens what is left, and which samples it is whole for."""
    if not order:
        return lambda x: x, counted
    behind = np.column_stack([np.roll(left, k) for k in range(1, order + 1)])
    whole = counted & np.all([np.roll(counted, k) for k in range(1, order + 1)], axis=0)
    whole[:order] = False
    near = behind[whole]
    a = np.linalg.lstsq(near.T @ near, near.T @ left[whole], rcond=None)[0]

    def whiten(x: Floats) -> Floats:
        return np.asarray(x - sum(a[k] * np.roll(x, k + 1, axis=0) for k in range(order)))

    return whiten, whole


def finest(log: AxisLog) -> float:
    """Least noise of an axis [m/s or rad/s]: no model is truer."""
    return FINEST * max(float(np.std(log.speed)), 1e-9)


def fitted(
    log: AxisLog,
    loop: str,
    names: tuple[str, ...],
    theta: Floats,
    passes: int,
    plain: int = 0,
) -> LoopFit:
    """Scoring from ``theta``, damped until each step lowers minus the log-likelihood.

    The first ``plain`` passes are least squares of what is left itself, which lead from farther.
    """
    damping, done = 1e-3, False
    edges = np.linspace(log.t[0], log.t[-1] + 1e-9, BLOCKS + 1)
    block = np.searchsorted(edges, log.t, "right") - 1

    def deviation(many: list[Floats]) -> Floats:
        return log.speed[:, None] - foretold(log, loop, np.array([_set(names, x) for x in many]))

    theta = _bounded(names, theta)
    for turn in range(passes):
        steps = np.diag([1e-4 if name == "delay" else 1e-3 for name in names])
        inside = [np.where(theta + s > _bounded(names, theta + s), -1, 1) for s in steps]
        apart = deviation([theta, *(theta + s * w for s, w in zip(steps, inside, strict=True))])
        left = apart[:, 0]
        slope = np.column_stack([
            (apart[:, k + 1] - left) / (steps[k, k] * inside[k][k]) for k in range(len(theta))
        ])  # fmt: skip
        whiten, whole = _whitener(left, log.counted, ORDER if turn >= plain else 0)
        white, along = whiten(left)[whole], whiten(slope)[whole]
        sigma = math.hypot(float(np.std(white)), finest(log))
        nll = whole.sum() * math.log(sigma)
        place = block[whole]
        gradient = np.array([
            along[place == b].T @ white[place == b] / sigma**2 for b in range(BLOCKS)
        ])  # fmt: skip
        fisher = np.array([
            along[place == b].T @ along[place == b] / sigma**2 for b in range(BLOCKS)
        ])  # fmt: skip
        result = LoopFit(log, loop, names, theta, left, nll, gradient, fisher)
        if done or turn == passes - 1:
            break
        total, pull = fisher.sum(axis=0), gradient.sum(axis=0)
        scale = np.diag(np.diag(total) + 1e-12)
        tried = [
            _bounded(names, theta + np.clip(np.linalg.solve(total + d * scale, -pull), -1, 1))
            for d in (size * damping for size in (0.01, 1, 1e3))
        ]
        squares = [float(np.sum(whiten(item)[whole] ** 2)) for item in deviation(tried).T]
        best = int(np.argmin(squares))
        gained = (float(np.sum(white**2)) - squares[best]) / (2 * sigma**2)
        if not gained > 0:
            if turn >= plain:
                break
            plain = turn
            continue
        theta, damping = tried[best], min(max(damping * (0.01, 1.0, 1e3)[best], 1e-8), 1e6)
        done = turn >= plain and gained < ENOUGH
    return result


def best_loop(
    log: AxisLog, tell: Callable[[], None], loops: tuple[str, ...] = tuple(LOOPS)
) -> LoopFit:
    """The likeliest loop by the criterion of Schwarz, with a ramp where it earns one.

    All are tried on the first part of the log, the best three on all of it; a simpler one stays
    unless a richer one gains by more than chance and its numbers are told.
    """
    part, tried = log.until(log.t[0] + SCREEN_SECONDS), []
    wide = max(round(0.1 / log.period), 1)
    slopes = np.abs(log.speed[wide:] - log.speed[:-wide])[log.counted[wide:]] / (wide * log.period)
    steepest = max(float(np.quantile(slopes, 0.98)), 0.02)
    for ramp, loop in product((False, True), loops):
        names = LOOPS[loop] + (("accel",) if ramp else ())
        starts = _starts(log, names, steepest)
        speeds = foretold(part, loop, np.array([_set(names, x) for x in starts]))
        squares = np.sum((speeds - part.speed[:, None])[part.counted] ** 2, axis=0)
        near = [starts[k] for k in np.argsort(squares)[:2]]
        fits = [fitted(part, loop, names, x, SCREENED, SCREENED - 4) for x in near]
        tried.append(min(fits, key=lambda item: item.nll))
        tell()
    best: LoopFit | None = None
    few = sorted(tried, key=lambda item: (item.vague, item.bic))[:3]
    for item in sorted(few, key=lambda item: len(item.theta)):
        fit = fitted(log, item.loop, item.names, item.theta, PASSES)
        tell()
        if best is not None and fit.vague:
            continue
        if best is None or fit.bic < best.bic - GAIN_OF_BIC:
            best = fit
    assert best is not None
    return best


def same_loop(
    axes: list[AxisLog], driven: list[bool], tell: Callable[[], None]
) -> tuple[LoopFit | None, LoopFit | None]:
    """Fits of both axes by one kind of loop: where they differ the one likelier for both."""
    first, second = (
        best_loop(axis, tell) if moves else None for axis, moves in zip(axes, driven, strict=True)
    )
    if first is None or second is None or first.loop == second.loop:
        return first, second
    others = (
        (first, best_loop(axes[1], tell, (first.loop,))),
        (best_loop(axes[0], tell, (second.loop,)), second),
    )
    return min(others, key=lambda pair: pair[0].bic + pair[1].bic)


def _starts(log: AxisLog, names: tuple[str, ...], steepest: float) -> list[Floats]:
    gain = max(shifted_gain(log)[0], RANGES["gain"][0])
    grid = {
        "gain": (gain, 1.25 * gain) if "accel" in names else (gain,),
        "tau": SPEEDS, "wn": tuple(1 / x for x in SPEEDS), "zeta": DAMPINGS,
        "delay": (0.01, 0.06, 0.15), "accel": (0.7 * steepest, 1.1 * steepest, 2 * steepest),
    }  # fmt: skip
    return [
        np.array([x if n == "delay" else math.log(x) for n, x in zip(names, values, strict=True)])
        for values in product(*(grid[name] for name in names))
    ]


def least_acceleration(fit: LoopFit) -> float:
    """Lower end of the limit's interval where no ramp shows [m/s2 or rad/s2]: by the likelihood."""
    limits = np.geomspace(*RANGES["accel"], 60)
    fall = -likelihoods(fit, {"accel": limits})
    fine = np.flatnonzero(fall > ACCEPTED)
    return float(limits[min(fine[-1] + 1, len(limits) - 1)]) if fine.size else float(limits[0])


def likelihoods(fit: LoopFit, changes: Mapping[str, Floats]) -> Floats:
    """Log-likelihoods (K,) less that of the fit, of parameters that take other values (K,).

    Parameters are in SI units; what is left over is whitened as that of the fit is.
    """
    whiten, whole = _whitener(fit.left, fit.log.counted)
    now = max(float(np.mean(whiten(fit.left)[whole] ** 2)), finest(fit.log) ** 2)
    count = len(next(iter(changes.values())))
    falls = []
    for part in np.array_split(np.arange(count), math.ceil(count / AT_ONCE)):
        sets = np.tile(_set(fit.names, fit.theta), (len(part), 1))
        for name, values in changes.items():
            sets[:, PLACE[name]] = values[part]
        left = whiten(fit.log.speed[:, None] - foretold(fit.log, fit.loop, sets))[whole]
        falls.append((np.mean(left**2, axis=0) / now - 1) * whole.sum() / 2)
    return -np.concatenate(falls)


def followed_by(log: AxisLog, loop: str, values: Mapping[str, Floats]) -> Floats:
    """Speeds (N, K) that follow from a log's commands for parameters (K,) in SI units."""
    sets = np.tile([1.0, 1.0, 1.0, math.inf, 0.0], (len(next(iter(values.values()))), 1))
    for name, column in values.items():
        sets[:, PLACE[name]] = column
    return foretold(log, loop, sets)


def information_of(fit: LoopFit, log: AxisLog) -> Floats:
    """Fisher information (n, n) that another log would have of what was fitted, in this noise."""
    whiten, whole = _whitener(fit.left, fit.log.counted)
    sigma = math.hypot(float(np.std(whiten(fit.left)[whole])), finest(fit.log))
    steps = np.diag([1e-4 if name == "delay" else 1e-3 for name in fit.names])
    sets = np.array([_set(fit.names, fit.theta + s) for s in (0 * steps[0], *steps)])
    apart = foretold(log, fit.loop, sets)
    slope = whiten((apart[:, 1:] - apart[:, :1]) / np.diag(steps))[ORDER:] / sigma
    return np.asarray(slope.T @ slope)


def forecast(fit: LoopFit, log: AxisLog) -> Floats:
    """Speeds (N,) that a fit foretells on another log, from its commands alone."""
    return foretold(log, fit.loop, np.array([_set(fit.names, fit.theta)]))[:, 0]
