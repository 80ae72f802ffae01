"""Speed loop of one axis of a base: the speeds that follow from its commands, and its fit to a log.

    command, late by a delay  ->  shape  ->  ramp  ->  gain  ->  loop  ->  speed
    first-order    tau v' = w - v
    pi             v' = 2 zeta wn (w - v) + f,   f' = wn^2 (w - v)
    second-order   v'' = wn^2 (w - v) - 2 zeta wn v'

The ramp is that of `world.command_ramp`.  The shape of a command u is 0 below a dead band, else |u|
less an offset, at most its saturation.  Behind the ramp, w = K u (1 + curve |u|) + bias; K is
``back`` times as large backwards, and ``then`` times from a time ``when`` on.  The sensor shows the
speed with a first-order lag.  The residual of a fit is modelled as an autoregressive process, whose
inverse whitens residuals and gradients.
"""

from __future__ import annotations

import ctypes as ct
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial

import casadi as ca
import numpy as np

from wmr_ctrl.codegen.build import lanes_library
from wmr_ctrl.codegen.emit import kernel
from wmr_ctrl.core.data import data, with_tuples
from wmr_ctrl.world.command_ramp import moved
from wmr_ctrl.world.model.dynamics import rk4_step
from wmr_ctrl.world.model.system import System

from .fit import FINEST, FLOOR, climbed, errors_of
from .kalman import BLOCKS, Pass, blocks_of, symbol
from .logs.log import Floats, Mask, Names, Pair, quick
from .logs.samples import LONGEST_DELAY, AxisLog

_DATA = data(__package__, "speed_loop.toml")
LOOPS: Mapping[str, Names] = with_tuples(_DATA["loops"])
"""Parameters of each loop."""
NEUTRAL: dict[str, float] = _DATA["neutral"]
"""A set of parameters that changes nothing, by columns; decel is nan where it is as accel."""
Values = Mapping[str, float]
"""Numbers of a loop by name, SI units."""
NUMBERS = 12
"""Columns that the compiled steps take."""
PLACE = {name: place for place, name in enumerate(NEUTRAL)} | {"tau": 1, "wn": 1}
"""Columns of a set of parameters."""
WITHOUT: Mapping[str, Names] = with_tuples(_DATA["without"])
"""Parameters that a loop does not have."""
LINEAR = ("delay", "curve", "bias")
"""Parameters that are searched as they are; all others as logarithms."""
ORDER = 6
"""Order of the autoregression."""
RANGES: Mapping[str, Pair] = {**with_tuples(_DATA["ranges"]), "delay": (0.0, LONGEST_DELAY)}
NEAR_END = 0.98
ENOUGH = 0.01
MOST_VAGUE = 0.5
"""Half-width of a parameter's logarithm from which on it does not justify a richer loop."""
SMOOTHED = 0.1
"""Time over which deviations are averaged before the largest counts as a push [s]: shorter ones
are the sensors'."""
ALONE, ALONE_WIDER = 0.6, 4.0
"""Share of the information in one block from which on errors are not by leaving out blocks, and
half-width over standard error then."""
AT_ONCE = 16
"""Sets of parameters that are followed at once through a whole log."""


@cache
def _follower(loop: str) -> ct._NamedFuncPointer:
    """Compiled steps of (ramped command, v, second state, v as shown) for many sets of numbers."""
    w, v, inner, p = symbol("w"), symbol("v"), symbol("inner"), symbol("p", 2)
    first, second = p.sym[0], p.sym[1]
    a, b, error = 2 * second * first, first**2, w.sym - v.sym
    rates = {
        "first-order": ca.vertcat(error / first, 0),
        "pi": ca.vertcat(a * error + inner.sym, b * error),
        "second-order": ca.vertcat(inner.sym, b * error - a * inner.sym),
    }[loop]
    system = System("loop", loop, inputs=(w,), state=(v, inner), params=(p,), update=rates)
    sizes = (("x", 4), ("h",), ("p", NUMBERS), ("sent",))
    x, h, numbers, sent = (ca.SX.sym(*item) for item in sizes)
    gain, _, _, accel, decel, back, curve, bias, offset, dead, most, lag = ca.vertsplit(numbers)
    size = ca.fmin(ca.fmax(ca.fabs(sent) - offset, 0), most)
    shaped = ca.if_else(ca.fabs(sent) < dead, 0, ca.sign(sent) * size)
    rate = ca.if_else(x[0] * (shaped - x[0]) < 0, decel, accel)
    stopped = moved(x[0], shaped, h * accel, h * decel)
    # A ramp rests at 0 until its step ends, and these steps are longer.
    left = ca.fmax(1 - ca.fabs(stopped - x[0]) / (h * rate), 0) * h * accel
    ramped = ca.if_else(stopped == shaped, stopped, moved(stopped, shaped, left, left))
    # One that ends within a step rests at its end: the mean of both.
    way = ramped - x[0]
    acting = ramped - way * ca.fabs(way) / (2 * h * rate)
    own = gain * ca.if_else(acting < 0, back, 1) * (1 + curve * ca.fabs(acting))
    after = ca.substitute(
        rk4_step(system, h),
        ca.vertcat(w.sym, system.x, system.p),
        ca.vertcat(own * acting + bias, x[1:3], numbers[1:3]),
    )
    behind = lag * (after[0] - x[1]) / h
    shown = after[0] - behind + ca.exp(-h / lag) * (x[3] - x[1] + behind)
    step = kernel(
        "step",
        "State after a step with one command.",
        {"x": x, "sent": sent, "h": h, "p": numbers},
        {"next": ca.vertcat(ramped, after, shown)},
    )
    places = {"STATE": 4, "NUMBERS": NUMBERS, "SPEED": 3}
    return ct.CDLL(str(lanes_library("follow_loop.c", places, [step]))).wmr_follow_loop


def foretold(log: AxisLog, loop: str, many: Sequence[Values]) -> Floats:
    """Speeds (N, P) predicted from the commands alone, for P sets of parameters.

    A parameter missing from a set has no effect.  Each stretch starts at rest, some time before its
    first row.
    """
    if len(many) > AT_ONCE:
        parts = (many[k : k + AT_ONCE] for k in range(0, len(many), AT_ONCE))
        return np.hstack([foretold(log, loop, part) for part in parts])
    sets = np.tile([*NEUTRAL.values()], (len(many), 1))
    for row, values in zip(sets, many, strict=True):
        for name, value in values.items():
            row[PLACE[name]] = value
    accel, decel, delays = (sets[:, PLACE[name]].copy() for name in ("accel", "decel", "delay"))
    sets[:, PLACE["decel"]] = np.where(np.isnan(decel), accel, decel)
    numbers, count = np.ascontiguousarray(sets[:, :NUMBERS].T), len(sets)
    result = []
    for t, edges, sent in log.stretches:
        path, seen = np.zeros((len(edges), count)), np.empty((len(t), count))
        _follower(loop)(
            *(ct.c_int64(item) for item in (len(sent), count, len(t))),
            ct.c_int32(log.of_way), ct.c_double(edges[1] - edges[0]), ct.c_double(edges[0]),
            *(np.ascontiguousarray(x).ctypes for x in (sent, numbers, delays, t, path, seen)),
        )  # fmt: skip
        result.append(seen)
    changed = log.t[:, None] >= sets[:, PLACE["when"]]
    return np.vstack(result) * np.where(changed, sets[:, PLACE["then"]], 1.0)


@dataclass(frozen=True)
class LoopFit(Pass):
    """A fit of one loop: its parameters as searched by ``names``, and its residuals.

    ``left`` (N,): speed less the predicted speed; ``fixed``: numbers that were not searched;
    ``others``: fits that the log cannot distinguish from this one.
    """

    log: AxisLog
    loop: str
    names: Names
    theta: Floats
    left: Floats
    fixed: Values
    others: tuple[LoopFit, ...] = ()

    @property
    def bic(self) -> float:
        """Schwarz's criterion (BIC)."""
        count = len(self.theta) + len(self.fixed)
        return 2 * float(self.nll) + count * math.log(max(int(self.log.in_fit.sum()), 2))

    @property
    def squares(self) -> float:
        """Sum of the squared residuals."""
        return float(np.sum(self.left[self.log.in_fit] ** 2))

    @property
    def values(self) -> dict[str, float]:
        """Parameters in SI units."""
        return values_of(self.names, self.theta) | dict(self.fixed)

    @property
    def gain(self) -> float:
        """Speed over command, near 0 and forward."""
        return self.values.get("gain", 1.0)

    @property
    def vague(self) -> bool:
        """True if a number of the loop is hardly determined: the model has too many numbers."""
        half = self.half_widths()
        vague = (half[name] > MOST_VAGUE for name in self.names if name not in LINEAR)
        return self.too_steep or any(vague)

    @property
    def too_steep(self) -> bool:
        """True if the largest step of the command passes the ramp within one row."""
        return bool(self.values.get("accel", 0.0) * self.log.period > np.ptp(self.log.sent))

    @property
    def members(self) -> Names:
        """Searched parameters that are not those of the loop."""
        return tuple(name for name in self.names if name not in LOOPS[self.loop])

    @property
    def forecast(self) -> Floats:
        """Speed (N,) predicted from the commands."""
        return np.asarray(self.log.speed - self.left)

    @property
    def fastest(self) -> float:
        """Largest speed that the log shows and the fit explains, less the fastest hundredth."""
        return quick(self.forecast[self.log.in_fit], 0.99)

    @property
    def steepest(self) -> float:
        """Steepest motion predicted from the commands [m/s2, rad/s2], less the top fiftieth."""
        rates = np.abs(np.diff(self.forecast)) / np.diff(self.log.t)
        return max(float(np.quantile(rates, 0.98)), 0.02)

    def at_end(self, name: str) -> bool:
        """True if a parameter ended at a bound of its range, and so is no result."""
        low, high = RANGES.get(name, (-math.inf, math.inf))
        value = self.values.get(name, 1.0)
        return value > NEAR_END * high or (name not in LINEAR and value * NEAR_END < low)

    def deviation(self) -> Floats:
        """Measured minus predicted speed (N,), averaged over SMOOTHED; 0 at unused rows."""
        wide = max(round(SMOOTHED / self.log.period), 1)
        left = np.where(self.log.in_fit, self.left, 0.0)
        return np.convolve(left, np.ones(wide) / wide, "same")

    def half_widths(self, least_delay: float = 0.0) -> dict[str, float]:
        """Half-widths of 95 % intervals of the searched parameters."""
        information = self.fisher.sum(axis=0)
        shown = np.diag(information) > 0
        half = errors_of(self.gradient, self.fisher, shown)
        # To leave out a block that has nearly all information says nothing.
        wide = ALONE_WIDER * np.sqrt(np.diag(np.linalg.pinv(information)))
        half = np.where(shown, np.where(self.alone, wide, half), np.inf)
        least = dict.fromkeys(LINEAR, 0.0) | {"delay": least_delay}
        pairs = zip(self.names, half.tolist(), strict=True)
        return {name: max(x, least.get(name, FLOOR)) for name, x in pairs}

    @property
    def alone(self) -> Mask:
        """Mask (n,) of parameters for which one block of time has more than the share `ALONE` of
        the information.
        """
        blocks = np.diagonal(self.fisher, axis1=1, axis2=2)
        return np.asarray(blocks.max(axis=0) > ALONE * np.maximum(blocks.sum(axis=0), 1e-300))


Fits = tuple[LoopFit | None, LoopFit | None]


def values_of(names: Names, theta: Floats) -> dict[str, float]:
    """Searched parameters in SI units."""
    pairs = zip(names, theta.tolist(), strict=True)
    return {name: x if name in LINEAR else math.exp(x) for name, x in pairs}


def searched(values: Values, names: Names) -> Floats:
    """Parameters in the scaling of the search."""
    return np.array([values[n] if n in LINEAR else math.log(values[n]) for n in names])


def whitener(
    left: Floats, in_fit: Mask, order: int = ORDER
) -> tuple[Callable[[Floats], Floats], Mask]:
    """Filter that whitens residuals, and the mask of samples for which its window is complete."""
    whole = np.convolve(in_fit, np.ones(order + 1))[: len(left)] > order
    window = np.column_stack([np.roll(left, k) for k in range(order + 1)])[whole]
    squares = window.T @ window
    taps = [1.0, *-np.linalg.lstsq(squares[1:, 1:], squares[1:, 0], rcond=None)[0]]

    def whiten(x: Floats) -> Floats:
        return np.asarray(sum(tap * np.roll(x, k, axis=0) for k, tap in enumerate(taps)))

    return whiten, whole


def fitted(
    log: AxisLog, loop: str, names: Names, theta: Floats, passes: int, plain: int = 0,
    fixed: Values | None = None,
) -> LoopFit:  # fmt: skip
    """Fit by Fisher scoring from ``theta``.

    The first ``plain`` passes are least squares on unwhitened residuals, which converge from
    farther away; if all passes are such, the fit is by least squares. ``fixed``: numbers that are
    not searched.
    """
    fixed, block = dict(fixed or {}), blocks_of(log.t)
    spread = max(float(np.std(log.speed[log.in_fit])), 1e-9)
    wide = {"delay": 1e-4, "bias": 1e-3 * spread, "curve": 1e-3 / spread}
    steps = np.array([wide.get(name, 1e-3) for name in names])
    ends = np.array([RANGES[n] if n in LINEAR else np.log(RANGES[n]) for n in names]).T

    def read(order: int, theta: Floats, slopes: bool) -> LoopFit:
        inside = np.where(theta + steps > ends[1], -steps, steps)
        many = [theta, *(theta + np.diag(inside) if slopes else ())]
        seen = foretold(log, loop, [values_of(names, item) | fixed for item in many])
        left = log.speed - seen[:, 0]
        slope = (seen[:, :1] - seen[:, 1:]) / (inside if slopes else 1.0)
        whiten, whole = whitener(left, log.in_fit, order)
        white, along = whiten(left)[whole], whiten(slope)[whole]
        # No model is exact.
        sigma = math.hypot(float(np.std(white)), FINEST * spread)
        parts = [block[whole] == b for b in range(BLOCKS)]
        gradient = np.array([along[part].T @ white[part] for part in parts]) / sigma**2
        fisher = np.array([along[part].T @ along[part] for part in parts]) / sigma**2
        nll = np.array(whole.sum() * math.log(sigma))
        return LoopFit(nll, gradient, fisher, log, loop, names, theta, left, fixed)

    free, both = np.ones(len(names), bool), (ends[0], ends[1])
    for order, count in ((0, plain), (ORDER, passes - plain)):
        if count:
            theta, fit = climbed(partial(read, order), theta, free, both, 1.0, count, ENOUGH)
    return fit
