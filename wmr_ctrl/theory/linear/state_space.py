"""The closed loop as python-control objects: plant, law, both joined, and along a reference.

``memory`` selects the treatment of the law's memory: "frozen" keeps estimates and weights constant
(a remembered sample stays part of the loop), "learning" makes them states.
"""

import casadi as ca
import control as ct
import numpy as np
from numpy.typing import ArrayLike

from wmr_ctrl.control.setup import kinematic_gains, settle
from wmr_ctrl.core.errors import UnknownNameError
from wmr_ctrl.core.fields.arguments import checks_arguments
from wmr_ctrl.theory.checks.radius import from_pose_to_pose
from wmr_ctrl.theory.checks.surroundings import DriveTimes, is_sampled, surroundings
from wmr_ctrl.world.model.kinematics import auxiliary_velocity, error_rate
from wmr_ctrl.world.references import sample
from wmr_ctrl.world.scenario import Scenario

from .linearise import (
    DISTURBANCES,
    STATES,
    Floats,
    Point,
    check_reading,
    law_loop,
    on_reference,
    reference_velocity,
    sent_names,
    unguarded,
)

MEMORY = ("frozen", "learning")
GONE = 1e-6
"""Sampled poles up to this size are gone within a sample: what is only passed on."""
STILL = 1e-12
"""Variation of the desired velocity [m/s, rad/s] that counts as none."""


def is_learning(memory: str) -> bool:
    """True if estimates and weights are states; raises UnknownNameError for another ``memory``."""
    if memory not in MEMORY:
        raise UnknownNameError("reading of the memory", memory, MEMORY)
    return memory == "learning"


@checks_arguments
def plant_at(scenario: Scenario, point: Point, period: float | None = None) -> ct.StateSpace:
    """The plant near ``point``: from force and disturbance to e, v1, omega.

    Continuous with the drives' lag, but without delay and late sensors, which no differential
    equation can describe.  With ``period`` [s] sampled, with all of them: the force is the command,
    and e, v1 and omega are as measured, in a sample with a new pose.
    """
    check_reading(scenario, period)
    around = surroundings(scenario)
    if period is None:
        free, forced, pushed, names = around.rates(point.motion)
        shown = np.eye(len(STATES), len(free))
    else:
        held = around.plant(point.motion, period)
        free, forced, pushed, names = held.moved, held.forced, held.pushed, held.names
        shown = held.measured
    return ct.ss(
        free, np.hstack((forced, pushed)), shown, np.zeros((5, 4)), period or 0, name="plant",
        states=[*STATES, *names], inputs=sent_names(scenario) + DISTURBANCES,
        outputs=STATES,
        remove_useless_states=False,
    )  # fmt: skip


def late(scenario: Scenario) -> bool:
    """True if only a sampled loop can represent the drives, the sensors, or a velocity command."""
    if scenario.takes_velocity:
        return True
    return is_sampled(settle(unguarded(scenario), "pid"))  # the same for every law


def with_inputs(system: ct.StateSpace, names: list[str]) -> ct.StateSpace:
    """The system with these inputs only; python-control's own indexing loses the states' names."""
    columns = [system.input_labels.index(name) for name in names]
    return ct.ss(
        system.A, system.B[:, columns], system.C, system.D[:, columns], system.dt,
        name=system.name, states=system.state_labels or None, inputs=names,
        outputs=system.output_labels, remove_useless_states=False,
    )  # fmt: skip


@checks_arguments
def law_at(
    scenario: Scenario, law: str, point: Point, period: float | None = None, memory: str = "frozen"
) -> ct.StateSpace:
    """The law near ``point``: e, v1, omega to force; continuous, or sampled with ``period`` [s].

    A law that uses the torque applied before remembers its commands, and its model of the drives.
    In continuous time a law predicts nothing, and its drives are ideal: there is no delay to
    predict over.
    """
    check_reading(scenario, period)
    loop, own = law_loop(scenario, law), scenario.clock.control if period is None else period
    drives, commands = (DriveTimes(0.0, 0.0, 0.0), 0) if period is None else (None, None)
    learning = is_learning(memory)
    near = loop.linear(point, own, drives=drives, learning=learning, commands=commands)
    moving = (near.a != 0).any(axis=1) | (near.a != 0).any(axis=0) | (near.b != 0).any(axis=1)
    moving |= (near.c != 0).any(axis=0)
    a, b, c = near.a[np.ix_(moving, moving)], near.b[moving], near.c[:, moving]
    if period is None:
        a, b = (a - np.eye(len(a))) / own, b / own
    names = [f"memory[{k}]" for k in range(1, len(a) + 1)] or None
    return ct.ss(
        a, b, c, near.d, period or 0, name="law", states=names,
        inputs=STATES, outputs=sent_names(scenario), remove_useless_states=False,
    )  # fmt: skip


@checks_arguments
def closed_loop(
    scenario: Scenario,
    law: str,
    point: Point | None = None,
    period: float | None = None,
    memory: str = "frozen",
) -> ct.StateSpace:
    """The linear closed loop near ``point`` (default: on the reference at t = 0).

    Inputs: disturbing force and moment [N, N m]; outputs: e [m, m, rad], v1 [m/s], omega [rad/s],
    force [N, N m].  Continuous, without delay and late sensors, or sampled with ``period`` [s],
    with all of them.  Raises UnknownNameError, or ArgumentError for an invalid period.
    """
    at = on_reference(scenario, law) if point is None else point
    parts = [plant_at(scenario, at, period), law_at(scenario, law, at, period, memory)]
    names = [name for part in parts for name in part.state_labels]
    return ct.interconnect(
        parts, inputs=DISTURBANCES, outputs=STATES + sent_names(scenario), states=names,
        name=f"{law} loop",
    )  # fmt: skip


def poles_at(scenario: Scenario, law: str, at: Point, memory: str = "frozen") -> Floats:
    """Poles [1/s], rightmost first; ln z / T of the sampled loop if it is late."""
    if not late(scenario):
        return _sorted(closed_loop(scenario, law, at, memory=memory).poles())
    loop, period = law_loop(scenario, law), scenario.clock.control
    matrix = from_pose_to_pose(loop, at, period, learning=is_learning(memory))
    z = np.linalg.eigvals(matrix).astype(complex)
    return _sorted(np.log(z[np.abs(z) > GONE]) / (loop.around.samples_a_pose(period) * period))


def _sorted(poles: ArrayLike) -> Floats:
    values = np.asarray(poles, dtype=complex)
    return values[np.lexsort((values.imag, -values.real))]


def constant_speed(scenario: Scenario) -> bool:
    """True if the desired velocity is constant along the reference."""
    end = min(scenario.clock.duration, scenario.reference.cycle)
    desired = sample(scenario, np.linspace(0.0, end, 257))[:, 3:7]
    swing = np.ptp(desired[:, :2], axis=0).max()
    return bool(swing < STILL and np.abs(desired[:, 2:]).max() < STILL)


SADDLE = (0.0, 0.0, np.pi)
"""The other resting point of Eq. (7) on a circle or a line: the robot faces backwards."""


@checks_arguments
def kinematic_poles(scenario: Scenario, e: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Floats:
    """Eigenvalues [1/s] of Eqs. (33)-(35) with v = v_c0, near error ``e`` [m, m, rad].

    v_d is that of the reference at t = 0.  The slowest is last at e = 0 with the paper's gains.
    """
    at, k = ca.SX.sym("e", 3), ca.SX(ca.DM(kinematic_gains(scenario).k))
    v_d = ca.SX(ca.DM(reference_velocity(scenario, 0.0)[0]))
    rate = error_rate(at, auxiliary_velocity(at, v_d, k), v_d)
    slope = ca.Function("slope", [at], [ca.densify(ca.jacobian(rate, at))])(e)
    poles = np.linalg.eigvals(np.asarray(slope)).astype(complex)
    return poles[np.argsort(poles.real)]
