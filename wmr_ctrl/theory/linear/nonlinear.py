"""The nonlinear loop as python-control objects: plant, law and reference as `control.nlsys`.

Continuous time (the law read continuously) or sampled with the scenario's clock, with exactly the
law that the compiled code computes. All signals have their names from the catalogue.
"""

from collections.abc import Mapping
from dataclasses import replace

import casadi as ca
import control as ct
import numpy as np

from wmr_ctrl.control.controller import controller
from wmr_ctrl.control.outside import check_takes_torques
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.fields.arguments import checks_arguments
from wmr_ctrl.core.signals import BODY_FORCE, TORQUE_NOISE
from wmr_ctrl.theory.checks.loop import PERIOD
from wmr_ctrl.world.model.dynamics import plant, rk4_step
from wmr_ctrl.world.model.system import System, stack
from wmr_ctrl.world.references.kind import reference
from wmr_ctrl.world.scenario import Scenario

from .linearise import Floats, column, element_names
from .state_space import is_learning


def to_nlsys(system: System) -> ct.NonlinearIOSystem:
    """Any System as a nonlinear system of python-control, with its ports' names."""
    graph = system.function("graph", [system.update, system.y])
    numbers = ca.DM(system.p0)

    def update(t: float, x: Floats, u: Floats, params: Mapping[str, object]) -> Floats:
        return column(graph(np.atleast_1d(u), np.atleast_1d(x), numbers)[0])

    def output(t: float, x: Floats, u: Floats, params: Mapping[str, object]) -> Floats:
        return column(graph(np.atleast_1d(u), np.atleast_1d(x), numbers)[1])

    states = element_names(port.signal for port in system.state)
    return ct.nlsys(
        update if states else None, output, name=system.name, states=states or None,
        inputs=element_names(port.signal for port in system.inputs),
        outputs=element_names(item.signal for item in system.outputs),
        dt=0 if system.period is None else system.period,
    )  # fmt: skip


@checks_arguments
def plant_nlsys(scenario: Scenario, sampled: bool = False) -> ct.NonlinearIOSystem:
    """The robot: from wheel torques, disturbing torques [N m] and a force on the body to its
    motion.

    ``sampled``: over one control period with its inputs held, by the clock's Runge-Kutta steps.
    """
    return to_nlsys(_over_period(scenario) if sampled else plant(scenario))


@checks_arguments
def law_nlsys(
    scenario: Scenario, law: str, sampled: bool = False, memory: str = "learning"
) -> ct.NonlinearIOSystem:
    """The law: reference, pose and velocity to wheel torques, sampled or read continuously.

    ``memory="frozen"`` keeps all its memory at its start values.
    """
    check_takes_torques(scenario, "loops of python-control are made")
    block = controller(settle(scenario, law))
    if not is_learning(memory):
        params = (*block.params, *block.state)
        block = replace(block, state=(), params=params, update=stack(()))
    return to_nlsys(block if sampled else continuous_reading(block))


@checks_arguments
def reference_nlsys(scenario: Scenario, sampled: bool = False) -> ct.NonlinearIOSystem:
    """The desired trajectory: no input, a function of time."""
    block = reference(scenario)
    graph = block.function("reference", [block.y])
    numbers = ca.DM(block.p0)

    def output(t: float, x: Floats, u: Floats, params: Mapping[str, object]) -> Floats:
        return column(graph(float(t), [], numbers))

    names = element_names(item.signal for item in block.outputs)
    dt = scenario.clock.control if sampled else 0
    return ct.nlsys(None, output, name=block.name, inputs=0, outputs=names, dt=dt)


@checks_arguments
def loop_nlsys(
    scenario: Scenario, law: str, sampled: bool = False, memory: str = "learning"
) -> ct.InterconnectedSystem:
    """The whole nonlinear loop: from disturbing torques and body force to pose, velocity and
    torques.

    Its initial state is `start_of`.  The sampled loop steps at the control period.
    """
    moving, acting = plant_nlsys(scenario, sampled), law_nlsys(scenario, law, sampled, memory)
    shown = [*moving.output_labels, *acting.output_labels]
    return ct.interconnect(
        [reference_nlsys(scenario, sampled), acting, moving],
        inputs=element_names((*TORQUE_NOISE, *BODY_FORCE)), outputs=shown, name=f"{law} loop",
    )  # fmt: skip


@checks_arguments
def start_of(scenario: Scenario, law: str, memory: str = "learning") -> Floats:
    """Initial state of `loop_nlsys`: the law's memory, then pose and velocity."""
    own = controller(settle(scenario, law)).x0 if memory == "learning" else []
    return np.array([*own, *scenario.initial.pose, *scenario.initial.velocity])


def _over_period(scenario: Scenario) -> System:
    moving, clock = plant(scenario), scenario.clock
    step = moving.function("step", [rk4_step(moving, ca.SX(clock.plant))])
    state = moving.x
    for _ in range(clock.substeps):
        state = step(moving.u, state, moving.p)
    return replace(moving, update=state, period=clock.control)


def continuous_reading(system: System) -> System:
    """A sampled System as a continuous one: each memory's rate is its change over one period.

    For explicit Euler steps (weights, estimates) that is the law as published; a remembered sample
    (PID) becomes a first-order lag of one period.
    """
    period = next(item.sym for item in system.params if item.signal.name == PERIOD)
    return replace(system, update=(system.update - system.x) / period, period=None)
