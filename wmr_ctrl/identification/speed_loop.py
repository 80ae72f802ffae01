"""Speed loop of one axis of a base: the speeds that follow from its commands, and its fit to a log.

    command, late by a delay  ->  ramp  ->  loop  ->  speed
    first-order    tau v' = K u - v
    pi             v' = 2 zeta wn (u - v) + f,   f' = wn^2 (u - v)
    second-order   v'' = wn^2 (K u - v) - 2 zeta wn v'

The ramp is that of `world.command_ramp`.  What a fit leaves over is an autoregressive process, by
whose inverse residuals and slopes are whitened.
"""

from __future__ import annotations

import ctypes as ct
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache

import casadi as ca
import numpy as np

from wmr_ctrl.codegen.build import lanes_library
from wmr_ctrl.codegen.emit import kernel
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.world.command_ramp import moved
from wmr_ctrl.world.model.dynamics import rk4_step
from wmr_ctrl.world.model.system import System, port

from .fit import FINEST
from .kalman import BLOCKS
from .logs.log import Floats
from .logs.samples import LONGEST_DELAY, AxisLog
from .widths import FLOOR, errors_of

AXES = (1, 2)
STEP = 0.01
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
RANGES = {"gain": (0.02, 50.0), "tau": (5e-3, 20.0), "wn": (0.05, 60.0), "zeta": (0.02, 2.0),
          "accel": (0.01, 1e3)}  # fmt: skip
ENOUGH = 0.01
MOST_VAGUE = 0.5
"""Half-width of a logarithm from which on a number is no reason for a richer loop."""
SMOOTHED = 0.1
"""Time over which deviations are averaged before the largest counts as a push [s]: shorter ones
are the sensors'."""
AT_ONCE = 16
"""Sets of parameters that are followed at once through a whole log."""


@cache
def _follower(loop: str) -> ct._NamedFuncPointer:
    """Compiled steps of (ramped, v, second state), for many sets of parameters."""
    u, v, inner, p = (
        port(Signal(name, "1", name, size))
        for name, size in (("u", 1), ("v", 1), ("inner", 1), ("p", 3))
    )
    gain, first, second = p.sym[0], p.sym[1], p.sym[2]
    a, b = 2 * second * first, first**2
    rate = {
        "first-order": ca.vertcat((gain * u.sym - v.sym) / first, 0),
        "pi": ca.vertcat(a * (u.sym - v.sym) + inner.sym, b * (u.sym - v.sym)),
        "second-order": ca.vertcat(inner.sym, b * (gain * u.sym - v.sym) - a * inner.sym),
    }[loop]
    system = System("loop", loop, inputs=(u,), state=(v, inner), params=(p,), update=rate)
    x, h, numbers, sent = (ca.SX.sym(*item) for item in (("x", 3), ("h",), ("p", 4), ("sent", 3)))
    parts = h * sent[2] * numbers[3], h * (1 - sent[2]) * numbers[3]
    middle = _ramped(x[0], sent[0], parts[0])
    ramped = ca.if_else(sent[2] < 1, _ramped(middle, sent[1], parts[1]), middle)
    # A ramp that ends within its part of the piece rests at the end: the exact mean of both.
    first_mean, last_mean = (
        b - (b - a) * ca.fabs(b - a) / (2 * ca.fmax(most, 1e-30))
        for a, b, most in ((x[0], middle, parts[0]), (middle, ramped, parts[1]))
    )
    acting = sent[2] * first_mean + (1 - sent[2]) * ca.if_else(sent[2] < 1, last_mean, 0)
    after = ca.substitute(
        rk4_step(system, h),
        ca.vertcat(u.sym, system.x, system.p),
        ca.vertcat(acting, x[1:], numbers[:3]),
    )
    step = kernel(
        "step",
        "State after a piece of time in which two commands act, one after the other.",
        {"x": x, "sent": sent, "h": h, "p": numbers},
        {"next": ca.vertcat(ramped, after)},
    )
    sizes = {"STATE": 3, "SENT": 3, "NUMBERS": 4, "SPEED": 1}
    return ct.CDLL(str(lanes_library("follow_loop.c", sizes, [step]))).wmr_follow_loop


def _ramped(now: ca.SX, wanted: ca.SX, most: ca.SX) -> ca.SX:
    """The command after a piece: a ramp rests at 0 until its step ends, and pieces are no steps."""
    stopped = moved(now, wanted, most, most)
    left = ca.fmax(most - ca.fabs(stopped - now), 0)
    return ca.if_else(stopped == wanted, stopped, moved(stopped, wanted, left, left))


def foretold(log: AxisLog, loop: str, sets: Floats) -> Floats:
    """Speeds (N, P) that follow from the commands alone, for parameters (P, 5).

    A set is gain, two numbers of the loop (tau, or wn and zeta), acceleration limit, delay.
    """
    count = len(sets)
    gap = np.diff(log.t, prepend=log.t[0])
    gap[log.first] = 0.0
    parts = np.maximum(np.ceil(gap / STEP - 1e-9), 1).astype(int)
    parts[log.first] = 0
    ends = np.cumsum(parts)
    piece = np.repeat(np.arange(len(parts)), parts)
    h = gap[piece] / parts[piece]
    begin = log.t[piece] - h * (ends[piece] - np.arange(len(piece)))
    delays, late = np.unique(sets[:, 4], return_inverse=True)
    command = np.ascontiguousarray(log.commands(begin, h, delays).swapaxes(0, 1))
    late, numbers = late.astype(np.int32), np.ascontiguousarray(sets[:, :4].T)
    result = np.empty((len(log.t), count))
    for low, high in zip(log.first, [*log.first[1:], len(log.t)], strict=True):
        first, last = ends[low], ends[high - 1]
        begun = log.speed[min(low + 1, high - 1)]
        x = np.stack((begun / sets[:, 0], np.full(count, begun), np.zeros(count)))
        path = np.empty((last - first + 1, count))
        path[0] = begun
        arrays = (h[first:], command[first:], late, numbers, x, path[1:])
        _follower(loop)(
            *map(ct.c_int64, (last - first, count, len(delays))),
            *(ct.c_void_p(item.ctypes.data) for item in arrays),
        )
        place = ends[low:high] - first
        if log.of_way:
            mean = (path[1:] + path[:-1]) / 2 * h[first:last, None]
            way = np.concatenate((np.zeros((1, count)), np.cumsum(mean, axis=0)))[place]
            result[low:high] = np.diff(way, axis=0, prepend=way[:1]) / np.maximum(
                gap[low:high, None], 1e-9
            )
        else:
            result[low:high] = path[place]
    return result


@dataclass(frozen=True)
class LoopFit:
    """A fit of one loop: its parameters as searched by ``names``, and its residuals.

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
        return 2 * self.nll + len(self.theta) * math.log(max(int(self.log.in_fit.sum()), 2))

    @property
    def values(self) -> dict[str, float]:
        """Parameters in SI units."""
        return {
            name: float(x if name == "delay" else math.exp(x))
            for name, x in zip(self.names, self.theta, strict=True)
        }

    @property
    def vague(self) -> bool:
        """True where a number of the loop or its limit is hardly determined: there are too many."""
        half = self.half_widths(0.0)
        return any(h > MOST_VAGUE for n, h in zip(self.names, half, strict=True) if n != "delay")

    def deviation(self) -> Floats:
        """Speed less its forecast (N,), averaged over SMOOTHED; 0 where nothing counts."""
        wide = max(round(SMOOTHED / self.log.period), 1)
        left = np.where(self.log.in_fit, self.left, 0.0)
        return np.convolve(left, np.ones(wide) / wide, "same")

    def standard_errors(self) -> Floats:
        """Standard errors (n,) of the searched parameters, by the Fisher information."""
        return np.sqrt(np.diag(np.linalg.pinv(self.fisher.sum(axis=0))))

    def half_widths(self, least_delay: float) -> Floats:
        """Half-widths (n,) of 95 % intervals of the searched parameters."""
        shown = np.diag(self.fisher.sum(axis=0)) > 0
        floor = [least_delay if name == "delay" else FLOOR for name in self.names]
        half = np.maximum(errors_of(self.gradient, self.fisher, shown), floor)
        return np.where(shown, half, np.inf)


Fits = tuple[LoopFit | None, LoopFit | None]


def set_of(names: tuple[str, ...], theta: Floats) -> Floats:
    """Gain, two numbers of the loop, acceleration limit and delay of searched parameters."""
    by = {n: x if n == "delay" else math.exp(x) for n, x in zip(names, theta, strict=True)}
    loop = (by["tau"], 1.0) if "tau" in by else (by["wn"], by["zeta"])
    return np.array([by.get("gain", 1.0), *loop, by.get("accel", math.inf), by["delay"]])


def _bounded(names: tuple[str, ...], theta: Floats) -> Floats:
    ends = [(0.0, LONGEST_DELAY) if n == "delay" else tuple(np.log(RANGES[n])) for n in names]
    return np.clip(theta, *np.array(ends).T)


def whitener(
    left: Floats, in_fit: np.ndarray, order: int = ORDER
) -> tuple[Callable[[Floats], Floats], np.ndarray]:
    """Filter that whitens residuals, and which samples it is whole for."""
    if not order:
        return lambda x: x, in_fit
    behind = np.column_stack([np.roll(left, k) for k in range(1, order + 1)])
    whole = in_fit & np.all([np.roll(in_fit, k) for k in range(1, order + 1)], axis=0)
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
    log: AxisLog, loop: str, names: tuple[str, ...], theta: Floats, passes: int, plain: int = 0
) -> LoopFit:
    """Scoring from ``theta``, damped until each step lowers minus the log-likelihood.

    The first ``plain`` passes are least squares of what is left itself, which lead from farther.
    """
    damping, done = 1e-3, False
    edges = np.linspace(log.t[0], log.t[-1] + 1e-9, BLOCKS + 1)
    block = np.searchsorted(edges, log.t, "right") - 1

    def deviation(many: list[Floats]) -> Floats:
        return log.speed[:, None] - foretold(log, loop, np.array([set_of(names, x) for x in many]))

    theta = _bounded(names, theta)
    for turn in range(passes):
        steps = np.diag([1e-4 if name == "delay" else 1e-3 for name in names])
        inside = [np.where(theta + s > _bounded(names, theta + s), -1, 1) for s in steps]
        apart = deviation([theta, *(theta + s * w for s, w in zip(steps, inside, strict=True))])
        left = apart[:, 0]
        slope = np.column_stack([
            (apart[:, k + 1] - left) / (steps[k, k] * inside[k][k]) for k in range(len(theta))
        ])  # fmt: skip
        whiten, whole = whitener(left, log.in_fit, ORDER if turn >= plain else 0)
        white, along = whiten(left)[whole], whiten(slope)[whole]
        sigma = math.hypot(float(np.std(white)), finest(log))
        nll = whole.sum() * math.log(sigma)
        place = block[whole]
        blocks = [(along[place == b], white[place == b]) for b in range(BLOCKS)]
        gradient = np.array([slopes.T @ rest / sigma**2 for slopes, rest in blocks])
        fisher = np.array([slopes.T @ slopes / sigma**2 for slopes, _ in blocks])
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


def likelihoods(fit: LoopFit, changes: Mapping[str, Floats]) -> Floats:
    """Log-likelihoods (K,) less that of the fit, of parameters that take other values (K,).

    Parameters are in SI units; what is left over is whitened as that of the fit is.
    """
    whiten, whole = whitener(fit.left, fit.log.in_fit)
    now = max(float(np.mean(whiten(fit.left)[whole] ** 2)), finest(fit.log) ** 2)
    count = len(next(iter(changes.values())))
    falls = []
    for part in np.array_split(np.arange(count), math.ceil(count / AT_ONCE)):
        sets = np.tile(set_of(fit.names, fit.theta), (len(part), 1))
        for name, values in changes.items():
            sets[:, PLACE[name]] = values[part]
        left = whiten(fit.log.speed[:, None] - foretold(fit.log, fit.loop, sets))[whole]
        falls.append((np.mean(left**2, axis=0) / now - 1) * whole.sum() / 2)
    return -np.concatenate(falls)


def forecast(fit: LoopFit, log: AxisLog) -> Floats:
    """Speeds (N,) that a fit foretells on another log, from its commands alone."""
    return foretold(log, fit.loop, np.array([set_of(fit.names, fit.theta)]))[:, 0]
