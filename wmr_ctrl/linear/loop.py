"""The closed loop as python-control objects: plant, law, both joined, and along a reference.

``memory`` says what becomes of the law's memory: "frozen" keeps estimates and weights at their
values (a remembered sample stays part of the loop), "learning" lets them move.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import casadi as ca
import control as ct
import numpy as np

from wmr_ctrl.checks.lateness import Lateness, lateness_of
from wmr_ctrl.checks.sampled_plant import SampledPlant, drives, sampled_plant
from wmr_ctrl.checks.seen_pose import cycle, with_pose_sensor
from wmr_ctrl.control.setup import settle
from wmr_ctrl.errors import UnknownNameError
from wmr_ctrl.linear.blocks import (
    APPLIED_BEFORE,
    DISTURBANCES,
    FORCES,
    PERIOD,
    STATES,
    by_port,
    constants,
    continuous_reading,
    error_law,
    error_plant,
    holding,
    law_loop,
    sent_before,
    unguarded,
    with_values,
)
from wmr_ctrl.linear.linearise import Floats, gradients, linearise
from wmr_ctrl.linear.point import Point, ideal_drives, on_reference
from wmr_ctrl.model.system import System
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.world.references import sample

MEMORY = ("frozen", "learning")


def plant_at(
    scenario: Scenario, point: Point, period: float | None = None, *, comes: bool = True
) -> ct.StateSpace:
    """The plant near ``point``: force and disturbance to e, v1, omega.

    Continuous behind the drives' lag, but for a delay and late sensors, which no differential
    equation has.  With ``period`` [s] sampled, with all of them: the force is the command, e, v1
    and omega are as measured, in a sample in which a pose ``comes`` or does not.
    """
    if period is not None:
        return _sampled(scenario, point, period, comes)
    return with_inputs(_robot_at(scenario, point), FORCES + DISTURBANCES)


def _robot_at(scenario: Scenario, point: Point) -> ct.StateSpace:
    block = error_plant(scenario)
    state = point.plant_state(block)
    return linearise(block, point.plant_input, state, graph=_plant_graph(scenario))


def _sampled(scenario: Scenario, point: Point, period: float, comes: bool) -> ct.StateSpace:
    full = _robot_at(ideal_drives(scenario), point)
    push = full.B[:, [full.input_labels.index(name) for name in FORCES]]
    late = _lateness(scenario, period)
    robot = sampled_plant(full.A, push, period, late)
    held = with_pose_sensor(robot, point.v_d, period, late, comes=comes)
    return ct.ss(
        held.moved, np.hstack((held.forced, held.pushed)), held.measured, np.zeros((5, 4)), period,
        name="plant", states=[*full.state_labels, *held.names], inputs=FORCES + DISTURBANCES,
        outputs=STATES, remove_useless_states=False,
    )  # fmt: skip


def _lateness(scenario: Scenario, period: float | None = None) -> Lateness:
    return lateness_of(settle(unguarded(scenario), "pid"), period)  # the same for every law


def late(scenario: Scenario) -> bool:
    """Whether drives or sensors have what only a sampled loop can show."""
    return _lateness(scenario).discrete


def with_inputs(system: ct.StateSpace, names: list[str]) -> ct.StateSpace:
    """The system with these inputs only; python-control's own indexing forgets states' names."""
    columns = [system.input_labels.index(name) for name in names]
    return ct.ss(
        system.A, system.B[:, columns], system.C, system.D[:, columns], system.dt,
        name=system.name, states=system.state_labels or None, inputs=names,
        outputs=system.output_labels, remove_useless_states=False,
    )  # fmt: skip


def hold(plant: ct.StateSpace, period: float) -> ct.StateSpace:
    """Exact zero-order hold with all names kept."""
    return ct.c2d(plant, period, "zoh", name=plant.name, copy_names=True)


def law_at(
    scenario: Scenario,
    law: str,
    point: Point,
    period: float | None = None,
    memory: str = "frozen",
) -> ct.StateSpace:
    """The law near ``point``: e, v1, omega to force; continuous, or sampled with ``period`` [s].

    A sampled law that asks for the torque applied before has a copy of the drives in its memory.
    Read continuously a law predicts nothing: there is no delay to predict over.
    """
    if memory not in MEMORY:
        raise UnknownNameError("reading of the memory", memory, MEMORY)
    own = scenario.clock.control if period is None else period
    commands = 0 if period is None else law_loop(scenario, law).commands(period)
    block, graph = _law_graph(scenario, law, period is None, memory, commands)
    numbers = by_port(error_law(scenario, law), point.memory) | {PERIOD: [own]}
    block = with_values(replace(block, period=period), numbers)
    if block.u.numel() == len(point.law_input):
        return with_inputs(linearise(block, point.law_input, graph=graph), STATES)
    assert period is not None, "a continuous law knows its own torque"
    known = np.tile(point.force, 1 + commands)
    asking = linearise(block, np.concatenate((point.law_input, known)), graph=graph)
    return _with_drives(asking, drives(period, _lateness(scenario, period), commands), commands)


def _with_drives(law: ct.StateSpace, behind: SampledPlant, commands: int) -> ct.StateSpace:
    """The law with its inputs, forces applied and sent before, from drives that it commands."""
    known, n = [*APPLIED_BEFORE, *sent_before(commands)], law.nstates
    own = [law.input_labels.index(name) for name in known]
    applied = np.vstack((behind.applied, behind.sent))
    seen = [law.input_labels.index(name) for name in STATES]
    a = np.block([
        [law.A, law.B[:, own] @ applied],
        [behind.forced @ law.C, behind.moved + behind.forced @ law.D[:, own] @ applied],
    ])  # fmt: skip
    b = np.vstack((law.B[:, seen], behind.forced @ law.D[:, seen]))
    c = np.hstack((law.C, law.D[:, own] @ applied))
    names = [*law.state_labels[:n], *(f"law.{name}" for name in behind.names)]
    return ct.ss(
        a, b, c, law.D[:, seen], law.dt, name="law", states=names, inputs=STATES, outputs=FORCES,
        remove_useless_states=False,
    )  # fmt: skip


@lru_cache(maxsize=32)
def _law_graph(
    scenario: Scenario, law: str, continuous: bool, memory: str, commands: int
) -> tuple[System, ca.Function]:
    """The law's System in the wanted reading, and its gradients."""
    block = error_law(scenario, law, continuous, commands)
    still = memory == "frozen" and law_loop(scenario, law).traits.estimates
    held = [item.signal.name for item in block.state] if still else constants(block)
    block = holding(block, held)
    block = continuous_reading(block) if continuous else block
    return block, gradients(block)


@lru_cache(maxsize=32)
def _plant_graph(scenario: Scenario) -> ca.Function:
    return gradients(error_plant(scenario))


def closed_loop(
    scenario: Scenario,
    law: str,
    point: Point | None = None,
    period: float | None = None,
    memory: str = "frozen",
) -> ct.StateSpace:
    """The linear closed loop near ``point`` (default: on the reference at t = 0).

    Inputs: disturbing force and moment [N, N m]; outputs: e [m, m, rad], v1 [m/s], omega [rad/s],
    force [N, N m].  Continuous, or sampled with ``period`` [s].  Raises UnknownNameError.
    """
    at = on_reference(scenario, law) if point is None else point
    parts = [plant_at(scenario, at, period), law_at(scenario, law, at, period, memory)]
    names = [name for part in parts for name in part.state_labels]
    return ct.interconnect(
        parts, inputs=DISTURBANCES, outputs=STATES + FORCES, states=names, name=f"{law} loop"
    )


def closed_matrix(plant: ct.StateSpace, law: ct.StateSpace) -> Floats:
    """State matrix of the same loop, without the bookkeeping: for searches over many periods."""
    push = plant.B[:, [plant.input_labels.index(name) for name in FORCES]]
    moved = np.hstack((plant.A + push @ law.D @ plant.C, push @ law.C))
    return np.vstack((moved, np.hstack((law.B @ plant.C, law.A))))


def cycle_at(
    scenario: Scenario, law: str, point: Point, period: float, memory: str = "frozen"
) -> tuple[Floats, int]:
    """Matrix of the sampled loop from one pose to the next, and how many samples that takes.

    One, where a pose comes at every sample.
    """
    controller = law_at(scenario, law, point, period, memory)

    def moved(comes: bool) -> Floats:
        return closed_matrix(plant_at(scenario, point, period, comes=comes), controller)

    samples = _lateness(scenario, period).samples_a_pose(period)
    return cycle(moved, samples), samples


STILL = 1e-12
"""Variation of the desired velocity [m/s, rad/s] that counts as none."""


@dataclass(frozen=True)
class TimeInvariant:
    """One StateSpace for the whole reference: in error coordinates nothing depends on time."""

    system: ct.StateSpace

    def __call__(self, t: float) -> ct.StateSpace:
        """The same system at every time ``t`` [s]."""
        return self.system


@dataclass(frozen=True)
class TimeVarying:
    """The linear loop as a function of time; every call is one exact linearisation.

    Poles of frozen instants are no proof of stability, only a picture.
    """

    scenario: Scenario
    law: str
    period: float | None = None

    def __call__(self, t: float) -> ct.StateSpace:
        """The loop near the reference's point at time ``t`` [s]."""
        return _at(self.scenario, self.law, self.period, float(t))


@lru_cache(maxsize=512)
def _at(scenario: Scenario, law: str, period: float | None, t: float) -> ct.StateSpace:
    return closed_loop(scenario, law, on_reference(scenario, law, t), period)


def along_reference(
    scenario: Scenario, law: str, period: float | None = None
) -> TimeInvariant | TimeVarying:
    """The linear loop of ``law`` along the reference, e = 0 and v = v_d; sampled if ``period``."""
    if constant_speed(scenario):
        return TimeInvariant(closed_loop(scenario, law, period=period))
    return TimeVarying(scenario, law, period)


def constant_speed(scenario: Scenario) -> bool:
    """Whether the desired velocity is the same all along the reference."""
    end = min(scenario.clock.duration, scenario.reference.cycle)
    desired = sample(scenario, np.linspace(0.0, end, 257))[:, 3:7]
    swing = np.ptp(desired[:, :2], axis=0).max()
    return bool(swing < STILL and np.abs(desired[:, 2:]).max() < STILL)
