"""Samples of a log: measured motion and commands, of both axes or of one."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from wmr_ctrl.world.encoder import COUNTS
from wmr_ctrl.world.scenario import Scenario

from .log import (
    AXES,
    TORQUES,
    WHEEL_SPEED,
    Floats,
    Log,
    Mask,
    Names,
    Pair,
    quick,
    usual_step,
)

GAP = 5.0
"""Steps without a row from which on a log is in two stretches."""

LONGEST_SHIFT = 0.5
"""Shifts of commands against the motion that are looked at, either way [s]."""

LONGEST_DELAY = 0.6
"""Longest delay of a command that is looked for [s]."""

ENOUGH_ROWS = 20_000
"""Rows of a log that tell by how much a speed is later than its command."""

HELD = 0.2
"""Time for which a speed is held that a log shows [s]."""

STEP = 5e-3
"""Longest step of a loop [s]."""
BEFORE = 0.7
"""Time for which a loop runs before a stretch of the log [s]."""

COUNTED_FROM = 1.0
"""Time at the start of each stretch that does not count [s], except one that begins at rest."""

RESTS = 0.3
"""Time at rest at the start of a stretch [s]."""
STILL = 0.05
"""Largest speed that counts as rest, over the quickest motion."""


@dataclass(frozen=True)
class Samples:
    """Measurements and commands on the clocks of the log.

    ``t`` (N,) [s] and ``seen`` (N, 2): path length [m] and rotation [rad], or both speeds
    (``of_speed``), with known variances (2,); ``command_t`` (M,) [s] and ``command`` (M, 2):
    torques [N m] or speeds, each kept until the next; ``first``: indices of t at which a stretch
    without gap begins; ``use`` (N, 2): readings to use, None for all.
    """

    t: Floats
    seen: Floats
    variance: Floats
    command_t: Floats
    command: Floats
    first: NDArray[np.int64]
    of_speed: bool = False
    use: Mask | None = None

    @property
    def period(self) -> float:
        """Median time between commands [s]."""
        return usual_step(self.command_t)

    @property
    def stretches(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """First and last row (N,) of the stretch that each row is in."""
        count = np.diff(self.first, append=len(self.t))
        return np.repeat(self.first, count), np.repeat(self.first + count - 1, count)

    @property
    def since(self) -> Floats:
        """Time (N,) since each row's stretch began [s]."""
        return self.t - self.t[self.stretches[0]]

    def until(self, end: float, begin: float = -np.inf) -> Samples:
        """Samples between two times [s], with all earlier commands."""
        low, high = np.searchsorted(self.t, (begin, end)).tolist()
        first = self.first[(self.first > low) & (self.first < high)] - low
        return replace(
            self,
            t=self.t[low:high],
            seen=self.seen[low:high],
            first=np.concatenate(([0], first)).astype(np.int64),
            use=None if self.use is None else self.use[low:high],
        )


def motion_of(raw: Log, scenario: Scenario, source: str, commands: Names = TORQUES) -> Samples:
    """Samples of a log whose motion is read from the columns ``source``."""
    r, half_track = scenario.robot.r, scenario.robot.l
    sent, command = raw.pair(commands)
    variance, of_speed = np.zeros(2), source != COUNTS.name
    if source in (COUNTS.name, "wheel_speed"):
        names = COUNTS.elements if source == COUNTS.name else WHEEL_SPEED
        t, wheel = raw.pair(names)
        if not of_speed:
            count = 2 * math.pi / float(scenario.value("encoder.counts")[0])
            wheel = wheel * count
            one = (count * r) ** 2 / 12
            variance = np.array([one / 2, one / (2 * half_track**2)])
        seen = (
            np.column_stack((wheel.sum(axis=1), (wheel[:, 0] - wheel[:, 1]) / half_track)) * r / 2
        )
    else:
        t, seen = raw.pair((source, source.replace("v1", "omega")))
    step = np.diff(t)
    first = np.append(0, np.flatnonzero(step > GAP * np.median(step)) + 1)
    return Samples(t, seen, variance, sent, command, first, of_speed)


def speeds(log: Samples, over: float = 0.1) -> Floats:
    """Smoothed speeds (N, 2) [m/s, rad/s]: differences over a time [s], never across a gap."""
    if log.of_speed:
        return log.seen
    later = np.minimum(np.searchsorted(log.t, log.t + over / 2), len(log.t) - 1)
    sooner = np.maximum(np.searchsorted(log.t, log.t - over / 2, "right") - 1, 0)
    first, last = log.stretches
    later, sooner = np.minimum(later, last), np.maximum(sooner, first)
    span = np.maximum(log.t[later] - log.t[sooner], 1e-9)
    return np.asarray((log.seen[later] - log.seen[sooner]) / span[:, None])


def held_range(log: Samples) -> dict[str, Pair]:
    """Range of v and omega [m/s, rad/s] that lasted for `HELD`; single readings are ignored."""
    speed = speeds(log)
    rows = min(round(HELD / usual_step(log.t)) + 1, len(speed))
    held = sliding_window_view(speed, rows, axis=0)
    ends = np.sort((held.max(axis=-1).min(axis=0), held.min(axis=-1).max(axis=0)), axis=0)
    return {axis: (low, high) for axis, (low, high) in zip(AXES, ends.T.tolist(), strict=True)}


def held_speeds(log: Samples) -> Pair:
    """Largest |v1| and |omega| [m/s, rad/s] that lasted for `HELD`."""
    v, omega = (max(-low, high, 0.0) for low, high in held_range(log).values())
    return v, omega


def forces(torque: Floats, r: float, half_track: float) -> Floats:
    """Thrust and moment (N, 2) on the body [N, N m] of the wheels' torques (N, 2)."""
    right, left = torque.T
    return np.column_stack((right + left, half_track * (right - left))) / r


def wheels(speed: Floats, half_track: float) -> Floats:
    """Speeds of the right and the left wheel (N, 2) [m/s] of body speeds."""
    turn = half_track * speed[:, 1]
    return np.column_stack((speed[:, 0] + turn, speed[:, 0] - turn))


@dataclass(frozen=True)
class AxisLog:
    """Commands and speeds of one axis; with ``of_way``, speeds are means since the sample before.

    ``t``, ``speed``, ``in_fit`` (N,); ``sent_t``, ``sent`` (M,); ``first``: where stretches begin.
    """

    t: Floats
    speed: Floats
    in_fit: Mask
    sent_t: Floats
    sent: Floats
    first: NDArray[np.int64]
    of_way: bool
    period: float

    @cached_property
    def stretches(self) -> list[tuple[Floats, Floats, Floats]]:
        """Per stretch: its times (n,), edges (K + 1,) of even steps, and mean commands (K,).

        The steps start a time BEFORE earlier than the stretch.
        """
        h, result = self.period / math.ceil(self.period / STEP - 1e-9), []
        for t in np.split(self.t, self.first[1:]):
            edges = np.arange(t[0] - BEFORE, t[-1] + 1.5 * h, h)
            result.append((t, edges, self.mean_command(edges[:-1], edges[1:])))
        return result

    def mean_command(self, begin: Floats, end: Floats) -> Floats:
        """Mean of the commands from ``begin`` to ``end`` [s], both of one shape."""
        done = np.concatenate(([0.0], np.cumsum(self.sent[:-1] * np.diff(self.sent_t))))

        def until(t: Floats) -> Floats:
            at = np.maximum(np.searchsorted(self.sent_t, t, "right") - 1, 0)
            return np.asarray(done[at] + self.sent[at] * (t - self.sent_t[at]))

        return (until(end) - until(begin)) / (end - begin)

    @cached_property
    def follows(self) -> tuple[float, float, float]:
        """Gain, the shift [s] at which the command explains most of the speed, and that share."""
        shifts = shifts_of(self.period)
        some = np.flatnonzero(self.in_fit)
        some = some[:: max(1, len(some) // ENOUGH_ROWS)]
        end = self.t[some][:, None] - shifts
        u, v = self.mean_command(end - self.period, end), self.speed[some][:, None]
        gains = np.sum(u * v, axis=0) / np.maximum(np.sum(u * u, axis=0), 1e-300)
        shares = 1 - np.sum((v - gains * u) ** 2, axis=0) / max(float(np.sum(v * v)), 1e-12)
        shares *= bool(v.any())
        k = int(np.argmax(shares))
        return float(gains[k]), float(shifts[k]), float(shares[k])


def axis_log(log: Samples, axis: int) -> AxisLog:
    """Log of one axis; speeds from counts are differences divided by the time between samples."""
    speed = log.seen[:, axis]
    if not log.of_speed:
        step = np.diff(log.t, prepend=log.t[0] - 1.0)
        speed = np.diff(speed, prepend=speed[0]) / step
    since, sent = log.since, log.command[:, axis]
    in_fit = (since > COUNTED_FROM) & (log.t - LONGEST_DELAY > log.command_t[0])
    still = STILL * quick(speed, 0.98)
    for stretch in np.split(np.arange(len(log.t)), log.first[1:]):
        # What begins at rest has no motion of before.
        rows = stretch[since[stretch] < RESTS]
        acting = np.searchsorted(log.command_t, log.t[rows], "right") - 1
        if not sent[np.maximum(acting, 0)].any() and (np.abs(speed[rows]) <= still).all():
            in_fit[stretch] = since[stretch] > 0
    if log.use is not None:
        in_fit &= log.use[:, axis]
    return AxisLog(
        log.t, speed, in_fit, log.command_t, sent, log.first, not log.of_speed, log.period
    )


def interpolated(t: Floats, times: Floats, values: Floats) -> Floats:
    """Linear interpolation of columns (N, K) at times (M,)."""
    return np.column_stack([np.interp(t, times, column) for column in values.T])


def differenced(log: Samples, half_track: float) -> tuple[Floats, Callable[[float], Floats]]:
    """Accelerations of the wheels, less the part that their speed explains, and a function that
    gives the torques for a shift [s]: both weighted by a triangle of 0.1 s, on an even grid.
    """
    T = log.period
    t = np.arange(log.t[0], log.t[-1], T)
    way = interpolated(t, log.t, log.seen)
    if log.of_speed:
        way = np.cumsum(way, axis=0) * T
    way, w = wheels(way, half_track), max(round(0.1 / T), 2)
    rate = (way[2 * w :] - 2 * way[w:-w] + way[: -2 * w]) / (w * T) ** 2
    speed = (way[2 * w :] - way[: -2 * w]) / (2 * w * T)
    drag = np.column_stack((np.tanh(speed / 0.02), speed))
    triangle = np.convolve(np.ones(w), np.ones(w)) / w**2

    def beside(x: Floats) -> Floats:
        return np.asarray(x - drag @ np.linalg.lstsq(drag, x, rcond=None)[0])

    def pushed(shift: float) -> Floats:
        held = np.searchsorted(log.command_t, t - shift + 1e-9, "right") - 1
        command = log.command[np.maximum(held, 0)]
        smooth = [np.convolve(x, triangle, "same")[w:-w] for x in command.T]
        return beside(np.column_stack(smooth))

    return beside(rate), pushed


def gains(moved: Floats, torque: Floats) -> tuple[float, Floats]:
    """Share of the acceleration that both torques explain, and the gain matrix (2, 2)."""
    solution = np.asarray(np.linalg.lstsq(torque, moved, rcond=None)[0], dtype=np.float64)
    rest = np.sum((moved - torque @ solution) ** 2)
    return float(1 - rest / max(np.sum(moved**2), 1e-300)), solution.T


def shifts_of(period: float) -> Floats:
    """Shifts of commands against the motion that are tried [s]."""
    return np.arange(-LONGEST_SHIFT, LONGEST_SHIFT + 1e-9, max(period, 0.01))
