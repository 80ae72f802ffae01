"""Speed loop of one axis of a base: its log, and the speeds that follow from commands alone.

    command, late by a delay  ->  ramp  ->  loop  ->  speed
    first-order    tau v' = K u - v
    pi             v' = 2 zeta wn (u - v) + f,   f' = wn^2 (u - v)
    second-order   v'' = wn^2 (K u - v) - 2 zeta wn v'

The ramp is that of `world.command_ramp`.
"""

from __future__ import annotations

import ctypes as ct
from dataclasses import dataclass, replace
from functools import cache

import casadi as ca
import numpy as np

from wmr_ctrl.codegen.emit import kernel
from wmr_ctrl.identification.fit import DELAY_MOST
from wmr_ctrl.identification.lint import LONGEST_SHIFT
from wmr_ctrl.identification.log import LogError, unit_of
from wmr_ctrl.identification.reading import Floats, Samples, lanes_library
from wmr_ctrl.model.dynamics import rk4_step
from wmr_ctrl.model.system import System, port
from wmr_ctrl.signals import Signal
from wmr_ctrl.world.command_ramp import moved

STEP = 0.01
ENOUGH_ROWS = 20_000
"""Rows of a log that tell by how much a speed is later than its command."""
COUNTED_FROM = 1.0
"""Time at the start of each stretch that does not count [s]."""


@dataclass(frozen=True)
class AxisLog:
    """Command and speed of one axis; ``of_way``: speeds are means since the sample before.

    ``t``, ``speed``, ``counted`` (N,); ``sent_t``, ``sent`` (M,); ``first``: where stretches begin.
    """

    t: Floats
    speed: Floats
    counted: np.ndarray
    sent_t: Floats
    sent: Floats
    first: np.ndarray
    of_way: bool
    period: float

    def until(self, end: float) -> AxisLog:
        """The same up to a time [s]."""
        n = int(np.searchsorted(self.t, end))
        first = self.first[self.first < n]
        return replace(
            self, t=self.t[:n], speed=self.speed[:n], counted=self.counted[:n], first=first
        )

    def commands(self, begin: Floats, length: Floats, delays: Floats) -> Floats:
        """Commands (3, K, P) over pieces of time (K,), each late by delays (P,).

        At the beginning, at the end, and the share of the piece for which the first one acts.
        """
        done = np.concatenate(([0.0], np.cumsum(self.sent[:-1] * np.diff(self.sent_t))))

        def until(t: Floats) -> Floats:
            at = np.maximum(np.searchsorted(self.sent_t, t, "right") - 1, 0)
            return np.asarray(done[at] + self.sent[at] * (t - self.sent_t[at]))

        start = begin[:, None] - delays
        end = start + length[:, None]
        mean = (until(end) - until(start)) / length[:, None]
        at = np.searchsorted(self.sent_t, np.stack((start, end - 1e-12)), "right") - 1
        before, after = self.sent[np.maximum(at, 0)]
        apart = np.where(before == after, 1.0, before - after)
        share = np.where(before == after, 1.0, np.clip((mean - after) / apart, 0, 1))
        return np.stack((before, after, share))


def axis_log(log: Samples, axis: int) -> AxisLog:
    """Speeds of one axis; of counts their difference over the time between samples."""
    speed = log.seen[:, axis]
    if not log.of_speed:
        step = np.diff(log.t, prepend=log.t[0] - 1.0)
        speed = np.diff(speed, prepend=speed[0]) / step
    since = log.t - log.t[log.first][np.searchsorted(log.first, np.arange(len(log.t)), "right") - 1]
    counted = (since > COUNTED_FROM) & (log.t - DELAY_MOST > log.command_t[0])
    sent = log.command[:, axis]
    return AxisLog(
        log.t, speed, counted, log.command_t, sent, log.first, not log.of_speed, log.period
    )


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
    return ct.CDLL(lanes_library("follow_loop.c", sizes, [step])).wmr_follow_loop


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


def shifted_gain(log: AxisLog) -> tuple[float, float, float]:
    """Gain, the shift [s] at which the command explains most of the speed, and that share."""
    shifts = np.arange(-LONGEST_SHIFT, LONGEST_SHIFT + 1e-9, max(log.period, 0.01))
    some = np.flatnonzero(log.counted)
    some = some[:: max(1, len(some) // ENOUGH_ROWS)]
    step = np.full(len(some), log.period)
    before, after, share = log.commands(log.t[some] - log.period, step, shifts)
    u, v = share * before + (1 - share) * after, log.speed[some][:, None]
    gains = np.sum(u * v, axis=0) / np.maximum(np.sum(u * u, axis=0), 1e-300)
    shares = 1 - np.sum((v - gains * u) ** 2, axis=0) / max(float(np.sum(v * v)), 1e-300)
    k = int(np.argmax(shares))
    return float(gains[k]), float(shifts[k]), float(shares[k])


def check_following(
    name: str, column: str, gain: float, shift: float, share: float, period: float
) -> None:
    """A speed follows its command, in its unit, forward and later."""
    if share < 0.3:
        return
    if gain < 0:
        raise LogError(
            f"{name}: the speed goes against {column}: the sign of one of both is reversed. "
            "Positive is forward, and anticlockwise."
        )
    if sense := unit_of(gain):
        raise LogError(
            f"{name}: the speed is {gain:.3g} times {column}: it looks like {sense}. Name the unit "
            "in the header, or set encoder.counts."
        )
    if share > 0.5 and shift < -max(2.5 * period, 0.03):
        raise LogError(
            f"{name}: the speed changes {-shift:.2f} s before {column}: the clocks of commands and "
            "sensors differ, or a column was shifted. Take both times from one clock."
        )
