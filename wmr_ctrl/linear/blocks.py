"""The robot and its law in error coordinates, as Systems whose names fit together.

In the robot's own frame the pose itself drops out: only the tracking error e, the velocity v and
the desired velocity matter, Eqs. (7), (33)-(35).  Where the desired velocity is constant (circle,
line) the closed loop is therefore time-invariant.
"""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise

import casadi as ca
import numpy as np

from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.control.setup import settle
from wmr_ctrl.linear.linearise import Floats, element_names
from wmr_ctrl.model.dynamics import acceleration, force_to_wheel, friction, reduced_mass
from wmr_ctrl.model.parameters import Parameters
from wmr_ctrl.model.system import Output, Port, System, port, ports, stack
from wmr_ctrl.model.tracking import error_rate, error_rotation
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import (
    FORCE,
    POSE,
    REFERENCE,
    TAU_APPLIED,
    TRACKING_ERROR,
    VELOCITY,
    Signal,
    tau_sent,
)

DISTURBANCE = Signal(
    "disturbance", "N, N.m", "disturbing generalised force (thrust, turning moment)", 2
)
APPLIED = Signal("force_applied", "N, N.m", "generalised force behind the drives' lag", 2)
BEFORE = Signal("force_before", "N, N.m", "mean force of the sample that has ended", 2)
V_D = Signal("v_d", "m/s, rad/s", "desired velocity", 2)
V_D_DOT = Signal("v_d_dot", "m/s2, rad/s2", "rate of the desired velocity", 2)

ERROR_STATE = (TRACKING_ERROR, *VELOCITY)
"""e (3), v1, omega: the robot seen from its reference."""


FORCES = element_names((FORCE,))
DISTURBANCES = element_names((DISTURBANCE,))
STATES = element_names(ERROR_STATE)
APPLIED_BEFORE = element_names((BEFORE,))


def sent_before(commands: int) -> list[str]:
    """Names of the forces of commands under way, the latest first."""
    return element_names(_sent(age) for age in range(1, commands + 1))


def _sent(age: int) -> Signal:
    return Signal(f"force_sent{age}", "N, N.m", f"force commanded {age} samples ago", 2)


PERIOD = "clock.control"


@lru_cache(maxsize=64)
def error_plant(scenario: Scenario) -> System:
    """Continuous: force, disturbance and v_d to e (3), v1, omega, Eqs. (4), (33)-(35).

    Behind the drives' lag if the scenario has one; its delay and torque limit are not in here.
    """
    force, disturbance, v_d = port(FORCE), port(DISTURBANCE), port(V_D)
    state = (port(ERROR_STATE[0]), *ports(VELOCITY))
    p = Parameters(scenario)
    m, inertia, mu, g, v_s = (p.take(f"robot.{name}") for name in ("m", "I", "mu", "g", "v_s"))
    s = stack(item.sym for item in state)
    applied, lagging, lag_rate = _drives(scenario, p, force)
    drag = friction(mu, m, g, v_s, s[3:5])
    v_dot = acceleration(reduced_mass(m, inertia), applied + disturbance.sym, drag)
    rate = ca.vertcat(error_rate(s[:3], s[3:5], v_d.sym), v_dot, lag_rate)
    outputs = tuple(Output(item.signal, item.sym) for item in state)
    inputs = (force, disturbance, v_d)
    return System(
        "plant",
        "robot seen from its reference",
        inputs=inputs,
        state=(*state, *lagging),
        params=p.ports,
        update=rate,
        outputs=outputs,
    )


def _drives(
    scenario: Scenario, p: Parameters, force: Port
) -> tuple[ca.SX, tuple[Port, ...], ca.SX]:
    """Applied force, the drives' state and its rate."""
    if scenario.actuator.lag == 0:
        return force.sym, (), ca.SX(0, 1)
    applied = port(APPLIED)
    return applied.sym, (applied,), (force.sym - applied.sym) / p.take("actuator.lag")


@lru_cache(maxsize=64)
def law_loop(scenario: Scenario, law: str) -> Loop:
    """``law`` on ``scenario`` as the checks see it: what it uses, whether it adapts; built once."""
    return Loop(settle(scenario, law))


@lru_cache(maxsize=64)
def error_law(scenario: Scenario, law: str, own_torque: bool = True, commands: int = 0) -> System:
    """Sampled: e (3), v1, omega, v_d and v_d' to the law's generalised force.

    The law's own graph, with the robot at the origin and the reference placed to give e; a law that
    asks for the torque applied before is given its own last one, as behind ideal drives, or with
    ``own_torque`` off gets the input APPLIED_BEFORE, and those of `sent_before`.  It predicts over
    so many ``commands``, none unless given.
    """
    core = law_loop(scenario, law).over(commands).core
    asks = TAU_APPLIED in (item.signal for item in core.inputs)
    sent = tuple(port(_sent(age)) for age in range(1, commands + 1))
    core, before = _with_own_torque(core, scenario) if own_torque else core, port(BEFORE)
    e, v_d, v_d_dot, v = port(ERROR_STATE[0]), port(V_D), port(V_D_DOT), ports(VELOCITY)
    pose_d = error_rotation(ca.SX(0)).T @ e.sym
    known = ca.vertcat(pose_d, v_d.sym, v_d_dot.sym, 0, 0, 0, *(item.sym for item in v))
    named = dict(zip(_SAMPLED, ca.vertsplit(known), strict=True))
    named[TAU_APPLIED.name] = _torque(scenario, before.sym)
    for age, item in enumerate(sent, start=1):
        named[tau_sent(age).name] = _torque(scenario, item.sym)
    zeros = {item.signal.name: ca.SX.zeros(item.signal.size) for item in core.inputs}
    u = stack((zeros | named)[item.signal.name] for item in core.inputs)
    update, force = core.function("act", [core.update, core.outputs[0].expr])(u, core.x, core.p)
    inputs = (e, *v, v_d, v_d_dot, *([] if own_torque or not asks else [before]), *sent)
    return System(
        "law",
        core.title,
        inputs=inputs,
        state=core.state,
        params=core.params,
        update=update,
        outputs=(Output(FORCE, force),),
        period=core.period,
    )


def _with_own_torque(core: System, scenario: Scenario) -> System:
    """The law with its input tau_applied, if it has one, turned into memory of its own torque."""
    known = {item.signal.name: item for item in core.inputs}
    if TAU_APPLIED.name not in known:
        return core
    torque = _torque(scenario, core.outputs[0].expr)
    applied = known.pop(TAU_APPLIED.name)
    state, update = (*core.state, applied), ca.vertcat(core.update, torque)
    return replace(core, inputs=tuple(known.values()), state=state, update=update)


def _torque(scenario: Scenario, force: ca.SX) -> ca.SX:
    return force_to_wheel(ca.SX(scenario.robot.r), ca.SX(scenario.robot.l), force)


def unguarded(scenario: Scenario) -> Scenario:
    """The scenario with its guard off, which no linear statement sees."""
    return replace(scenario, guard=replace(scenario.guard, enabled=False))


_SAMPLED = tuple(signal.name for signal in (*REFERENCE, *POSE, *VELOCITY))


def with_values(system: System, numbers: Mapping[str, Sequence[float]]) -> System:
    """The System with other values of the state and parameter ports named in ``numbers``."""

    def renewed(items: tuple[Port, ...]) -> tuple[Port, ...]:
        return tuple(
            replace(item, value=tuple(map(float, numbers[item.signal.name])))
            if item.signal.name in numbers
            else item
            for item in items
        )

    return replace(system, state=renewed(system.state), params=renewed(system.params))


def holding(system: System, held: Container[str]) -> System:
    """The System with the memory of the ports named in ``held`` kept at its present value."""
    moving = tuple(item for item in system.state if item.signal.name not in held)
    fixed = tuple(item for item in system.state if item.signal.name in held)
    rows = dict(zip((item.signal.name for item in system.state), _updates(system), strict=True))
    update = stack(rows[item.signal.name] for item in moving)
    return replace(system, state=moving, params=(*system.params, *fixed), update=update)


def constants(system: System) -> list[str]:
    """Names of memory that every sample sets to the same value, such as a flag."""
    causes = ca.vertcat(system.u, system.x)
    named = zip(system.state, _updates(system), strict=True)
    return [item.signal.name for item, update in named if not ca.depends_on(update, causes)]


def _updates(system: System) -> list[ca.SX]:
    """The update, port by port."""
    ends = np.cumsum([0, *(item.signal.size for item in system.state)])
    return [system.update[a:b] for a, b in pairwise(ends)]


def continuous_reading(system: System) -> System:
    """A sampled System as a continuous one: each memory's rate is its change over one period.

    For explicit Euler steps (weights, estimates) that is the law as published; a remembered sample
    (PID) becomes a first-order lag of one period.
    """
    period = _period_symbol(system)
    return replace(system, update=(system.update - system.x) / period, period=None)


def _period_symbol(system: System) -> ca.SX:
    return next(item.sym for item in system.params if item.signal.name == PERIOD)


def with_period(system: System, period: float) -> System:
    """A sampled System with another control period [s]."""
    return replace(with_values(system, {PERIOD: (period,)}), period=period)


def by_port(system: System, memory: Floats) -> dict[str, list[float]]:
    """A flat memory (n) of the System by the names of its state's ports."""
    ends = np.cumsum([0, *(item.signal.size for item in system.state)])
    pairs = zip(system.state, pairwise(ends), strict=True)
    return {item.signal.name: [float(x) for x in memory[a:b]] for item, (a, b) in pairs}
