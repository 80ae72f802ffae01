"""A law's graph in error coordinates, its linear closed loop, and its start."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.control.applied import remembered
from wmr_ctrl.control.controller import law_graph
from wmr_ctrl.control.laws.law import Traits, commands_predicted
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.world.model import kinematics
from wmr_ctrl.world.model.dynamics import force_to_wheel
from wmr_ctrl.world.model.evaluate import evaluated
from wmr_ctrl.world.model.system import Port, System
from wmr_ctrl.world.phases import drag
from wmr_ctrl.world.references import sample
from wmr_ctrl.world.scenario import Robot, Scenario

from .error_coordinates import COMMAND, ROBOT, Floats
from .sampled_plant import Point
from .surroundings import DriveTimes, Surroundings, surroundings

PERIOD = "clock.control"
IntArray = NDArray[np.intp]


@dataclass(frozen=True)
class StartPoint:
    """Reference (7) at t = 0, tracking error e (3) [m, m, rad], v and v_c0 (2) [m/s, rad/s]."""

    reference: Floats
    e: Floats
    v: Floats
    v_c0: Floats


@dataclass(frozen=True)
class LinearLaw:
    """Linear law: m_next = a m + b s, force = c m + d s; s = measured (e, v) (5), memory m.

    The last ``sent`` elements of m are commands, the latest first.
    """

    a: Floats
    b: Floats
    c: Floats
    d: Floats
    sent: int = 0


@dataclass(frozen=True)
class Loop:
    """A law on a scenario, with all its settings derived.

    Estimates and weights of a law that learns keep their start values; any other memory (a previous
    sample, a filter) is part of the loop.  ``in_flight``: number of commands over which its graph
    predicts; default: that of the scenario's clock.
    """

    setup: Setup
    in_flight: int | None = None

    @property
    def scenario(self) -> Scenario:
        """The scenario."""
        return self.setup.scenario

    @property
    def law(self) -> str:
        """Name of the law."""
        return self.setup.name

    @property
    def traits(self) -> Traits:
        """Traits stated by the law's author."""
        return self.setup.control_law.traits

    @cached_property
    def core(self) -> System:
        """The law's System, whose output is the generalised force."""
        return law_graph(self.setup, self.in_flight)

    @cached_property
    def remembered(self) -> tuple[Port, ...]:
        """Inputs of the law that are torques applied or sent."""
        return remembered(self.core)

    @cached_property
    def around(self) -> Surroundings:
        """Robot, drives and sensors, linearised."""
        return surroundings(self.scenario)

    def over(self, commands: int) -> Loop:
        """The loop of a law built to predict over this number of commands."""
        own = self.setup.predicted if self.in_flight is None else self.in_flight
        return self if commands == own else _over(self, commands)

    def at_period(self, period: float) -> Loop:
        """The loop for a control period [s]; a law remembers as many commands as are in transit."""
        return self

    @property
    def longest(self) -> float:
        """Longest control period [s] for which each command is held until the next one arrives."""
        return np.inf

    def with_delay(self, delay: float) -> Loop:
        """The loop of a law that assumes a ``delay`` [s], if its graph depends on that."""
        return self

    @property
    def has_barrier(self) -> bool:
        """True if a barrier pulls the auxiliary velocity of Eq. (7) back from the limits."""
        return self.traits.barrier and self.traits.auxiliary

    @property
    def equations(self) -> str:
        """Equations of the linear loop: robot, outer loop if it is Eq. (7), tracking error."""
        outer = "(7), " if self.traits.auxiliary else ""
        return f"Eqs. (4), {outer}(33)-(35)"

    @cached_property
    def start(self) -> StartPoint:
        """Start relative to the reference: Eqs. (8) and (7) at t = 0."""
        scenario, k = self.scenario, ca.DM(self.setup.kinematics.k)
        reference = sample(scenario, np.zeros(1))[0]
        pose_d, v_d = ca.DM(reference[:3]), ca.DM(reference[3:5])
        e = kinematics.tracking_error(ca.SX(pose_d), ca.SX(ca.DM(scenario.initial.pose)))
        v_c0 = kinematics.auxiliary_velocity(e, ca.SX(v_d), ca.SX(k))
        flat = [np.asarray(ca.evalf(item)).ravel() for item in (e, v_c0)]
        return StartPoint(reference, flat[0], np.array(scenario.initial.velocity), flat[1])

    @property
    def guarded(self) -> bool:
        """True if the guard is between the law and the wheels."""
        return self.scenario.guard.enabled

    def uses(self, prefix: str) -> bool:
        """True if the force depends on a parameter whose key starts with ``prefix``."""
        force = self.core.outputs[0].expr
        named = (port for port in self.core.params if port.signal.name.startswith(prefix))
        return any(ca.depends_on(force, port.sym) for port in named)

    @np.errstate(over="ignore", invalid="ignore")  # what is not finite is no stable loop
    def closed(
        self,
        at: Point,
        period: float,
        *,
        drives: DriveTimes | None = None,
        robot: Robot | None = None,
        sample: int | None = None,
        law: LinearLaw | None = None,
    ) -> Floats:
        """Matrix of the loop from one ``sample`` to the next, near a point.

        Its state is that of `Surroundings.plant`, error and velocity (5) first, then the law's
        memory.  ``drives`` and ``robot`` default to the scenario's; the law keeps its own model.
        The default sample is one with a new pose; the default ``law`` is `linear`.
        """
        law = law or self.linear(at, period, drives=drives)
        plant = self.around.plant(at.motion, period, drives=drives, robot=robot, sample=sample)
        n, size = len(plant.moved), len(plant.moved) + len(law.a)
        whole = np.empty((size, size))
        whole[:n, :n] = plant.moved + plant.forced @ law.d @ plant.measured
        whole[:n, n:], whole[n:, n:] = plant.forced @ law.c, law.a
        whole[n:, :n] = law.b @ plant.measured
        first, second = plant.sent[: law.sent], np.arange(size - law.sent, size)
        if not len(first):
            return whole
        # A matrix without the elements ``first`` that are the leading ones of ``second`` too.
        whole[:, second[: len(first)]] += whole[:, first]
        return np.delete(np.delete(whole, first, 0), first, 1)

    def linear(
        self,
        at: Point,
        period: float,
        *,
        drives: DriveTimes | None = None,
        learning: bool = False,
        commands: int | None = None,
    ) -> LinearLaw:
        """The law near a point for a ``period`` [s]; its memory includes what its drives report to
        it.

        Estimates and weights stay as they are, unless the law is ``learning``.  It predicts over
        ``commands``; default: the number that the period leaves in transit.
        """
        count = commands_predicted(self.setup.gains, period) if commands is None else commands
        law, moving = self.over(count), learning or not self.traits.estimates
        asked = law.remembered
        if (at, period, moving) not in law._slopes:
            law._slopes[at, period, moving] = law._slopes_at(at, period, moving)
        whole = law._slopes[at, period, moving]
        n = ROBOT + len(whole) - COMMAND
        force, memory = whole[:COMMAND], whole[COMMAND:]
        if not asked:
            return LinearLaw(
                memory[:, ROBOT:n], memory[:, :ROBOT], force[:, ROBOT:n], force[:, :ROBOT]
            )
        late = self.around.drives if drives is None else drives
        behind = self.around.known_of_drives(period, late, len(asked) > count, count)
        own, known = np.vstack((memory, behind.forced @ force)), whole[:, n:] @ behind.known
        after = np.vstack((known[COMMAND:], behind.moved + behind.forced @ known[:COMMAND]))
        return LinearLaw(
            np.hstack((own[:, ROBOT:n], after)), own[:, :ROBOT],
            np.hstack((force[:, ROBOT:n], known[:COMMAND])), force[:, :ROBOT],
            behind.sent,
        )  # fmt: skip

    def on_reference(self, v_d: Floats, theta: float = 0.0) -> Point:
        """The operating point on the reference at v_d (2), with the law's start memory or that
        after a sample.

        The forces that it remembers are the friction that it assumes.  ``theta`` [rad] matters only
        if the plant depends on it.
        """
        key = tuple(map(float, v_d))
        if key not in self._points:
            speed = np.array(key)
            force = drag(self.scenario.believed, speed)[:, 0]
            memory = np.array(self.core.x0)
            there = Point(np.zeros(3), speed, speed, np.zeros(2), memory, force)
            self._points[key] = replace(self.after_a_sample(there), force=force)
        return self._points[key].turned(theta)

    def resting(
        self, v_d: Floats, theta: float, period: float, robot: Robot | None = None
    ) -> Point | None:
        """The point to linearise at for a ``period`` [s] and a ``robot``; None if there is none.

        For a base that takes torques it is `on_reference`, where the loop's slopes are nearly those
        of the equilibrium.
        """
        return self.on_reference(v_d, theta)

    @property
    def learns(self) -> bool:
        """True if estimates and weights are states of the linear loop, not constants."""
        return False

    @cached_property
    def _slopes(self) -> dict[tuple[Point, float, bool], Floats]:
        return {}

    def _slopes_at(self, at: Point, period: float, learning: bool) -> Floats:
        """Gradient of the force, and of the memory if it changes, by s, memory and forces."""
        graph = self._gradient_learning if learning else self._gradient
        forces, numbers = np.tile(at.force, len(self.remembered)), self.parameters(period)
        return evaluated(graph, at.s, at.v_d, at.v_d_dot, at.memory, forces, numbers)[0]

    @cached_property
    def _points(self) -> dict[tuple[float, ...], Point]:
        return {}

    def after_a_sample(self, point: Point) -> Point:
        """The point with the memory that a sample leaves there, and the force that the law
        commands.

        Estimates keep their values.
        """
        forces = np.tile(point.force, len(self.remembered))
        force, memory = evaluated(
            self.act, point.s, point.v_d, point.v_d_dot, point.memory, forces,
            self.parameters(self.own_period),
        )  # fmt: skip
        after = point.memory if self.traits.estimates else memory.ravel()
        return replace(point, memory=after, force=force.ravel())

    def force_towards(self, v: Floats, v_c0: Floats, period: float | None = None) -> Floats:
        """Force (2, N) [N, N m] at velocities ``v`` (2, N), for a constant auxiliary velocity.

        ``v_c0`` (2) is that velocity; both in m/s, rad/s.  ``period`` defaults to the clock's.
        """
        return self._near(v, v_c0, period)[0]

    def slope_towards(self, v: Floats, v_c0: Floats, period: float | None = None) -> Floats:
        """Derivative (2) of that force by each axis' velocity at ``v`` (2) [N s/m, N m s/rad]."""
        return self._near(v, v_c0, period)[1].ravel()

    def _near(self, v: Floats, v_c0: Floats, period: float | None) -> list[Floats]:
        law = self.over(0)
        numbers = law.parameters(self.scenario.clock.control if period is None else period)
        given = (v, v_c0, law.core.x0, numbers)
        if np.size(v) == COMMAND:
            return evaluated(law._towards, *given)
        return [np.asarray(item) for item in law._towards(*given)]

    @cached_property
    def act(self) -> ca.Function:
        """Force and next memory as functions of (e, v) (5), v_d (2), its rate (2), memory, forces,
        parameters.

        The robot is at the origin along +Y, and the reference is placed such that e results.  The
        forces are those that the law remembers.
        """
        s, v_d, rate = ca.SX.sym("s", ROBOT), ca.SX.sym("v_d", 2), ca.SX.sym("r", 2)
        core = self.core
        pose_d, robot = kinematics.error_rotation(ca.SX(0)).T @ s[:3], self.scenario.robot
        known = dict(zip(INPUTS, ca.vertsplit(ca.vertcat(pose_d, v_d, rate, s[3:])), strict=True))
        names = [item.signal.name for item in self.remembered]
        forces = ca.SX.sym("forces", 2 * len(names))
        for name, force in zip(names, ca.vertsplit(forces, 2) if names else (), strict=True):
            known[name] = force_to_wheel(ca.SX(robot.r), ca.SX(robot.l), force)
        signals = (port.signal for port in core.inputs)
        u = ca.vertcat(*(known.get(item.name, ca.SX.zeros(item.size)) for item in signals))
        asked = core.function("asked", [core.outputs[0].expr, core.update])(u, core.x, core.p)
        return ca.Function("act", [s, v_d, rate, core.x, forces, core.p], [*map(ca.densify, asked)])

    def _differentiated(self, learning: bool) -> ca.Function:
        given = [ca.SX.sym(f"i{k}", *self.act.size_in(k)) for k in range(self.act.n_in())]
        force, following = self.act(*given)
        s, memory, forces = given[0], given[3], given[4]
        of = ca.vertcat(force, following) if learning else force
        by = ca.vertcat(s, *([memory] if learning else []), forces)
        return ca.Function("gradient", given, [ca.densify(ca.jacobian(of, by))])

    @cached_property
    def _gradient(self) -> ca.Function:
        return self._differentiated(learning=False)

    @cached_property
    def _gradient_learning(self) -> ca.Function:
        return self._differentiated(learning=True)

    @cached_property
    def _towards(self) -> ca.Function:
        """Graph at e = 0, where the auxiliary velocity is v_d, constant for a suitable v_d'."""
        v, v_c0, core = ca.SX.sym("v", 2), ca.SX.sym("v_c0", 2), self.core
        e, k = ca.SX.zeros(3), ca.SX(ca.DM(self.setup.kinematics.k))
        rate = -kinematics.auxiliary_rate(e, v, v_c0, ca.SX.zeros(2), k)
        forces = ca.SX.zeros(2 * len(self.remembered))
        force, _ = self.act(ca.vertcat(e, v), v_c0, rate, core.x, forces, core.p)
        slope = ca.densify(ca.diag(ca.jacobian(force, v)))
        return ca.Function("towards", [v, v_c0, core.x, core.p], [force, slope])

    def parameters(self, period: float) -> list[float]:
        """Values of the law's parameters with a control period [s]."""
        listed = ((port.signal.name, port.value) for port in self.core.params)
        return [n for name, own in listed for n in ((period,) if name == PERIOD else own)]

    @property
    def own_period(self) -> float:
        """Control period [s] that the law is built for."""
        return self.scenario.clock.control


@lru_cache(maxsize=128)
def _over(loop: Loop, commands: int) -> Loop:
    return replace(loop, in_flight=commands)


INPUTS = ("x_d", "y_d", "theta_d", "v1_d", "v2_d", "v1_d_dot", "v2_d_dot", "v1", "omega")
"""Inputs of a law that are not zero when the robot stands at the origin along +Y."""
