"""Models of single blocks: plant, laws, reference, guard, command filter, corridor monitor."""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from wmr_ctrl.codegen.block import (
    PARALLEL,
    Block,
    corridor_block,
    filter_block,
    guard_block,
    law_block,
    plant_block,
    reference_block,
)
from wmr_ctrl.codegen.kernels import sizes_of
from wmr_ctrl.control.numbers import Range, clock_of, ranges_of
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.corridor import corridor_monitor
from wmr_ctrl.fmi.model import (
    TIME,
    FmuModel,
    Variable,
    input_rows,
    output_rows,
    parameter_rows,
    rate_rows,
    state_rows,
)
from wmr_ctrl.model.system import System
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import POSE, REFERENCE, VELOCITY
from wmr_ctrl.signals import TIME as SECONDS
from wmr_ctrl.world.references import sample

CHANGED = ("robot.m", "robot.I", "robot.mu")
"""The plant's parameters that may be changed while it runs, as the paper does at 40 s."""


def plant_model(scenario: Scenario) -> FmuModel:
    """The robot: torques in, pose, velocity and heading out."""
    return _model("plant", "Wheeled robot, Eqs. (1)-(6)", scenario, plant_block(scenario), CHANGED)


def law_model(setup: Setup) -> FmuModel:
    """One control law: reference, pose and velocity in, torques and diagnostics out."""
    law = setup.control_law
    return _model(law.name, f"Control law: {law.title}", setup.scenario, law_block(setup))


def guard_model(setup: Setup) -> FmuModel:
    """The velocity guard behind any law: asked force in, torques out."""
    return _model("guard", "Velocity guard", setup.scenario, guard_block(setup))


def filter_model(scenario: Scenario) -> FmuModel:
    """The command filter of a scenario: any velocity in, one that is safe out.

    Its period is fixed: delays and tables of step responses are counted in it.
    """
    block, T = filter_block(scenario), scenario.clock.control
    fixed = {"clock.control": (T, T)}
    return _model("filter", block.system.title.capitalize(), scenario, block, fixed=fixed)


def corridor_model(scenario: Scenario, law: str) -> FmuModel:
    """The monitor of a law's certified corridor: what the law is given and sends in, verdict out.

    Its period is fixed, since samples are counted.
    """
    block, T = corridor_block(corridor_monitor(scenario, law), scenario), scenario.clock.control
    fixed = {"clock.control": (T, T)}
    return _model("corridor", block.system.title.capitalize(), scenario, block, fixed=fixed)


def reference_model(scenario: Scenario) -> FmuModel:
    """The desired trajectory."""
    return _model("reference", "Desired trajectory", scenario, reference_block(scenario))


def parallel(model: FmuModel) -> FmuModel:
    """The same model for masters that step all parts at once."""
    rows = (replace(v, start=1.0) if v.name == PARALLEL.name else v for v in model.variables)
    return replace(model, variables=tuple(rows))


def _model(
    what: str,
    title: str,
    scenario: Scenario,
    block: Block,
    tunable: tuple[str, ...] = (),
    fixed: Mapping[str, Range] = MappingProxyType({}),
) -> FmuModel:
    system = block.system
    sections = _sections(scenario, block, tunable, fixed)
    rows = tuple(row for section in sections.values() for row in section)
    at = {row.name: i for i, row in enumerate(rows)}
    layout = _layout(sections, system)
    name, key = ("AT_PERIOD", "clock.control") if system.period else ("AT_STEP", "clock.plant")
    layout[name] = at[key]
    if PARALLEL.name in at:
        layout["AT_PARALLEL"] = at[PARALLEL.name]
    first, known = layout["W"], layout["Z"]
    dependencies: dict[int, list[tuple[int, bool]]] = {
        first + row: [] for row in range(layout["NW"])
    }
    for row, column, constant in sorted(block.jacobian):
        dependencies[first + row].append((known + column, constant))
    return FmuModel(
        what,
        title,
        "sampled" if system.period else "continuous",
        scenario,
        rows,
        sizes_of("block", system),
        block.kernels,
        block.derivatives,
        layout,
        dependencies=dependencies,
        graph=block.graph,
    )


def _sections(
    scenario: Scenario, block: Block, tunable: tuple[str, ...], fixed: Mapping[str, Range]
) -> Mapping[str, list[Variable]]:
    """Rows in the order that C relies on: time, inputs, parameters, states, rates, results."""
    system, discrete = block.system, block.system.period is not None
    results = [item.signal for item in block.results]
    ranges = ranges_of(scenario, (port.signal.name for port in system.params))
    ranges |= {PARALLEL.name: (0.0, 1.0)} | (clock_of(scenario) if discrete else {})
    ranges |= dict(fixed)
    shown = {item.name for item in results}
    published = {item.signal.name for item in system.outputs} - shown
    taken = {port.signal.name for port in (*system.inputs, *system.params)} | shown
    states = list(state_rows(system.state, published, taken, discrete=discrete))
    timed = _follows_time(system)
    # Pose, velocity and reference inputs start as they are at t = 0.
    given = (signal.name for signal in (*REFERENCE, *POSE, *VELOCITY))
    desired, start = sample(scenario, np.zeros(1))[0].tolist(), scenario.initial
    starts = dict(zip(given, (*desired, *start.pose, *start.velocity), strict=True))
    return {
        "time": [TIME],
        "U": [] if timed else list(input_rows(system.inputs, starts)),
        "P": list(parameter_rows(system.params, ranges, tunable)),
        "X": states,
        "rates": [] if discrete else list(rate_rows(states)),
        "results": list(output_rows(results, discrete=discrete and not timed)),
    }


def _follows_time(system: System) -> bool:
    """True if the only input is time, which every FMU has anyway."""
    return [port.signal.name for port in system.inputs] == [SECONDS.name]


def _layout(sections: Mapping[str, list[Variable]], system: System) -> dict[str, int]:
    """Begin and length of each section."""
    count = {name: len(rows) for name, rows in sections.items()}
    first_input = 0 if _follows_time(system) else 1
    parameters = 1 + count["U"]
    states = parameters + count["P"]
    results = states + count["X"]
    continuous = system.period is None
    return {
        "ROWS": results + count["rates"] + count["results"],
        "Z": first_input,
        "NZ": results - first_input,
        "U": first_input,
        "NU": count["U"],
        "P": parameters,
        "NP": count["P"],
        "X": states,
        "NX": count["X"],
        "NY": count["results"] - system.d.numel(),
        "W": results,
        "NW": count["rates"] + count["results"],
        "CONTINUOUS_STATES": count["X"] if continuous else 0,
        "HAS_ME": int(continuous or (_follows_time(system) and not count["X"])),
    }
