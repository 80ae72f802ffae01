"""Model of the closed loop: the native loop in one FMU, with its noise and its changes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields

from wmr_ctrl.codegen.emit import Kernel, kernel
from wmr_ctrl.codegen.kernels import LoopSystems, loop_kernels, loop_systems
from wmr_ctrl.fmi.bounds import LARGEST, SMALLEST, Range, clock_of, ranges_of
from wmr_ctrl.fmi.model import Model
from wmr_ctrl.fmi.variables import TIME, Role, Variable, output_rows, parameter_rows
from wmr_ctrl.laws import LAWS
from wmr_ctrl.laws.sample import own_diagnostics
from wmr_ctrl.model.parameters import Parameters
from wmr_ctrl.model.system import Port, System, stack
from wmr_ctrl.scenario import Change, Scenario
from wmr_ctrl.signals import LOG_HEAD, Signal
from wmr_ctrl.sim.native import pushed

KEYS = (
    "initial.pose",
    "initial.velocity",
    "clock.control",
    "clock.plant",
    "limits.v_u1",
    "sensor.pose_period",
    "sensor.pose_noise",
    "sensor.correction",
    "sensor.velocity_noise",
    "disturbance.std",
    "disturbance.truncate",
    "disturbance.push",
    "actuator.lag",
    "actuator.delay",
    "robot.r",
    "robot.l",
)
"""What the loop reads from its parameters besides those of its Systems."""
MAX_ABS_V = Signal(
    "max_abs_v", "m/s, rad/s", "largest |v1| and |omega| so far, over all plant steps", 2
)
VIOLATIONS = Signal("violations", "1", "plant steps beyond a velocity limit so far")
SEED = Signal("seed", "1", "seed of the noise, as the command line takes it")
MOST = 2147483647


def closed_loop_model(scenario: Scenario, law: str) -> Model:
    """Reference, sensors, law, actuator, noise and plant of ``scenario`` in one model."""
    systems = loop_systems(scenario, law)
    ports = _ports(scenario, systems.by_role())
    ranges = dict(ranges_of(scenario, (port.signal.name for port in ports)))
    ranges |= _drives(scenario)
    parameters = [TIME, *parameter_rows(ports, ranges), _seed(), *_changes(scenario)]
    columns = (*LOG_HEAD[1:], *own_diagnostics(systems.controller))
    outputs = [
        *output_rows((*columns, MAX_ABS_V), discrete=True),
        *output_rows((VIOLATIONS,), discrete=True, integer=True),
    ]
    rows = (*parameters, *outputs)
    return Model(
        "closed-loop",
        f"Closed loop: {LAWS[law].title}",
        "loop",
        scenario,
        rows,
        systems.by_role(),
        (*loop_kernels(systems), _push_kernel(ports)),
        (),
        _layout(rows, len(parameters), scenario),
        _tables(rows, systems, scenario),
        None,
        False,
        scenario.clock.control,
        "",
    )


def _ports(scenario: Scenario, roles: Mapping[str, System]) -> tuple[Port, ...]:
    """Parameters of all Systems, each once, the start's first and side by side."""
    first = Parameters(scenario)
    for key in KEYS[:2]:
        first.take(key)
    known = {port.signal.name: port for port in first.ports}
    for system in roles.values():
        known |= {port.signal.name: port for port in system.params}
    every = Parameters(scenario, known.values())
    for key in KEYS:
        every.take(key)
    return every.ports


def _push_kernel(ports: Iterable[Port]) -> Kernel:
    """What `sim.native.push_torque` computes, from the FMU's parameters."""
    sym = {port.signal.name: port.sym for port in ports}
    push, r, half_track = (sym[key] for key in ("disturbance.push", "robot.r", "robot.l"))
    return kernel(
        "push_torque",
        "Wheel torques of the push: of its thrust, and of its moment.",
        {"push": push, "r": r, "l": half_track},
        {"torque": stack(pushed(push, r, half_track))},
    )


def _drives(scenario: Scenario) -> dict[str, Range]:
    """Ranges of the drives: the controller, which knows the torque that acts, is built for them.

    Whether there is a lag, the delay, and with either of them the clock's steps, cannot change.
    """
    actuator = scenario.actuator
    lag = (SMALLEST, LARGEST) if actuator.lag > 0 else (0.0, 0.0)
    held = {"actuator.delay": (actuator.delay, actuator.delay), "actuator.lag": lag}
    return held | clock_of(scenario)


def _seed() -> Variable:
    return Variable(SEED.name, SEED.unit, SEED.meaning, Role.FIXED, 0.0, 0.0, MOST, integer=True)


def _changes(scenario: Scenario) -> Iterable[Variable]:
    """Parameters ``changes[1].t`` and so on: what the scenario changes, and when."""
    for k, change in enumerate(scenario.changes, start=1):
        for item in fields(Change):
            value = getattr(change, item.name)
            if value is not None:
                low, high = _change_range(item.name)
                yield Variable(
                    f"changes[{k}].{item.name}",
                    item.metadata["unit"],
                    item.metadata["doc"],
                    Role.FIXED,
                    float(value),
                    low,
                    high,
                )


def _change_range(name: str) -> Range:
    bounds = next(item.metadata["bounds"] for item in fields(Change) if item.name == name)
    low = bounds.minimum if bounds.minimum is not None else bounds.above + 1e-12
    return float(low), LARGEST


def _layout(rows: tuple[Variable, ...], first_output: int, scenario: Scenario) -> dict[str, int]:
    at = {row.name: i for i, row in enumerate(rows)}
    named = {
        f"AT_{key.replace('.', '_').upper()}": at.get(key, at.get(f"{key}[1]", 0))
        for key in KEYS[2:]
    }
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
        "Y": first_output,
        "NW": len(rows) - first_output,
        "CONTINUOUS_STATES": 0,
        "HAS_ME": 0,
        "CHANGES": len(scenario.changes),
        "DELAY_MAX": round(scenario.actuator.delay / scenario.clock.plant),
        "AT_INITIAL": at["initial.pose[1]"],
        "AT_SEED": at["seed"],
        "AT_MAX_ABS_V": at["max_abs_v[1]"],
        "AT_VIOLATIONS": at["violations"],
        **named,
    }


def _tables(
    rows: tuple[Variable, ...], systems: LoopSystems, scenario: Scenario
) -> dict[str, Sequence[Sequence[float]]]:
    """Rows that the Systems' parameters are read from, and what each change puts there."""
    at = {row.name: i for i, row in enumerate(rows)}
    names = {role: _names(system) for role, system in systems.by_role().items()}
    changed = [
        [
            at.get(f"changes[{k}].{name.removeprefix('robot.')}", 0)
            if name.startswith("robot.")
            else 0
            for name in names["plant"]
        ]
        for k in range(1, len(scenario.changes) + 1)
    ]
    times = [at[f"changes[{k}].t"] for k in range(1, len(scenario.changes) + 1)]
    return {
        **{
            f"{role.upper()}_ROWS": [[at[name] for name in listed]]
            for role, listed in names.items()
        },
        "CHANGE_ROWS": [*changed, [0] * len(names["plant"])],
        "CHANGE_TIME_ROWS": [[*times, 0]],
        "CONTROLLER_START": [systems.controller.x0],
    }


def _names(system: System) -> list[str]:
    return [name for port in system.params for name in port.signal.elements]
