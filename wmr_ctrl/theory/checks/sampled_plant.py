"""Robot, drives and sensors over one control sample, linearised from their graphs.

Plant steps are joined between the times at which commands take effect; commands in transit are a
shift register.
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

from wmr_ctrl.core.signals import PATH, SKID, TORQUE, places
from wmr_ctrl.world.model.evaluate import evaluated
from wmr_ctrl.world.model.system import values

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
"""Name of a command in transit, before its age."""


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

    The force is what the law receives as applied and sent; ``theta`` [rad] is the reference's
    orientation, if the plant depends on it.
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
        """The motion part of the point."""
        e, v, v_d = (tuple(map(float, item)) for item in (self.e, self.v, self.v_d))
        return Motion(e, v, v_d, self.theta)


@dataclass(frozen=True)
class SampledPlant:
    """Linear plant: x_next = moved x + forced u + pushed d, command u, disturbance d [N, N m].

    ``measured`` x is tracking error and velocity as sensors show them (5).  The first elements of x
    are those of the robot; ``names`` has one for each further element.
    """

    moved: Floats
    forced: Floats
    pushed: Floats
    measured: Floats
    names: tuple[str, ...]

    @property
    def sent(self) -> NDArray[np.intp]:
        """Indices of the commands in transit, the latest first."""
        in_flight = [name.startswith(SENT) for name in self.names]
        return ROBOT + np.flatnonzero(in_flight)


def by_age(unit: Floats, now: int, sent: slice) -> list[Floats]:
    """Rows that select commands by age: first the one at index ``now``, then those in the state."""
    queue = unit[sent]
    return [
        unit[now : now + COMMAND],
        *(queue[i : i + COMMAND] for i in range(0, len(queue), COMMAND)),
    ]


@dataclass(frozen=True)
class Assembly:
    """Builder of a SampledPlant, block by block: fast state, commands sent, slow state.

    ``worlds``: with weights.  ``every``: samples from one pose to the next.  ``step``: approximate
    plant step [s].  ``numbers``: a world's parameters, as a function of the step.  ``sent``: held
    inputs per command (2, 2).  ``wheels``: torques per force (2, 2).  ``torque`` (2): torque that
    keeps the velocity [N m].  ``sends``: velocities are commanded.
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
        """One of the worlds, all of which have the same fast state."""
        return self.worlds[0][1]

    def _fast(self, back: float) -> Floats:
        """The fast state ``back`` [s] earlier, with drives at the velocity's steady torque."""
        (v, omega), world = self.motion.v, self.world
        theta = self.motion.theta - omega * back
        known = {"x": v * back * math.sin(theta), "y": -v * back * math.cos(theta), "theta": theta,
                 "v1": v, "omega": omega, PATH.name: -v * back}  # fmt: skip
        state, rows = np.zeros(world.size), places(item.signal for item in world.fast)
        for item in world.fast:
            name, unit, size = item.signal.name, item.signal.unit, item.signal.size
            torque = unit == TORQUE[0].unit and size == COMMAND
            state[rows[name]] = self.torque if torque else known.get(name, item.value)
        return state

    def _step(self, graph: ca.Function, step: float) -> Floats:
        """Output of a plant-step graph for a step of ``step`` [s]."""
        return self._of_step(graph, step, self._command(step) if self.sends else self.torque)

    def _of_step(self, graph: ca.Function, step: float, command: Floats) -> Floats:
        world, motion = self.world, self.motion
        z = np.concatenate((motion.s, self._fast(0.0)[ROBOT:]))
        held = np.concatenate((command, np.zeros(world.held - COMMAND)))
        numbers = self.numbers(world, step)
        return evaluated(graph, 0, z, motion.theta, held, numbers, motion.v_d)[0]

    def _command(self, step: float) -> Floats:
        """Velocity command (2) that keeps the robot's velocity over a plant step [m/s, rad/s]."""
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
        """Gradient of the fast state after a time [s] by its initial value and held inputs."""
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
        """The matrices `sensed` of a sample with a pose, and of one without."""
        return [self.sensed(self.every + k) for k in range(min(self.every, 2))]

    def sensed(self, sample: int) -> Floats:
        """Gradient of measurements, disturbances and memory after a sample."""
        if len(self.worlds) == 1:  # the same, in a tenth of the time
            return self._of(self.world, sample)
        from scipy.linalg import block_diag  # slow to import, and seldom needed

        size, shown = self.world.size, ROBOT + HELD
        each = [(weight, self._of(world, sample)) for weight, world in self.worlds]
        seen = sum(weight * slopes[:shown, :size] for weight, slopes in each)
        sides = [weight * slopes[:shown, size:] for weight, slopes in each]
        memory = block_diag(*(slopes[shown:, size:] for _, slopes in each))
        after = np.vstack([slopes[shown:, :size] for _, slopes in each])
        return np.block([[seen, np.hstack(sides)], [after, memory]])

    def _of(self, world: World, sample: int) -> Floats:
        T, numbers = self.period, self.numbers(world, self.step)
        memory, rows = np.array(values(world.slow)), places(item.signal for item in world.slow)
        for k, back in ((0, 2 * T), (1, T)) if world.nonlinear else ():
            (shown,) = evaluated(world.shown, k, self._fast(back), memory, numbers)
            memory = shown.ravel()[ROBOT + HELD :]
        natural = {POSE: self._fast(T)[:3], SPEED: np.array(self.motion.v)}
        for item in world.slow:
            value = natural.get(item.signal.unit)
            if value is not None and len(value) == item.signal.size:
                memory[rows[item.signal.name]] = value
        given = (sample, self._fast(0.0), memory, numbers, self.motion.e)
        return evaluated(world.sensed, *given)[0]

    def plant(self, delay: float, sample: int | None) -> SampledPlant:
        """The full plant without unobservable states and without the absolute path length."""
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
        """Gradient of the rates, by the derivative of a plant step with respect to its length."""
        slopes, names = self._step(self.world.rate_slopes, 0.0), self.world.names
        used = [i for i, name in enumerate(names) if name not in (PATH.name, SKID.name)]
        free, torque, push = np.split(slopes[used], [len(names), len(names) + COMMAND], axis=1)
        named = tuple(names[i] for i in used[ROBOT:])
        forced, pushed = torque @ self.sent, push[:, :COMMAND] @ self.wheels
        for item in (forced, pushed):  # B1 times its inverse
            item[np.abs(item) < np.finfo(float).eps * np.abs(item).max()] = 0.0
        return free[:, used], forced, pushed, named

    def _reduced(self, plant: SampledPlant, steady: list[Floats], slow: slice) -> SampledPlant:
        """The plant without states that no sensor ever shows, and without the path's origin."""
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


def _without_origin(plant: SampledPlant, way: int, memory: slice) -> SampledPlant:
    """Change coordinates such that nothing depends on the absolute path length.

    Adding a constant to the path length, and to all memories of it, changes no output.
    """
    own, alike = plant.moved[memory, memory], np.eye(len(plant.moved))[way]
    alike[memory] = np.linalg.lstsq(np.eye(len(own)) - own, plant.moved[memory, way], rcond=None)[0]
    alike[np.abs(alike) < GRID] = 0.0
    moved, measured = plant.moved - np.outer(alike, plant.moved[way]), plant.measured.copy()
    moved[:, way] = measured[:, way] = 0.0
    forced, pushed = (item - np.outer(alike, item[way]) for item in (plant.forced, plant.pushed))
    return replace(plant, moved=moved, measured=measured, forced=forced, pushed=pushed)


def divided(value: float, period: float) -> tuple[int, float]:
    """Number of whole periods and the rest [s]; a rest close to 0 or to a period becomes 0."""
    ratio = value / period
    whole = math.floor(ratio + GRID)
    rest = value - whole * period
    return whole, rest if rest > GRID * period else 0.0


def steps_in(time: float, step: float) -> int:
    """Number of plant steps of about ``step`` [s] that divide a time [s]."""
    return max(1, round(time / step))
