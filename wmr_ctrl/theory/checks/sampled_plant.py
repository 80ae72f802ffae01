"""Robot, drives and sensors from one control sample to the next, by gradients of their graphs.

Plant steps follow each other between the instants at which a command takes over; the commands under
way are a shift register.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.core.signals import PATH, SKID, TORQUE
from wmr_ctrl.world.model.evaluate import evaluated

from .error_coordinates import (
    COMMAND,
    HELD,
    POSE,
    ROBOT,
    SPEED,
    Floats,
    World,
    names_of,
)

GRID = 1e-9
"""Share of a period within which an instant counts as one of its ends."""
SENT = "force_sent"
"""Name of a command under way, before its age."""


@dataclass(frozen=True)
class Motion:
    """Motion to linearise at: e (3) [m, m, rad], v and v_d (2) [m/s, rad/s], theta_d [rad]."""

    e: tuple[float, ...]
    v: tuple[float, ...]
    v_d: tuple[float, ...]
    theta: float = 0.0

    @property
    def s(self) -> tuple[float, ...]:
        """e and v (5)."""
        return *self.e, *self.v


@dataclass(frozen=True, eq=False)
class Point:
    """Operating point: e (3) [m, m, rad], v (2), v_d (2) and its rate (2), memory, force (2).

    The force is the one that the law gets as applied and sent; ``theta`` [rad] that of the
    reference, where something acts by it.
    """

    e: Floats
    v: Floats
    v_d: Floats
    v_d_dot: Floats
    memory: Floats
    force: Floats
    theta: float = 0.0

    @property
    def s(self) -> Floats:
        """e and v in one vector (5)."""
        return np.concatenate((self.e, self.v))

    def turned(self, theta: float) -> Point:
        """The point with the reference's orientation ``theta`` [rad]."""
        return self if theta == self.theta else replace(self, theta=theta)

    @cached_property
    def motion(self) -> Motion:
        """The robot's part of it."""
        e, v, v_d = (tuple(map(float, item)) for item in (self.e, self.v, self.v_d))
        return Motion(e, v, v_d, self.theta)


@dataclass(frozen=True)
class SampledPlant:
    """x_next = moved x + forced u + pushed d for the command u and a disturbance d [N, N m].

    ``measured`` x is tracking error and velocity as the sensors show them (5).  The first elements
    of x are those of the robot; ``names`` has one for each element behind them.
    """

    moved: Floats
    forced: Floats
    pushed: Floats
    measured: Floats
    names: tuple[str, ...]

    @property
    def sent(self) -> NDArray[np.intp]:
        """Indices of the commands in flight, the latest first."""
        in_flight = [name.startswith(SENT) for name in self.names]
        return ROBOT + np.flatnonzero(in_flight)


def by_age(unit: Floats, now: int, sent: slice) -> list[Floats]:
    """Rows that pick commands out of a state and the one that is given ``now``, by age."""
    queue = unit[sent]
    return [
        unit[now : now + COMMAND],
        *(queue[i : i + COMMAND] for i in range(0, len(queue), COMMAND)),
    ]


@dataclass(frozen=True)
class Assembly:
    """The rows of a SampledPlant, block by block: fast state, commands sent, slow state.

    ``worlds`` with weights; ``every``: samples from one pose to the next; ``step``: about a plant
    step [s]; ``numbers`` of a world's parameters, by the step; ``sent``: what is held by a command
    (2, 2); ``wheels``: torques by force (2, 2); ``torque`` (2): what keeps the velocity [N m];
    ``sends``: velocities are commanded.
    """

    worlds: Sequence[tuple[float, World]]
    motion: Motion
    period: float
    every: int
    step: float
    numbers: Callable[[World, float], list[float]]
    sent: Floats
    wheels: Floats
    torque: Floats
    sends: bool

    @property
    def world(self) -> World:
        """One of them: the fast state is that of all."""
        return self.worlds[0][1]

    def _fast(self, back: float) -> Floats:
        """The fast state some time [s] before, drives at the torque that keeps the velocity."""
        (v, omega), world = self.motion.v, self.world
        theta = self.motion.theta - omega * back
        known = {"x": v * back * math.sin(theta), "y": -v * back * math.cos(theta), "theta": theta,
                 "v1": v, "omega": omega, PATH.name: -v * back}  # fmt: skip
        state = np.zeros(world.size)
        for item in world.fast:
            name, unit, size = item.signal.name, item.signal.unit, item.signal.size
            torque = unit == TORQUE[0].unit and size == COMMAND
            state[world.rows[name]] = self.torque if torque else known.get(name, item.value)
        return state

    def _step(self, graph: ca.Function, step: float) -> Floats:
        """Output of a plant-step graph for one of ``step`` [s]."""
        return self._of_step(graph, step, self._command(step) if self.sends else self.torque)

    def _of_step(self, graph: ca.Function, step: float, command: Floats) -> Floats:
        world, motion = self.world, self.motion
        z = np.concatenate((motion.s, self._fast(0.0)[ROBOT:]))
        held = np.concatenate((command, np.zeros(world.held - COMMAND)))
        numbers = self.numbers(world, step)
        return evaluated(graph, 0, z, motion.theta, held, numbers, motion.v_d)[0]

    def _command(self, step: float) -> Floats:
        """Velocity (2) that keeps the robot's over a plant step when it is sent [m/s, rad/s]."""
        world, v = self.world, np.array(self.motion.v)
        robot, sent = slice(ROBOT - COMMAND, ROBOT), slice(world.size, world.size + COMMAND)
        graphs = (world.step, world.slopes)
        after, slopes = (self._of_step(graph, step, v)[robot] for graph in graphs)
        missing = np.linalg.lstsq(slopes[:, sent], v - after.ravel(), rcond=None)[0]
        return np.asarray(v + missing)

    @cached_property
    def _flows(self) -> dict[float, tuple[Floats, Floats]]:
        return {}

    def flow(self, time: float) -> tuple[Floats, Floats]:
        """The fast state after a time [s] by that before, and by the held inputs."""
        if time not in self._flows:
            self._flows[time] = self._flow(time)
        return self._flows[time]

    def _flow(self, time: float) -> tuple[Floats, Floats]:
        world, count = self.world, steps_in(time, self.step)
        whole = np.eye(world.size + world.held)
        whole[: world.size] = self._step(world.slopes, time / count)
        whole = np.linalg.matrix_power(whole, count)
        return whole[: world.size, : world.size], whole[: world.size, world.size :]

    @cached_property
    def steady(self) -> list[Floats]:
        """What is `sensed` in a sample with a pose, and in one without."""
        return [self.sensed(self.every + k) for k in range(min(self.every, 2))]

    def sensed(self, sample: int) -> Floats:
        """Slopes of measurements, disturbances and memory after a sample."""
        if len(self.worlds) == 1:  # the same, in a tenth of the time
            return self._of(self.world, sample)
        size, shown = self.world.size, ROBOT + HELD
        each = [(weight, self._of(world, sample)) for weight, world in self.worlds]
        seen = sum(weight * slopes[:shown, :size] for weight, slopes in each)
        sides = [weight * slopes[:shown, size:] for weight, slopes in each]
        memory = _diagonal([slopes[shown:, size:] for _, slopes in each])
        after = np.vstack([slopes[shown:, :size] for _, slopes in each])
        return np.block([[seen, np.hstack(sides)], [after, memory]])

    def _of(self, world: World, sample: int) -> Floats:
        T, numbers, memory = self.period, self.numbers(world, self.step), world.start.copy()
        for k, back in ((0, 2 * T), (1, T)) if world.nonlinear else ():
            (shown,) = evaluated(world.shown, k, self._fast(back), memory, numbers)
            memory = shown.ravel()[ROBOT + HELD :]
        natural = {POSE: self._fast(T)[:3], SPEED: np.array(self.motion.v)}
        for item in world.slow:
            value = natural.get(item.signal.unit)
            if value is not None and len(value) == item.signal.size:
                memory[world.slow_rows[item.signal.name]] = value
        given = (sample, self._fast(0.0), memory, numbers, self.motion.e)
        return evaluated(world.sensed, *given)[0]

    def plant(self, delay: float, sample: int | None) -> SampledPlant:
        """All of it, but for what shows in nothing, and for the way, which has no origin."""
        after, size = 0 if sample is None else sample - self.every, self.world.size
        kept = 0 <= after < len(self.steady)
        seen = self.steady[after] if kept else self.sensed(self.every + after)
        whole, part = divided(delay, self.period)
        queue = whole + (part > 0)
        ends = np.cumsum([0, size, COMMAND * queue, seen.shape[1] - size]).tolist()
        fast, sent, slow = (slice(a, b) for a, b in pairwise(ends))
        unit, rows = np.eye(ends[-1] + COMMAND), np.zeros((ends[-1], ends[-1] + COMMAND))
        ages = by_age(unit, ends[-1], sent)
        rows[sent] = np.vstack(ages)[: COMMAND * queue]
        free, new = self.flow(self.period - part)
        rows[fast, fast], disturbed = free, new[:, COMMAND:]
        rows[fast] += new[:, :COMMAND] @ self.sent @ ages[whole]
        if part:
            first, old = self.flow(part)
            rows[fast, fast], disturbed = free @ first, disturbed + free @ old[:, COMMAND:]
            rows[fast] += free @ old[:, :COMMAND] @ self.sent @ ages[whole + 1]
        sensed = np.zeros((len(seen), ends[-1]))
        sensed[:, fast], sensed[:, slow] = seen[:, :size], seen[:, size:]
        rows[fast, : ends[-1]] += disturbed @ sensed[ROBOT : ROBOT + HELD]
        rows[slow, : ends[-1]] = sensed[ROBOT + HELD :]
        pushed = np.zeros((ends[-1], COMMAND))
        pushed[fast] = disturbed[:, :COMMAND] @ self.wheels
        names = (
            *self.world.names[ROBOT:],
            *(f"{SENT}{age}[{i}]" for age in range(1, queue + 1) for i in (1, 2)),
            *(name for _, world in self.worlds for name in names_of(world.slow)),
        )
        plant = SampledPlant(
            rows[:, : ends[-1]], rows[:, ends[-1] :], pushed, sensed[:ROBOT], names
        )
        return self._reduced(plant, self.steady, slow)

    def rates(self) -> tuple[Floats, Floats, Floats, tuple[str, ...]]:
        """Slopes of rates: the gradient of a plant step, by its length."""
        slopes, names = self._step(self.world.rate_slopes, 0.0), self.world.names
        used = [i for i, name in enumerate(names) if name not in (PATH.name, SKID.name)]
        free, torque, push = np.split(slopes[used], [len(names), len(names) + COMMAND], axis=1)
        named = tuple(names[i] for i in used[ROBOT:])
        forced, pushed = torque @ self.sent, push[:, :COMMAND] @ self.wheels
        for item in (forced, pushed):  # B1 times its inverse
            item[np.abs(item) < np.finfo(float).eps * np.abs(item).max()] = 0.0
        return free[:, used], forced, pushed, named

    def _reduced(self, plant: SampledPlant, steady: list[Floats], slow: slice) -> SampledPlant:
        """Without what no sensor shows in any sample, and without the way's origin."""
        names, size = self.world.names, self.world.size
        if PATH.name in names:
            plant = _without_origin(plant, names.index(PATH.name), slow)
        on, seen = plant.moved != 0, np.any([item != 0 for item in steady], axis=0)
        on[slow, :size] |= seen[ROBOT + HELD :, :size]
        on[slow, slow] |= seen[ROBOT + HELD :, size:]
        used = np.arange(len(on)) < ROBOT
        used |= (plant.measured != 0).any(axis=0)
        used[slow] |= seen[:ROBOT, size:].any(axis=0)
        never = [names.index(item.name) for item in (PATH, SKID) if item.name in names]
        before = None
        while before is None or (before != used).any():
            before = used.copy()
            used |= on[used].any(axis=0)
            used[never] = False
        i = np.flatnonzero(used)
        every = (*names[:ROBOT], *plant.names)
        return SampledPlant(
            plant.moved[np.ix_(i, i)], plant.forced[i], plant.pushed[i], plant.measured[:, i],
            tuple(every[k] for k in i[ROBOT:]),
        )  # fmt: skip


def _diagonal(blocks: Sequence[Floats]) -> Floats:
    """Square matrices along a diagonal."""
    ends = np.cumsum([0, *map(len, blocks)]).tolist()
    whole = np.zeros((ends[-1], ends[-1]))
    for block, (first, end) in zip(blocks, pairwise(ends), strict=True):
        whole[first:end, first:end] = block
    return whole


def _without_origin(plant: SampledPlant, way: int, memory: slice) -> SampledPlant:
    """The plant in which nothing depends on where the way is counted from.

    As much way more, in all that remembers it, is a state that stays and that nothing shows.
    """
    own, alike = plant.moved[memory, memory], np.eye(len(plant.moved))[way]
    alike[memory] = np.linalg.lstsq(np.eye(len(own)) - own, plant.moved[memory, way], rcond=None)[0]
    alike[np.abs(alike) < GRID] = 0.0
    moved, measured = plant.moved - np.outer(alike, plant.moved[way]), plant.measured.copy()
    moved[:, way] = measured[:, way] = 0.0
    forced, pushed = (item - np.outer(alike, item[way]) for item in (plant.forced, plant.pushed))
    return replace(plant, moved=moved, measured=measured, forced=forced, pushed=pushed)


def divided(value: float, period: float) -> tuple[int, float]:
    """Whole periods and the rest [s]; a rest next to none or to a period is none."""
    ratio = value / period
    whole = math.floor(ratio + GRID)
    rest = value - whole * period
    return whole, rest if rest > GRID * period else 0.0


def steps_in(time: float, step: float) -> int:
    """Plant steps next to ``step`` [s] into which a time [s] is divided."""
    return max(1, round(time / step))
