"""The sampled loop along any motion of its reference: nominal trajectory and gradients.

The reference's numbers at the samples define the motion.  Between two samples a robot without
deviation moves at one velocity ``way``, which ends at the later pose up to ``gap``.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np
from flint import arb

from wmr_ctrl.codegen.build import first_step_at
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.theory.checks.error_coordinates import COMMAND, ROBOT, Floats, carried
from wmr_ctrl.world.model.evaluate import InPlace, evaluated
from wmr_ctrl.world.references import sample
from wmr_ctrl.world.scenario import Scenario

from .condition import Asked
from .enclosure import BentEnclosure
from .loop import LawLoop
from .midradius import OUTWARD, ROUNDED, MidRadius
from .spans import MidRadiusGraph

UNSURE = 1e-12
"""Size far below all that matters."""
OPERATIONS = 16.0
"""Roundings of a coordinate in a step of `carried`."""

STEEP = 1.5
"""Growth of a force's remainder, from half a box to all of it, that divides the box."""
PARTS = 8
"""Parts of a divided box."""


@dataclass(frozen=True)
class RunMotion:
    """A reference over ``n`` samples.

    ``v_d`` and ``rate`` (n, 2) at the samples.  ``way`` (n + 1, 2): velocity from each sample to
    the next, and before the first one.  ``gap`` [m] (n): distance from the end of ``way`` to the
    next desired position.  ``reckoned`` [m] (n): the same for dead reckoning by ``way`` in one step
    per sample.  ``aside`` [m] (n): the largest of these distances at plant steps within a sample.
    ``robot`` (n, steps, 3): mass, inertia and friction at each plant step.
    """

    v_d: Floats
    rate: Floats
    way: Floats
    gap: Floats
    reckoned: Floats
    aside: Floats
    turned: Floats
    robot: Floats

    @cached_property
    def moved(self) -> list[int]:
        """Samples in which, or just before which, the robot changes."""
        bodies = self.robot
        within = (bodies != bodies[:, :1]).any(axis=(1, 2))
        within[1:] |= (bodies[1:, 0] != bodies[:-1, -1]).any(axis=1)
        return [int(k) for k in np.flatnonzero(within)]


def motion_of(scenario: Scenario) -> RunMotion:
    """The scenario's whole run."""
    clock, steps = scenario.clock, scenario.clock.substeps
    n, h = clock.samples, clock.plant
    times = np.arange(n * steps + 1, dtype=float) * h
    times[::steps] = np.arange(n + 1, dtype=float) * clock.control
    rows = sample(scenario, times)
    at, every = rows[::steps], rows
    turn = np.diff(at[:, 2]) / clock.control
    length = _chord(at[:-1, :3], at[1:, :3], turn, clock.control)
    way = np.stack([length, turn], axis=1)
    apart = _apart(at[:-1, :3], every, way, steps, h)
    reckoned = _apart(at[:-1, :3], at, way, 1, clock.control)[:, 0]
    straight = at[:-1, 2:3] + turn[:, None] * (np.arange(1, steps + 1) * h)
    turned = np.abs(every[1:, 2].reshape(n, steps) - straight).max(axis=1)
    turned += _rounding(every, 1)
    way = np.vstack([way[:1], way])
    return RunMotion(at[:-1, 3:5], at[:-1, 5:7], way, apart[:, -1], reckoned, apart.max(axis=1),
                     turned, _robots(scenario, n, steps))  # fmt: skip


def _chord(start: Floats, end: Floats, turn: Floats, period: float) -> Floats:
    """Signed velocity along an arc of a given turn whose chord has the length of the way."""
    half = turn * period / 2
    way = end[:, :2] - start[:, :2]
    angle = start[:, 2] + half
    along = -np.sin(angle) * way[:, 0] + np.cos(angle) * way[:, 1]
    return np.asarray(along / np.sinc(half / np.pi) / period)


def _apart(start: Floats, every: Floats, way: Floats, steps: int, h: float) -> Floats:
    """Distances (n, steps) [m] between desired and propagated position at each plant step."""
    pose, v, n = ca.SX.sym("pose", 3), ca.SX.sym("v", 2), len(start)
    course = [pose]
    for _ in range(steps):
        course.append(carried(course[-1], v, ca.SX(h)))
    graph = ca.Function("carried", [pose, v], [ca.vertcat(*(now[:2] for now in course[1:]))])
    (places,) = evaluated(graph.map(n), start, way)
    off = places.T.reshape(n, steps, 2) - every[1:, :2].reshape(n, steps, 2)
    return np.asarray(np.hypot(off[..., 0], off[..., 1]) + _rounding(every, steps))


def _rounding(poses: Floats, steps: int) -> float:
    """Largest rounding error of poses that are propagated over this number of steps in doubles."""
    return float(OPERATIONS * (steps + 1) * ROUNDED * (1 + np.abs(poses[:, :3]).max()))


def _robots(scenario: Scenario, n: int, steps: int) -> Floats:
    robot = scenario.robot
    rows = np.tile([robot.m, robot.I, robot.mu], (n * steps, 1))
    for change in scenario.changes:
        since = first_step_at(change.t, scenario.clock.plant)
        for place, name in enumerate(("m", "I", "mu")):
            if name in change.values():
                rows[since:, place] = change.values()[name]
    return rows.reshape(n, steps, 3)


class MovingCurve:
    """A graph of variables and of numbers that the motion changes: values, gradients, second
    derivatives.
    """

    def __init__(
        self, name: str, by: ca.SX, numbers: ca.SX, output: ca.SX, steep: tuple[slice, float]
    ) -> None:
        """Differentiate; ``steep``: outputs with friction, and a size that is negligible there."""
        self.steep, self.little = steep
        self.by, self.numbers, self.output = by, numbers, output
        self.shape = output.numel(), by.numel()
        slope = ca.jacobian(output, by)
        self.function = ca.Function("curve", [by, numbers], [ca.densify(output)])
        self._value = MidRadiusGraph(name, [by, numbers], ca.densify(output))
        self._slope = MidRadiusGraph(f"the slope of {name}", [by, numbers], slope)
        self._bend = BentEnclosure(f"the bend of {name}", [by, numbers], output, by)
        self.bends = np.array(self._bend.bends).reshape(-1, 3)
        self._rows = np.eye(self.shape[0])[self.bends[:, 0]]

    def value(self, by: MidRadius, numbers: MidRadius) -> MidRadius:
        """Values at points (..., n) for the motion's ``numbers`` (..., n)."""
        return self._value(_columns(by), _columns(numbers))

    def slopes(self, by: MidRadius, numbers: MidRadius) -> MidRadius:
        """Matrices (..., outputs, inputs) at points, for the motion's numbers."""
        result = self._slope(_columns(by), _columns(numbers))
        lead, (rows, columns) = result.middle.shape[:-1], self._slope.pattern
        middle, radius = np.zeros((2, *lead, *self.shape))
        middle[..., rows, columns], radius[..., rows, columns] = result.middle, result.radius
        return MidRadius(middle, radius)

    def bend(self, by: MidRadius, numbers: MidRadius) -> Floats:
        """Half the second derivatives over a box, in the order of ``bends`` (output, n, n)."""
        pairs = ((item.middle.tolist(), item.radius.tolist()) for item in (by, numbers))
        given = [[arb(*both) for both in zip(*parts, strict=True)] for parts in pairs]
        return np.array([0.5 * float(x.abs_upper()) * (1 + 2**-50) for x in self._bend(*given)])

    def bend_within(
        self, by: MidRadius, wide: Floats, numbers: MidRadius, *, fine: bool = False
    ) -> Floats:
        """A ``bend`` that is valid for deviations up to ``wide`` from any point in ``by``.

        A remainder is the integral of 1 - s times the second derivatives at s times the deviation.
        If s is split into m equal parts, the second derivatives on k/m of the box have the weight
        ((m + 1 - k)^2 - (m - k)^2) / m^2.
        """

        def on(share: float) -> Floats:
            return self.bend(MidRadius(by.middle, (by.radius + share * wide) * OUTWARD), numbers)

        products = np.outer(wide, wide)
        parts = [on(0.5), on(1.0)]
        half, whole = (self.remainders(item, products) for item in parts)
        if fine or (whole > STEEP * half + self.little)[self.steep].any():
            middle, last = parts
            parts = [on(k / PARTS) for k in range(1, PARTS)]
            parts[PARTS // 2 - 1 : PARTS // 2], parts[PARTS - 1 :] = [middle], [last]
        m = len(parts)
        weights = [((m - k) ** 2 - (m - k - 1) ** 2) / m**2 * (1 + 1e-14) for k in range(m)]
        return np.asarray(np.tensordot(weights, parts, 1) * (1 + 1e-14))

    def remainders(self, bend: Floats, products: Floats) -> Floats:
        """Linearisation remainder of each output, for products (..., n, n) of deviations."""
        _, i, j = self.bends.T
        return np.asarray((bend * products[..., i, j]) @ self._rows)


def _columns(points: MidRadius) -> list[MidRadius]:
    return [points[..., k] for k in range(points.middle.shape[-1])]


class MovingLoop(LawLoop):
    """A law's loop along a motion; graphs as in SampledLoop, by ``MovingCurve``."""

    def __init__(self, setup: Setup, motion: RunMotion, asked: Asked) -> None:
        """Compose the graphs."""
        super().__init__(setup, asked)
        self.motion = motion
        way, mu = ca.SX.sym("way", 2), ca.SX.sym("mu")
        by, after = self._step_graph(way, {"robot.mu": mu})
        self.step_curve = MovingCurve(
            "the robot", by, ca.vertcat(way, mu), after, (slice(3, 4), 1e-7)
        )
        v_d, rate, came = (ca.SX.sym(name, 2) for name in ("v_d", "rate", "came"))
        by, output, sizes, self.conditions = self._law_graph(v_d, rate, came)
        numbers = ca.vertcat(v_d, rate, came)
        self.law_curve = MovingCurve("the law", by, numbers, output, (slice(1), 0.01))
        self.sizes = MidRadiusGraph("the limits", [by, numbers], ca.densify(sizes))
        self.limit_sizes = ca.Function("limits", [by, numbers], [sizes])
        rest = [item.value for item in self.world.fast[5:]]
        begun = np.array(self.loop.core.x0)[: self.memory - self.filter]
        fast = np.concatenate((np.zeros(3), motion.v_d[0], *map(np.atleast_1d, rest)))
        if self.filter:
            begun = np.concatenate((begun, fast[:ROBOT]))
        self.start = np.concatenate((
            fast, np.zeros(COMMAND * self.queue), begun, np.zeros(self.acting),
        ))  # fmt: skip

    @cached_property
    def law_numbers(self) -> Floats:
        """Numbers of the law's graph at each sample (n, 6)."""
        motion = self.motion
        return np.hstack([motion.v_d, motion.rate, motion.way[:-1]])

    @cached_property
    def step_numbers(self) -> Floats:
        """Numbers of the step's graph at each plant step (n, steps, 3)."""
        motion, steps = self.motion, self.steps
        way = np.repeat(motion.way[1:, None], steps, axis=1)
        return np.concatenate([way, motion.robot[..., 2:]], axis=2)

    @cached_property
    def _sample(self) -> ca.Function:
        """Graph of the state a sample later, the fast state at plant steps, the law's outputs."""
        nz, nq, nm = len(self.names), COMMAND * self.queue, self.memory
        x, p = ca.MX.sym("x", len(self.start)), ca.MX.sym("p", 6)
        q = ca.MX.sym("q", 5, self.steps)
        z, sent, memory, acting = ca.vertsplit(x, [0, nz, nz + nq, nz + nq + nm, len(self.start)])
        out = self.law_curve.function(ca.vertcat(z[:ROBOT], memory, sent, acting), p)
        u = out[:COMMAND]
        queue = [u, *(ca.vertsplit(sent, COMMAND) if self.queue else [])]
        behind, rest = divmod(self.late, self.steps)
        course = [z]
        for s in range(self.steps):
            acts = queue[behind + (s < rest)]
            by = ca.vertcat(course[-1], acts, ca.MX.zeros(COMMAND), q[3:, s])
            course.append(self.step_curve.function(by, q[:3, s]))
        na = self.acting
        after = ca.vertcat(course[-1], *queue[: self.queue], out[COMMAND : COMMAND + nm + na])
        return ca.Function("sample", [x, p, q], [after, ca.horzcat(*course), out]).expand()

    @cached_property
    def _given(self) -> tuple[Floats, Floats]:
        """Numbers of the law and of the plant steps, one row per sample."""
        given = np.concatenate([self.step_numbers, self.motion.robot[..., :2]], axis=2)
        return self.law_numbers, given.reshape(len(given), -1)

    def sampled(self, k: int) -> Callable[[Floats], Floats]:
        """Function from the state at sample ``k`` to the state a sample later."""
        law, steps = (part[k] for part in self._given)
        return lambda x: evaluated(self._sample, x, law, steps)[0].ravel()

    def undisturbed(self) -> tuple[Floats, Floats, Floats]:
        """Nominal trajectory: state at n + 1 samples, fast state at plant steps, law's outputs."""
        n, graph = len(self.motion.v_d), self._sample
        state, law, steps = (np.zeros(graph.nnz_in(k)) for k in range(3))
        answers = [np.zeros(graph.nnz_out(k)) for k in range(3)]
        run = InPlace(graph, (state, law, steps), answers)
        states, fine, outs = (np.empty((n, len(item))) for item in answers)
        state[:] = self.start
        for k, (law[:], steps[:]) in enumerate(zip(*self._given, strict=True)):
            run()
            states[k], fine[k], outs[k] = answers
            state[:] = states[k]
        course = fine.reshape(n, self.steps + 1, len(self.names))
        return np.vstack([self.start, states]), course, outs
