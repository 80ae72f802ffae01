"""Model of the closed loop: the native loop in one FMU, with its noise and its changes."""

from collections.abc import Iterable, Sequence
from contextlib import suppress

from wmr_ctrl.codegen.build import delay_steps_of, numbers_of
from wmr_ctrl.codegen.emit import kernel
from wmr_ctrl.codegen.kernels import findings_of, loop_constants, loop_kernels
from wmr_ctrl.control.loop import LoopGraphs
from wmr_ctrl.control.numbers import SMALLEST, Range, clock_of, ranges_of
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.core.fields.section import number_of, quantities
from wmr_ctrl.core.signals import LARGEST, POSE, TORQUE, VELOCITY, Signal, elements
from wmr_ctrl.world.effect import EffectRole
from wmr_ctrl.world.model.system import Output, Parameters, Port, port, stack
from wmr_ctrl.world.registry import EFFECTS
from wmr_ctrl.world.scenario import Change, Scenario, unknown_keys
from wmr_ctrl.world.scenario.scenario import SECTIONS

from .model_description import (
    TIME,
    FmuModel,
    Role,
    Variable,
    finite,
    output_rows,
    parameter_rows,
)

START = {"initial.pose": POSE, "initial.velocity": VELOCITY}
"""Parameters that the state starts from, and which of it."""
MAX_ABS_V = Signal(
    "max_abs_v", "m/s, rad/s", "largest |v1| and |omega| so far, over all plant steps", 2
)
VIOLATIONS = Signal("violations", "1", "plant steps beyond a velocity limit so far")
FOUND = {"max_v1": "max_abs_v[1]", "max_omega": "max_abs_v[2]", "violations": VIOLATIONS.name}
"""Outputs that show a finding of the run, by its name in FINDINGS."""
SEED = Signal("seed", "1", "seed of the noise, as the command line takes it")
MOST = 2147483647


def closed_loop_model(setup: Setup) -> FmuModel:
    """Reference, sensors, law, drives, disturbances and plant of a setup in one model."""
    loop, scenario = LoopGraphs(setup), setup.scenario
    start = Parameters(setup)
    for key in START:
        start.take(key)
    ports = (*start.ports, *loop.parameters.ports)
    absent = _absent(setup, {port.signal.name for port in ports})
    ranges = dict(ranges_of(scenario, (port.signal.name for port in ports)))
    ranges |= _drives(setup) | {
        item.signal.name: (finite(min(item.value)), finite(max(item.value))) for item in absent
    }
    seed = Variable(SEED.name, SEED.unit, SEED.meaning, Role.FIXED, 0.0, 0.0, MOST, integer=True)
    numbers = parameter_rows((*ports, *absent), ranges)
    parameters = [TIME, *numbers, seed, *_changes(scenario)]
    nothing = TORQUE if unknown_keys(scenario) else ()  # of a robot that is not known
    columns = [item for item in loop.columns if item not in nothing]
    outputs = [
        *output_rows((*columns[1:], MAX_ABS_V), discrete=True),
        *output_rows((VIOLATIONS,), discrete=True, integer=True),
    ]
    rows = (*parameters, *outputs)
    reached = [item for item in loop.plant.outputs if item.signal in columns]
    # Columns of the log that the plant shows of a state, be a sample taken there or not.
    shown = {"x": loop.plant.x}, {"y": stack(item.expr for item in reached)}
    return FmuModel(
        "closed-loop",
        f"Closed loop: {setup.control_law.title}",
        "loop",
        scenario,
        rows,
        loop_constants(loop),
        (*loop_kernels(loop), kernel("reached", "What the plant shows of a state.", *shown)),
        (),
        _layout(rows, len(parameters), setup, loop, reached),
        _tables(rows, loop, scenario, reached),
    )


def _absent(setup: Setup, known: Iterable[str]) -> tuple[Port, ...]:
    """Numbers of effects that this loop lacks, as parameters that cannot be changed.

    Numbers in a separate table are omitted with it, and so is a speed loop that does not exist.
    """
    loops = () if setup.takes_velocity else (EffectRole.COMMAND, EffectRole.LOOP)
    ports: dict[str, Port] = {}
    for effect in EFFECTS:
        here = effect in setup.effects or effect.role in loops
        if here or effect.section.KEY not in SECTIONS:
            continue
        section = setup.scenario.section(effect.section)
        for name, _ in quantities(effect.section):
            key = f"{effect.section.KEY}.{name}"
            with suppress(KeyError):  # a text or a flag is no parameter
                signal, value = number_of(section, name, key)
                ports[key] = port(signal, value)
    return tuple(item for key, item in ports.items() if key not in known)


def _drives(setup: Setup) -> dict[str, Range]:
    """Ranges of the drives' numbers, from which the loop's known torque and its memory are built.

    These cannot be changed: whether there is a lag; the delay; with either of them the clock's
    steps; numbers that decide the form of an effect's graph.
    """
    scenario = setup.scenario
    numbers = {key: scenario.value(key) for item in setup.effects for key in item.shape}
    held = {key: (value[0], value[0]) for key, value in numbers.items()}
    lag = {"actuator.lag": (SMALLEST, LARGEST)} if scenario.actuator.lag > 0 else {}
    if scenario.actuator.jitter > 0:
        held["actuator.jitter"] = (0.0, scenario.clock.control)
    return held | lag | clock_of(scenario)


def _changes(scenario: Scenario) -> Iterable[Variable]:
    """Parameters ``changes[1].t`` and so on: the scenario's changes and their times."""
    known = dict(quantities(Change))
    for k, change in enumerate(scenario.changes, start=1):
        for name, value in {"t": change.t, **change.values()}.items():
            what = known[name]
            low = what.bounds.minimum
            low = float(what.bounds.above or 0.0) + SMALLEST if low is None else low
            yield Variable(
                f"changes[{k}].{name}", what.unit, what.doc, Role.FIXED, value, low, LARGEST
            )


def _layout(
    rows: tuple[Variable, ...],
    first_output: int,
    setup: Setup,
    loop: LoopGraphs,
    reached: Iterable[Output],
) -> dict[str, int]:
    signals = tuple(item.signal for item in loop.parameters.ports)
    at = {row.name: i for i, row in enumerate(rows)}
    return {
        "ROWS": len(rows),
        "Z": 1,
        "NZ": first_output - 1,
        "U": 1,
        "P": 1,
        "NP": first_output - 1,
        "X": first_output,
        "NX": 0,
        "W": first_output,
        "NW": len(rows) - first_output,
        "CONTINUOUS_STATES": 0,
        "HAS_ME": 0,
        "CHANGES": len(setup.scenario.changes),
        "DELAY_MAX": delay_steps_of(loop, numbers_of(setup, signals)),
        "REACHED": len(elements(item.signal for item in reached)),
        "AT_SEED": at["seed"],
        "AT_PERIOD": at["clock.control"],
        "AT_STEP": at["clock.plant"],
    }


def _tables(
    rows: tuple[Variable, ...], loop: LoopGraphs, scenario: Scenario, reached: Iterable[Output]
) -> dict[str, Sequence[Sequence[float]]]:
    """Tables by name: rows that numbers are read from and written to, 0 if there is none."""
    at = {row.name: i for i, row in enumerate(rows)}
    names = elements(port.signal for port in loop.parameters.ports)
    state = elements(port.signal for port in loop.plant.state)
    at_rest = [0] * (len(loop.x0) - len(state))
    starts = {
        signal.name: at[f"{key}[{i}]"]
        for key, signals in START.items()
        for i, signal in enumerate(signals, start=1)
    }
    counts = range(1, len(scenario.changes) + 1)
    fields = [name.removeprefix("robot.") if name.startswith("robot.") else "" for name in names]
    changed = [[at.get(f"changes[{k}].{field}", 0) for field in fields] for k in counts]
    times = [at[f"changes[{k}].t"] for k in counts]
    return {
        "PARAMETER_ROWS": [[at[name] for name in names]],
        "CHANGE_ROWS": [*changed, [0] * len(names)],
        "CHANGE_TIME_ROWS": [[*times, 0]],
        "START": [loop.x0],
        "START_ROWS": [[*(starts.get(name, 0) for name in state), *at_rest]],
        "COLUMN_ROWS": [[at.get(name, 0) for name in elements(loop.columns)]],
        "REACHED_ROWS": [[at[name] for name in elements(o.signal for o in reached)]],
        "FOUND_ROWS": [[at.get(FOUND.get(name, ""), 0) for name in findings_of(loop)]],
    }
