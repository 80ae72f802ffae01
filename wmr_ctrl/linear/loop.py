"""The closed loop as python-control objects: plant, law, and their interconnection.

``memory`` says what becomes of the law's memory: "frozen" keeps estimates and weights at their
values (a remembered sample stays part of the loop), "learning" lets them move.
"""

from __future__ import annotations

import control as ct

from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.errors import UnknownNameError
from wmr_ctrl.linear.blocks import (
    continuous_reading,
    error_law,
    error_plant,
    constants,
    holding,
    with_memory,
    with_period,
)
from wmr_ctrl.linear.linearise import linearise
from wmr_ctrl.linear.names import DISTURBANCES, FORCES, STATES
from wmr_ctrl.linear.point import Point, on_reference
from wmr_ctrl.model.system import System
from wmr_ctrl.scenario import Scenario

MEMORY = ("frozen", "learning")


def plant_at(scenario: Scenario, point: Point, period: float | None = None) -> ct.StateSpace:
    """The plant near ``point``: force and disturbance to e, v1, omega.

    With ``period`` [s] as an exact zero-order hold of its inputs.
    """
    block = error_plant(scenario)
    full = linearise(block, point.plant_input, point.plant_state(block))
    kept = with_inputs(full, FORCES + DISTURBANCES)
    return kept if period is None else hold(kept, period)


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
    """The law near ``point``: e, v1, omega to force; sampled with ``period`` [s], else continuous."""
    full = linearise(law_block(scenario, law, point, period, memory), point.law_input)
    return with_inputs(full, STATES)


def law_block(
    scenario: Scenario, law: str, point: Point, period: float | None, memory: str
) -> System:
    """The law's System in the wanted reading, with its memory as at ``point``."""
    if memory not in MEMORY:
        raise UnknownNameError("reading of the memory", memory, MEMORY)
    own = scenario.clock.control if period is None else period
    block = with_memory(with_period(error_law(scenario, law), own), point.memory)
    estimates = memory == "frozen" and Loop(scenario, law).adaptive
    held = [item.signal.name for item in block.state] if estimates else constants(block)
    block = holding(block, held)
    return continuous_reading(block) if period is None else block


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
