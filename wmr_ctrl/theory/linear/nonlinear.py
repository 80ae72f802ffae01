"""The nonlinear loop as a python-control object, `control.nlsys`: reference, law and plant.

In continuous time (with the law interpreted continuously) or sampled with the scenario's clock,
with exactly the law that the compiled code computes.  All signals have their names from the
catalogue.
"""

from collections.abc import Mapping

import casadi as ca
import control as ct
import numpy as np

from wmr_ctrl.control.controller import controller
from wmr_ctrl.control.outside import check_takes_torques
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.fields.arguments import checks_arguments
from wmr_ctrl.core.signals import DISTURBING, TIME
from wmr_ctrl.world.model.dynamics import plant, rk4_step
from wmr_ctrl.world.model.system import System, ports, stack
from wmr_ctrl.world.references.kind import reference
from wmr_ctrl.world.scenario import Scenario

from .linearise import Floats, element_names


@checks_arguments
def loop_nlsys(scenario: Scenario, law: str, sampled: bool = False) -> ct.NonlinearIOSystem:
    """The whole nonlinear loop: from disturbing torques and body force to pose, velocity and
    torques.

    Its state is the law's memory, then pose and velocity; its initial state is `start_of`.  The
    sampled loop steps at the control period, by the clock's Runge-Kutta steps.  In continuous time
    a memory's rate is its change over one period.  For explicit Euler steps (weights, estimates)
    that is the law as published; a remembered sample (PID) becomes a first-order lag of one period.
    """
    check_takes_torques(scenario, "loops of python-control are made")
    acting, moving, clock = controller(settle(scenario, law)), plant(scenario), scenario.clock
    pushes, t, p = ports(DISTURBING), ca.SX.sym("t"), ca.DM(moving.p0)
    known = {TIME.name: t} | {item.signal.name: item.sym for item in (*pushes, *moving.state)}
    _, desired = _evaluated(reference(scenario), known)
    memory, torque = _evaluated(acting, known | desired)
    rate, shown = _evaluated(moving, known | torque)
    if sampled:
        step = moving.function("step", [rk4_step(moving, ca.SX(clock.plant))])
        held, rate = _inputs(moving, known | torque), moving.x
        for _ in range(clock.substeps):
            rate = step(held, rate, p)
    else:
        memory = (memory - acting.x) / clock.control
    x, u = ca.vertcat(acting.x, moving.x), stack(item.sym for item in pushes)
    results = [ca.vertcat(memory, rate), stack((*shown.values(), *torque.values()))]
    graph = ca.Function("loop", [t, x, u], [ca.densify(item) for item in results])

    def update(t: float, x: Floats, u: Floats, params: Mapping[str, object]) -> Floats:
        return np.asarray(graph(t, x, u)[0]).ravel()

    def output(t: float, x: Floats, u: Floats, params: Mapping[str, object]) -> Floats:
        return np.asarray(graph(t, x, u)[1]).ravel()

    return ct.nlsys(
        update, output, name=f"{law} loop", dt=clock.control if sampled else 0,
        states=element_names(item.signal for item in (*acting.state, *moving.state)),
        inputs=element_names(DISTURBING),
        outputs=element_names(item.signal for item in (*moving.outputs, *acting.outputs)),
    )  # fmt: skip


@checks_arguments
def start_of(scenario: Scenario, law: str) -> Floats:
    """Initial state of `loop_nlsys`: the law's memory, then pose and velocity."""
    own = controller(settle(scenario, law)).x0
    return np.array([*own, *scenario.initial.pose, *scenario.initial.velocity])


def _inputs(system: System, known: Mapping[str, ca.SX]) -> ca.SX:
    return stack(known[item.signal.name] for item in system.inputs)


def _evaluated(system: System, known: Mapping[str, ca.SX]) -> tuple[ca.SX, dict[str, ca.SX]]:
    """Update, and outputs by name, for inputs by name and with the parameters' values."""
    graph = system.function("graph", [system.update, *(item.expr for item in system.outputs)])
    update, *shown = graph(_inputs(system, known), system.x, ca.DM(system.p0))
    return update, {item.signal.name: y for item, y in zip(system.outputs, shown, strict=True)}
