"""LawContext: a law's inputs at one control sample, and how its System is put together."""

from collections.abc import Sequence
from copy import copy
from functools import cached_property
from typing import Protocol, TypeVar

import casadi as ca

from wmr_ctrl.control.barrier.stable import Barrier, smooth_barrier, stable_barrier
from wmr_ctrl.core.fields.section import Section
from wmr_ctrl.core.signals import DIAGNOSTICS, FORCE, POSE, REFERENCE, VELOCITY, Signal
from wmr_ctrl.world.model.dynamics import reduced_mass
from wmr_ctrl.world.model.friction import friction
from wmr_ctrl.world.model.kinematics import (
    auxiliary_rate,
    auxiliary_velocity,
    reference_rate,
    tracking_error,
)
from wmr_ctrl.world.model.system import KeyedNumbers, Output, Parameters, Port, System, ports, stack
from wmr_ctrl.world.scenario import Scenario

from .law import BarrierChoice, commands_predicted

AXES = (0, 1)
KINEMATIC = "gains.kinematics.k"
S = TypeVar("S", bound=Section)
Desired = tuple[ca.SX, ca.SX, ca.SX]
"""Desired pose (3,), velocity (2,) and its rate (2,)."""


class LawNumbers(KeyedNumbers, Protocol):
    """Inputs of a law's graph: its name, its checked gains, the scenario, all numbers."""

    @property
    def name(self) -> str:
        """Name of the law, under which its gains are keys."""

    @property
    def scenario(self) -> Scenario:
        """The scenario."""

    @property
    def gains(self) -> Section:
        """The law's gains, complete and checked."""


class LawContext:
    """Ports and shared quantities of a sampled law named ``law``.

    Inputs in order: reference (7), measured pose (3), measured velocity (2).  ``v`` is the measured
    velocity; barrier quantities see it clipped to v_u1 - limits.clip, everything else does not.
    """

    def __init__(self, setup: LawNumbers, in_flight: int | None = None) -> None:
        """Fresh symbols for a law's gains on a scenario.

        ``in_flight``: number of commands that the law predicts over, by default that of the
        scenario's clock.
        """
        self.law, self.scenario, self.gains = setup.name, setup.scenario, setup.gains
        self.inputs: tuple[Port, ...] = (*ports(REFERENCE), *ports(POSE), *ports(VELOCITY))
        self.parameters = Parameters(setup)
        u = stack(item.sym for item in self.inputs)
        self.pose_d, self.v_d, self.v_d_dot = u[0:3], u[3:5], u[5:7]
        self.pose, self.v = u[7:10], u[10:12]
        self.period = self.parameters.take("clock.control")
        own = commands_predicted(self.gains, self.scenario.clock.control)
        self.in_flight = own if in_flight is None else in_flight
        self._given = tuple(vars(self))

    def at(self, desired: Desired, pose: ca.SX, v: ca.SX) -> "LawContext":
        """The law at another instant, with this pose, velocity and desired motion."""
        other = copy(self)
        for name in set(vars(other)) - {*self._given, "_given"}:
            del vars(other)[name]
        other.pose_d, other.v_d, other.v_d_dot = desired
        other.pose, other.v = pose, v
        return other

    def gain(self, name: str) -> ca.SX:
        """Symbol of one of the law's own gains."""
        return self.parameters.take(f"gains.{self.law}.{name}")

    def own(self, cls: type[S]) -> S:
        """The law's gains, of class ``cls``: options that select the form of the graph."""
        assert isinstance(self.gains, cls), f"{self.law}: gains are not {cls}"
        return self.gains

    @cached_property
    def e(self) -> ca.SX:
        """Tracking error, Eq. (8), from the measured pose."""
        return tracking_error(self.pose_d, self.pose)

    @cached_property
    def v_c0(self) -> ca.SX:
        """Auxiliary velocity, Eq. (7)."""
        return auxiliary_velocity(self.e, self.v_d, self.parameters.take(KINEMATIC))

    @cached_property
    def v_c0_dot(self) -> ca.SX:
        """Exact rate of the auxiliary velocity."""
        k = self.parameters.take(KINEMATIC)
        return auxiliary_rate(self.e, self.v, self.v_d, self.v_d_dot, k)

    @cached_property
    def v_c0_dot_reference(self) -> ca.SX:
        """Part of that rate due to the reference's acceleration v_d'."""
        return reference_rate(self.e, self.v_d, self.v_d_dot, self.parameters.take(KINEMATIC))

    @cached_property
    def mass(self) -> ca.SX:
        """Diagonal of the model's M1."""
        return reduced_mass(self.parameters.take("model.m"), self.parameters.take("model.I"))

    @cached_property
    def friction(self) -> ca.SX:
        """The model's F1 at the measured velocity."""
        return self.friction_at(self.v)

    def friction_at(self, v: ca.SX) -> ca.SX:
        """The model's F1 at velocity v (2,)."""
        take = self.parameters.take
        return friction(take("model.mu"), take("model.m"), take("robot.g"), take("robot.v_s"), v)

    @property
    def u1(self) -> ca.SX:
        """Limits v_u1 of both axes."""
        return self.parameters.take("limits.v_u1")

    @property
    def u2(self) -> ca.SX:
        """Thresholds v_u2 of both axes."""
        return self.parameters.take("limits.v_u2")

    @cached_property
    def smooth(self) -> bool:
        """True if the law's gain ``barrier`` selects the smooth form."""
        return isinstance(self.gains, BarrierChoice) and self.gains.barrier == "smooth"

    @cached_property
    def barrier(self) -> tuple[Barrier, Barrier]:
        """Barrier quantities of both axes, Eqs. (10)-(20)."""
        form = smooth_barrier if self.smooth else stable_barrier
        u1, u2, clip = self.u1, self.u2, self.parameters.take("limits.clip")
        inside = [ca.fmax(clip - u1[i], ca.fmin(u1[i] - clip, self.v[i])) for i in AXES]
        first, second = (form(self.v_c0[i], inside[i], u1[i], u2[i]) for i in AXES)
        return first, second

    def per_axis(self, name: str) -> ca.SX:
        """One barrier quantity of both axes as a column."""
        return ca.vertcat(*(getattr(axis, name) for axis in self.barrier))

    def diagnostics(self) -> tuple[Output, ...]:
        """Diagnostics of every law."""
        share = [1 - ca.fabs(self.v[i]) / self.u1[i] for i in AXES]
        v1 = self.barrier[0].V1 + self.barrier[1].V1
        exprs = (self.v_c0, self.per_axis("v_c1"), v1, self.per_axis("q"), ca.fmin(*share))
        return tuple(Output(signal, expr) for signal, expr in zip(DIAGNOSTICS, exprs, strict=True))

    def system(
        self,
        title: str,
        force: ca.SX,
        state: Sequence[Port] = (),
        update: ca.SX | None = None,
        diagnostics: Sequence[Output] = (),
        further_inputs: Sequence[Port] = (),
        asked: Signal = FORCE,
    ) -> System:
        """The law's System: state and next state, generalised force (N, N m), further diagnostics.

        ``further_inputs`` may hold tau_applied, tau_sent and v_sent_before, which `controller`
        supplies.  With ``asked`` = ASKED the output is a velocity (m/s, rad/s) instead of a force.
        """
        every = (*self.diagnostics(), *diagnostics)  # before the parameters that it takes
        return System(
            self.law,
            title,
            inputs=(*self.inputs, *further_inputs),
            state=tuple(state),
            params=self.parameters.ports,
            update=ca.SX(0, 1) if update is None else update,
            outputs=(Output(asked, force),),
            diagnostics=every,
            period=self.scenario.clock.control,
        )


def own_diagnostics(law: System) -> tuple[Signal, ...]:
    """Diagnostics of a law beyond those of all laws."""
    return tuple(item.signal for item in law.diagnostics[len(DIAGNOSTICS) :])
