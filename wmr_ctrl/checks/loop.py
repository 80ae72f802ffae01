"""Loop: a law's graph in error coordinates, evaluated where the checks ask; and where it starts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.checks.lateness import WINDOW, Lateness, is_one_sample, lateness_of
from wmr_ctrl.control.applied import remembered
from wmr_ctrl.control.controller import law_graph
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.laws.law import Traits, commands_predicted
from wmr_ctrl.model.auxiliary import auxiliary_rate, auxiliary_velocity
from wmr_ctrl.model.dynamics import force_to_wheel, friction
from wmr_ctrl.model.system import Port, System
from wmr_ctrl.model.tracking import error_rotation, tracking_error
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.world.references import sample

Floats = NDArray[np.float64]

PERIOD = "clock.control"


@dataclass(frozen=True)
class StartPoint:
    """Reference (7) at t = 0, tracking error e (3) [m, m, rad], v and v_c0 (2) [m/s, rad/s]."""

    reference: Floats
    e: Floats
    v: Floats
    v_c0: Floats


@dataclass(frozen=True)
class Loop:
    """A law on a scenario, settled.

    Estimates and weights of a law that learns keep their start values; any other memory (a
    previous sample, a filter) is part of the loop.  ``under_way`` commands are what its graph
    predicts over; those of the scenario's clock unless given.
    """

    setup: Setup
    under_way: int | None = None

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
        """What the law is, as its author states it."""
        return self.setup.control_law.traits

    @cached_property
    def core(self) -> System:
        """The law's System, whose output is the generalised force."""
        return law_graph(self.setup, self.under_way)

    def commands(self, period: float) -> int:
        """Commands under way over which the law predicts at a control period [s]."""
        return commands_predicted(self.setup.gains, period)

    def over(self, commands: int) -> Loop:
        """The same law, built to predict over so many commands."""
        return self if commands == self.predicted else _built_over(self.setup, commands)

    @property
    def predicted(self) -> int:
        """Commands over which its graph predicts."""
        return self.setup.predicted if self.under_way is None else self.under_way

    @property
    def has_barrier(self) -> bool:
        """Whether a barrier pulls the auxiliary velocity of Eq. (7) back from the limits."""
        return self.traits.barrier and self.traits.auxiliary

    @property
    def equations(self) -> str:
        """Those of the linear loop: robot, outer loop where it is Eq. (7), tracking error."""
        outer = "(7), " if self.traits.auxiliary else ""
        return f"Eqs. (4), {outer}(33)-(35)"

    @cached_property
    def start(self) -> StartPoint:
        """Where the run starts, seen from the reference."""
        return start_point(self.setup)

    @property
    def lateness(self) -> Lateness:
        """How late commands act and velocities are seen."""
        return lateness_of(self.setup)

    @property
    def late_words(self) -> dict[str, float]:
        """What is late [s], by word; a window of one sample goes with the period itself."""
        words, period = dict(self.lateness.words), self.scenario.clock.control
        if is_one_sample(words.get(WINDOW, 0.0), period):
            del words[WINDOW]
        return words

    def lateness_at(self, period: float) -> Lateness:
        """The same at another control period [s]."""
        return lateness_of(self.setup, period)

    @property
    def guarded(self) -> bool:
        """Whether the guard stands between the law and the wheels."""
        return self.scenario.guard.enabled

    def uses(self, prefix: str) -> bool:
        """Whether the force depends on a parameter whose key starts with ``prefix``."""
        force = self.core.outputs[0].expr
        named = (port for port in self.core.params if port.signal.name.startswith(prefix))
        return any(ca.depends_on(force, port.sym) for port in named)

    def feedback(self, v_d: Floats, period: float) -> Floats:
        """Gradient of force and next memory at e = 0, v = v_d, sampled with ``period`` [s].

        Rows: force (2), then the memory (n) unless it holds estimates; columns: e (3), v (2), the
        memory, then the force (2) that acted before and the forces (2) that were sent, the latest
        first, as far as the law asks for them.  ``v_d`` (2) in m/s, rad/s.
        """
        loop, s = self.over(self.commands(period)), np.concatenate((np.zeros(3), v_d))
        memory, numbers = loop._memory(v_d), loop._parameters(period)
        return np.asarray(loop._gradient(s, v_d, memory, numbers))

    def force_towards(self, v: Floats, v_c0: Floats) -> Floats:
        """Force (2, N) [N, N m] at velocities ``v`` (2, N), for an auxiliary velocity that stays.

        ``v_c0`` (2) is that velocity; both in m/s, rad/s.
        """
        core = self.over(0).core
        return np.asarray(self.over(0)._towards(v, v_c0, core.x0, core.p0)[0])

    def slope_towards(self, v: Floats, v_c0: Floats) -> Floats:
        """Its derivative (2) by each axis' own velocity at ``v`` (2) [N s/m, N m s/rad]."""
        core = self.over(0).core
        return np.asarray(self.over(0)._towards(v, v_c0, core.x0, core.p0)[1]).ravel()

    @cached_property
    def _gradient(self) -> ca.Function:
        s, v_d = ca.SX.sym("s", 5), ca.SX.sym("v_d", 2)
        asked = [item.signal.name for item in remembered(self.core)]
        forces = [ca.SX.sym(name, 2) for name in asked]
        known = dict(zip(asked, forces, strict=True))
        force, following = self._act(s[:3], s[3:], v_d, ca.SX.zeros(2), known)
        x, answers, causes = self.core.x, force, s
        if not self.traits.estimates:
            answers, causes = ca.vertcat(force, following), ca.vertcat(s, x)
        gradient = ca.jacobian(answers, ca.vertcat(causes, *forces))
        steady = ca.repmat(self._drag(v_d), len(forces), 1)
        gradient = ca.substitute(gradient, ca.vertcat(*forces), steady) if forces else gradient
        return ca.Function("gradient", [s, v_d, x, self.core.p], [gradient])

    def _drag(self, v: ca.SX) -> ca.SX:
        """The force (2) that the law takes friction for: what acts while v stays."""
        bot = self.scenario.believed
        return friction(ca.SX(bot.mu), ca.SX(bot.m), ca.SX(bot.g), ca.SX(bot.v_s), v)

    @cached_property
    def _towards(self) -> ca.Function:
        """At e = 0 the auxiliary velocity is v_d, and v_d' can be chosen such that it stays."""
        v, v_c0 = ca.SX.sym("v", 2), ca.SX.sym("v_c0", 2)
        e, k = ca.SX.zeros(3), ca.SX(ca.DM(self.setup.kinematics.k))
        moving = auxiliary_rate(e, v, v_c0, ca.SX.zeros(2), k)
        force, _ = self._act(e, v, v_c0, -moving)
        slope = ca.diag(ca.jacobian(force, v))
        return ca.Function("towards", [v, v_c0, self.core.x, self.core.p], [force, slope])

    def _act(
        self,
        e: ca.SX,
        v: ca.SX,
        v_d: ca.SX,
        v_d_dot: ca.SX,
        before: Mapping[str, ca.SX] | None = None,
    ) -> tuple[ca.SX, ca.SX]:
        """Force and next memory with the robot at the origin and the reference placed to give e.

        ``before``: forces (2,) by the names of the torques that the law remembers; none unless
        given.
        """
        pose_d, robot = error_rotation(ca.SX(0)).T @ e, self.scenario.robot
        known = dict(zip(INPUTS, ca.vertsplit(ca.vertcat(pose_d, v_d, v_d_dot, v)), strict=True))
        for name, force in (before or {}).items():
            known[name] = force_to_wheel(ca.SX(robot.r), ca.SX(robot.l), force)
        signals = (port.signal for port in self.core.inputs)
        u = ca.vertcat(*(known.get(item.name, ca.SX.zeros(item.size)) for item in signals))
        act = self.core.function("act", [self.core.outputs[0].expr, self.core.update])
        force, following = act(u, self.core.x, self.core.p)
        return force, following

    @cached_property
    def _next(self) -> ca.Function:
        v_d, zero = ca.SX.sym("v_d", 2), ca.SX.zeros(3)
        steady = {item.signal.name: self._drag(v_d) for item in remembered(self.core)}
        _, following = self._act(zero, v_d, v_d, ca.SX.zeros(2), steady)
        return ca.Function("next", [v_d, self.core.x, self.core.p], [following])

    def _memory(self, v_d: Floats) -> Floats:
        """The law's memory on the reference: its start value, or what one sample there leaves."""
        start = np.array(self.core.x0)
        if self.traits.estimates:
            return start
        return np.asarray(self._next(v_d, start, self.core.p0)).ravel()

    def _parameters(self, period: float) -> list[float]:
        return [number for port in self.core.params for number in _with_period(port, period)]


@lru_cache(maxsize=128)
def _built_over(setup: Setup, commands: int) -> Loop:
    return Loop(setup, commands)


INPUTS = ("x_d", "y_d", "theta_d", "v1_d", "v2_d", "v1_d_dot", "v2_d_dot", "v1", "omega")
"""Inputs of a law that are not zero when the robot stands at the origin along +Y."""


def _with_period(port: Port, period: float) -> tuple[float, ...]:
    return (period,) if port.signal.name == PERIOD else port.value


def start_point(setup: Setup) -> StartPoint:
    """The scenario at t = 0: Eqs. (8) and (7) there."""
    scenario = setup.scenario
    reference = sample(scenario, np.zeros(1))[0]
    e = tracking_error(_sx(reference[:3]), _sx(scenario.initial.pose))
    v_c0 = auxiliary_velocity(e, _sx(reference[3:5]), _sx(setup.kinematics.k))
    return StartPoint(reference, _flat(e), np.array(scenario.initial.velocity), _flat(v_c0))


def _sx(numbers: Sequence[float] | Floats) -> ca.SX:
    return ca.SX(ca.DM(numbers))


def _flat(column: ca.SX) -> Floats:
    return np.asarray(ca.evalf(column)).ravel()
