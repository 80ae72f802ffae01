"""Bases that take velocities, with faults: written a second time, and nothing of wmr_ctrl imported.

Each axis in steps of 1 ms: a command late by a delay, a dead band, an offset, a saturation, ramps
up and down, a gain by direction and by command, a loop, a push.  Wheels may have a least and a
largest speed, one axis may slow the other, and recordings have faults of their own.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

STEP, PARTS = 1e-3, 8
"""Step of a base [s], and number of its parts for a second-order loop."""
NONE = math.inf


@dataclass(frozen=True)
class Axis:
    """Numbers of one axis, SI units: ``first`` is tau of a first-order loop, else its frequency."""

    loop: str = "first-order"
    gain: float = 1.0
    back: float = 1.0
    first: float = 0.1
    zeta: float = 1.0
    accel: float = NONE
    decel: float | None = None
    offset: float = 0.0
    dead: float = 0.0
    most: float = NONE
    bias: float = 0.0
    curve: float = 0.0


@dataclass(frozen=True)
class Truth:
    """Base: both axes, delays [s], wheels, influence of v on omega, and a change at a time."""

    axes: tuple[Axis, Axis]
    delay: tuple[float, float] = (0.04, 0.04)
    half_track: float = 0.2
    least_wheel: float = 0.0
    most_wheel: float = NONE
    cross: float = 0.0
    timeout: float = NONE
    sensor: float = 0.0
    mean: float = 0.0
    """Lag of the sensor, and time over which it averages [s]."""
    then: tuple[float, int, float] | None = None
    """Time [s] of a change, axis, and factor of its gain afterwards."""


@dataclass
class Base:
    """Running base; ``push`` (2,) acts on the targets of both axes."""

    truth: Truth
    ramped: list[float] = field(default_factory=lambda: [0.0, 0.0])
    v: list[float] = field(default_factory=lambda: [0.0, 0.0])
    rate: list[float] = field(default_factory=lambda: [0.0, 0.0])
    shown: list[float] = field(default_factory=lambda: [0.0, 0.0])
    now: float = 0.0

    def __post_init__(self) -> None:
        self.queues = [deque([0.0] * round(late / STEP)) for late in self.truth.delay]
        self.averaged = [deque([0.0] * max(round(self.truth.mean / STEP), 1)) for _ in self.v]

    def step(self, command: tuple[float, float], push: tuple[float, float] = (0.0, 0.0)) -> None:
        """One millisecond with a command that is sent now."""
        acting = []
        for queue, u in zip(self.queues, command, strict=True):
            queue.append(u)
            acting.append(queue.popleft())
        acting = self._wheels(*acting)
        slowed = self.truth.cross * abs(self.v[0])
        for axis, u in enumerate(acting):
            extra = push[axis] - (math.copysign(slowed, self.v[1]) * (self.v[1] != 0) * axis)
            self._axis(axis, u, extra)
        self.now += STEP
        keep = math.exp(-STEP / self.truth.sensor) if self.truth.sensor else 0.0
        for axis, row in enumerate(self.averaged):
            row.append(self.v[axis])
            row.popleft()
            mean = sum(row) / len(row) if self.truth.mean else self.v[axis]
            self.shown[axis] = keep * self.shown[axis] + (1 - keep) * mean

    def off(self) -> None:
        """Simulate one millisecond with the drivers off."""
        for axis in (0, 1):
            self.queues[axis].append(0.0)
            self.queues[axis].popleft()
            self.ramped[axis] = self.rate[axis] = 0.0
            self.v[axis] *= math.exp(-STEP / 0.02)
            self.shown[axis] = self.v[axis]
        self.now += STEP

    def _wheels(self, v: float, omega: float) -> list[float]:
        t = self.truth
        if not t.least_wheel and t.most_wheel == NONE:
            return [v, omega]
        wheels = []
        for side in (1, -1):
            speed = v + side * t.half_track * omega
            speed = 0.0 if abs(speed) < t.least_wheel else speed
            wheels.append(min(max(speed, -t.most_wheel), t.most_wheel))
        return [sum(wheels) / 2, (wheels[0] - wheels[1]) / 2 / t.half_track]

    def _axis(self, axis: int, u: float, push: float) -> None:
        a, size = self.truth.axes[axis], abs(u)
        size = 0.0 if size < a.dead else min(max(size - a.offset, 0.0), a.most)
        r = self._ramp(axis, math.copysign(size, u))
        gain = a.gain * (a.back if r < 0 else 1.0) * (1 + a.curve * abs(r))
        then = self.truth.then
        if then and axis == then[1] and self.now >= then[0]:
            gain *= then[2]
        goal, v = gain * r + a.bias + push, self.v[axis]
        if a.loop == "first-order":
            self.v[axis] = v + (goal - v) * -math.expm1(-STEP / a.first)
            return
        damped, stiff, h = 2 * a.zeta * a.first, a.first**2, STEP / PARTS
        for _ in range(PARTS):
            if a.loop == "second-order":
                self.rate[axis] += h * (stiff * (goal - v) - damped * self.rate[axis])
                v += h * self.rate[axis]
            else:
                v += h * (damped * (r + push - v) + self.rate[axis])
                self.rate[axis] += h * stiff * (r - v)
        self.v[axis] = v

    def _ramp(self, axis: int, wanted: float) -> float:
        a, now = self.truth.axes[axis], self.ramped[axis]
        slower = now * (wanted - now) < 0
        rate = (a.accel if a.decel is None else a.decel) if slower else a.accel
        most = rate * STEP
        after = wanted if abs(wanted - now) <= most else now + math.copysign(most, wanted - now)
        self.ramped[axis] = 0.0 if slower and after * now < 0 and abs(wanted) > most else after
        return self.ramped[axis]


@dataclass(frozen=True)
class Drive:
    """How a base is driven and recorded.

    ``held`` [s] of random commands up to ``most``, of a ``kind``; noise and quantum of both speeds;
    push: rms of both and its time [s]; off: stretches without drivers; silent: (on, period) of the
    commands [s]; the rest are faults of the recording.
    """

    seconds: float = 40.0
    period: float = 0.02
    kind: str = "steps"
    held: tuple[float, float] = (0.5, 2.0)
    most: tuple[float, float] = (0.5, 1.0)
    noise: tuple[float, float] = (0.003, 0.006)
    quantum: float = 0.0
    push: tuple[float, float, float] | None = None
    off: tuple[tuple[float, float], ...] = ()
    silent: tuple[float, float] | None = None
    jitter: float = 0.0
    zeros: float = 0.0
    spikes: int = 0
    scale: tuple[float, float] = (1.0, 1.0)
    slows: float | None = None
    timer: bool = False
    lost: float = 0.0
    twice: int = 0


def commands(drive: Drive, rng: np.random.Generator) -> np.ndarray:
    """Commands (N, 2) of a drive, at rest at both ends."""
    count, rest = round(drive.seconds / drive.period), round(0.5 / drive.period)
    sent = np.zeros((count, 2))
    for axis, most in enumerate(drive.most):
        row = rest
        while row < count - rest:
            rows = max(1, round(rng.uniform(*drive.held) / drive.period))
            level = rng.uniform(0 if drive.kind == "forward" and not axis else -1, 1)
            if drive.kind == "levels":
                level = rng.choice([-1, -0.5, 0, 0.5, 1])
            sent[row : row + rows, axis] = most * level
            row += rows
    if drive.kind == "smooth":
        wide = max(1, round(0.3 / drive.period))
        sent = np.column_stack([np.convolve(x, np.ones(wide) / wide, "same") for x in sent.T])
    sent[-rest:] = 0
    return sent


def recorded(truth: Truth, drive: Drive, seed: int) -> dict[str, list[float]]:
    """Columns of a log, as ``identify`` takes them; empty cells are nan."""
    rng = np.random.default_rng(seed)
    sent = commands(drive, rng)
    count, inner = len(sent), round(drive.period / STEP)
    said = np.ones(count, bool)
    if drive.silent:
        said = np.arange(count) * drive.period % drive.silent[1] < drive.silent[0]
    arrives = np.where(said[:, None], sent, np.nan)
    if drive.lost:
        for k in np.flatnonzero(rng.random(count) < drive.lost):
            arrives[k] = arrives[k - 1]
    early = rng.integers(0, inner, count) if drive.timer else np.zeros(count, int)
    pushes = _pushes(drive, count * inner, rng)
    base, heard, acting, seen = Base(truth), 0.0, (0.0, 0.0), []
    for k in range(count):
        seen.append(tuple(base.shown))
        for i in range(inner):
            ahead = k + 1 if k + 1 < count and i >= inner - early[min(k + 1, count - 1)] else k
            if said[ahead]:
                acting, heard = tuple(arrives[ahead].tolist()), base.now
            late = base.now - heard >= truth.timeout
            if any(a <= base.now < b for a, b in drive.off):
                base.off()
            else:
                base.step((0.0, 0.0) if late else acting, pushes(k * inner + i))
    t = np.arange(count) * drive.period
    speed = np.array(seen)
    moving = [not any(a <= x < b for a, b in drive.off) for x in t]
    speed = speed + rng.standard_normal((count, 2)) * drive.noise * np.array(moving)[:, None]
    return _columns(drive, rng, t, np.where(said[:, None], sent, np.nan), speed)


def _pushes(
    drive: Drive, count: int, rng: np.random.Generator
) -> Callable[[int], tuple[float, float]]:
    if drive.push is None:
        return lambda _: (0.0, 0.0)
    keep = math.exp(-STEP / drive.push[2])
    noise, state = rng.standard_normal((count, 2)) * math.sqrt(1 - keep**2), [0.0, 0.0]

    def at(k: int) -> tuple[float, float]:
        for axis in (0, 1):
            state[axis] = keep * state[axis] + noise[k, axis] * drive.push[axis]
        return state[0], state[1]

    return at


def _columns(
    drive: Drive, rng: np.random.Generator, t: np.ndarray, sent: np.ndarray, speed: np.ndarray
) -> dict[str, list[float]]:
    """The recording, with its faults."""
    count = len(t)
    if drive.quantum:
        speed = np.round(speed / drive.quantum) * drive.quantum
    if drive.zeros:
        speed[rng.random(count) < drive.zeros] = 0
    for k in rng.integers(100, count - 100, drive.spikes):
        speed[k, 0] = 3.0 * rng.choice([-1, 1])
    t = t + rng.uniform(0, drive.jitter, count) if drive.jitter else t
    if drive.slows is not None:
        t = np.where(t < drive.slows, t, drive.slows + 2 * (t - drive.slows))
    rows = np.arange(count)
    if drive.twice:
        rows = np.sort(np.concatenate((rows, rows[7 :: drive.twice])))
    speed = speed * drive.scale
    names = ("t [s]", "v_command [m/s]", "omega_command [rad/s]")
    names = (*names, "v1_measured [m/s]", "omega_measured [rad/s]")
    values = np.column_stack((t, sent, speed))[rows]
    return {name: column.tolist() for name, column in zip(names, values.T, strict=True)}


def changed(truth: Truth, **numbers: float) -> Truth:
    """Truth with other numbers on both axes."""
    first, second = (replace(axis, **numbers) for axis in truth.axes)
    return replace(truth, axes=(first, second))
