"""Models of single blocks: plant, laws, reference, guard, command filter, corridor monitor.

A block is a System as one function of its known values, with its derivatives.  The known values z
are, in order: inputs, parameters, state.  The results w are the rates (continuous systems), the
outputs that are not states, and the diagnostics.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from types import MappingProxyType

import casadi as ca
import numpy as np

from wmr_ctrl.codegen.emit import Kernel, kernel
from wmr_ctrl.codegen.kernels import sizes_of
from wmr_ctrl.control.controller import asking_controller, guard
from wmr_ctrl.control.filter.channels import (
    AXES,
    FLAG_MEANINGS,
    FLAG_NAMES,
    FLAGS,
    SENT,
    TOLD_FLAGS,
    has_bit,
)
from wmr_ctrl.control.filter.filter import called_filter
from wmr_ctrl.control.loop import rolling_of
from wmr_ctrl.control.numbers import Range, clock_of, ranges_of
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.core.signals import ASKED, POSE, REFERENCE, VELOCITY, Signal
from wmr_ctrl.core.signals import TIME as SECONDS
from wmr_ctrl.theory.corridor import corridor_monitor
from wmr_ctrl.world.effect import EffectRole
from wmr_ctrl.world.model.dynamics import plant, rk4_step
from wmr_ctrl.world.model.system import Output, Parameters, System, port, stack
from wmr_ctrl.world.references import sample
from wmr_ctrl.world.references.kind import reference
from wmr_ctrl.world.registry import EFFECTS
from wmr_ctrl.world.scenario import Scenario

from .model_description import (
    TIME,
    FmuModel,
    Variable,
    input_rows,
    output_rows,
    parameter_rows,
    rate_rows,
    state_rows,
)

CHANGED = ("robot.m", "robot.I", "robot.mu")
"""The plant's parameters that may be changed while it runs, as the paper does at 40 s."""
SHARE = Signal("share", "1", "share of the command asked for that is sent, by axis", 2)
PARALLEL = Signal(
    "clock.parallel",
    "1",
    "1: for masters that step all parts at once; the first sample uses the inputs of "
    "initialisation",
)
"""Parameter of sampled blocks with inputs that their kernels do not read; the stepping does."""


def stepped_plant(scenario: Scenario) -> tuple[System, Kernel]:
    """The plant, and its Runge-Kutta step in the native loop; the last parameter is that step [s].

    It outputs the path length if a sensor of the scenario needs it.
    """
    sensors = [item.system(scenario) for item in EFFECTS.present(scenario, EffectRole.SENSOR)]
    system = plant(scenario, rolling=rolling_of(sensors)[:1])
    p = Parameters(scenario, system.params)
    following = rk4_step(system, p.take("clock.plant"))
    stepped = replace(system, params=p.ports)
    given = {"u": stepped.u, "x": stepped.x, "p": stepped.p}
    meaning = "State after one Runge-Kutta step, inputs held."
    return stepped, kernel("rk4", meaning, given, {"next": following})


def plant_model(scenario: Scenario) -> FmuModel:
    """The robot: torques in, pose, velocity and heading out."""
    system, step = stepped_plant(scenario)
    title = "Wheeled robot, Eqs. (1)-(6)"
    return _model("plant", title, scenario, system, more=(step,), tunable=CHANGED)


def law_model(setup: Setup) -> FmuModel:
    """One control law with monitor: reference, pose and velocity in, torques and diagnostics out.

    For a base that takes velocities the output is the command, after the filter if there is one;
    such a law has no derivatives, and since a filter counts in periods the period is fixed.
    """
    law, system = setup.control_law, asking_controller(setup)
    if setup.takes_velocity:
        return _counting(
            law.name, setup.scenario, replace(system, title=f"control law: {law.title}")
        )
    return _model(law.name, f"Control law: {law.title}", setup.scenario, _sampled(system))


def guard_model(setup: Setup) -> FmuModel:
    """The velocity guard for any law: requested force and measured velocity in, torques out."""
    return _model("guard", "Velocity guard", setup.scenario, _sampled(guard(setup)))


def filter_model(scenario: Scenario) -> FmuModel:
    """The command filter of a scenario: any velocity in, a safe one out.

    Further outputs are its share of the requested velocity, and its flags one by one.  It has no
    derivatives: those of the band's tables would be longer than all the rest.

    Raises ScenarioError if no filter is set, or if its limit cannot be kept.
    """
    system = called_filter(scenario)
    results = {item.signal: item.expr for item in system.outputs}
    asked = next(item.sym for item in system.inputs if item.signal == ASKED)
    sent = results[SENT]
    shares = (ca.if_else(asked[i] == 0, 1, sent[i] / asked[i]) for i in AXES)
    flags = (
        Output(
            Signal(name.replace("-", "_"), "1", f"1: {FLAG_MEANINGS[bit]}"),
            has_bit(results[FLAGS], bit),
        )
        for bit, name in FLAG_NAMES.items()
        if scenario.filter.is_told or bit not in TOLD_FLAGS
    )
    shown = (Output(SHARE, ca.vertcat(*shares)), *flags)
    return _counting("filter", scenario, replace(system, diagnostics=shown))


def corridor_model(scenario: Scenario, law: str) -> FmuModel:
    """The monitor of a law's certified corridor: the law's inputs and outputs in, verdict out.

    It has no derivatives, because of its comparisons.
    """
    return _counting("corridor", scenario, corridor_monitor(scenario, law))


def _counting(what: str, scenario: Scenario, system: System) -> FmuModel:
    """The model of a System that counts in periods: without derivatives, with a fixed period."""
    p, T = Parameters(scenario, system.params), scenario.clock.control
    p.take("clock.control")
    fixed, timed = {"clock.control": (T, T)}, _sampled(replace(system, params=p.ports))
    title = f"{system.title[0].upper()}{system.title[1:]}"
    return _model(what, title, scenario, timed, fixed=fixed, derived=False)


def reference_model(scenario: Scenario) -> FmuModel:
    """The desired trajectory, sampled with the control period."""
    system = reference(scenario)
    p = Parameters(scenario, system.params)
    p.take("clock.control")
    timed = replace(system, params=p.ports, period=scenario.clock.control)
    return _model("reference", "Desired trajectory", scenario, timed)


def _sampled(system: System) -> System:
    """The System for masters that may step all parts together."""
    return replace(system, params=(*system.params, port(PARALLEL)))


def results_of(system: System) -> tuple[Output, ...]:
    """Outputs that are not continuous states themselves, then the diagnostics."""
    states = {} if system.period else {item.signal.name: item.sym for item in system.state}
    pairs = ((item, states.get(item.signal.name)) for item in system.outputs)
    own = (item for item, sym in pairs if sym is None or not ca.is_equal(ca.SX(item.expr), sym))
    return (*own, *system.diagnostics)


def _derivatives(z: ca.SX, w: ca.SX) -> tuple[Kernel, Kernel]:
    dz, bar = ca.SX.sym("dz", z.numel()), ca.SX.sym("bar", w.numel())
    forward, reverse = ca.jtimes(w, z, dz), ca.jtimes(w, z, bar, True)
    along = "Jacobian of the results times a direction."
    back = "Transposed Jacobian of the results times weights."
    return (
        kernel("forward_rows", along, {"z": z, "dz": dz}, {"dw": ca.densify(forward)}),
        kernel("reverse_rows", back, {"z": z, "bar": bar}, {"back": ca.densify(reverse)}),
    )


def parallel(model: FmuModel) -> FmuModel:
    """The model for masters that step all parts together."""
    rows = (replace(v, start=1.0) if v.name == PARALLEL.name else v for v in model.variables)
    return replace(model, variables=tuple(rows))


def _model(
    what: str,
    title: str,
    scenario: Scenario,
    system: System,
    *,
    more: tuple[Kernel, ...] = (),
    derived: bool = True,
    tunable: tuple[str, ...] = (),
    fixed: Mapping[str, Range] = MappingProxyType({}),
) -> FmuModel:
    """The model of a System, with ``more`` kernels.

    Kernels are those of the native loop, from the same graphs and with the same vector names, so
    that both compute the same bits; derivatives need not be fast.
    """
    results = results_of(system)
    own = stack(item.expr for item in results[: len(results) - len(system.diagnostics)])
    given = {"u": system.u, "x": system.x, "p": system.p}
    shown = {"next": system.update, "y": own, "d": system.d}
    evaluate = kernel("evaluate", f"Results of the {system.title}.", given, shown)
    z, y = ca.vertcat(system.u, system.p, system.x), stack(item.expr for item in results)
    w = y if system.period else ca.vertcat(system.update, y)
    whole = ca.Function("evaluate", [z], [ca.vertcat(system.update, y)], ["z"], ["w"])
    sections = _sections(scenario, system, [item.signal for item in results], tunable, fixed)
    rows = tuple(row for section in sections.values() for row in section)
    at = {row.name: i for i, row in enumerate(rows)}
    layout = _layout(sections, system)
    name, key = ("AT_PERIOD", "clock.control") if system.period else ("AT_STEP", "clock.plant")
    layout[name] = at[key]
    if PARALLEL.name in at:
        layout["AT_PARALLEL"] = at[PARALLEL.name]
    return FmuModel(
        what,
        title,
        "sampled" if system.period else "continuous",
        scenario,
        rows,
        sizes_of("block", system),
        (evaluate, *more),
        _derivatives(z, w) if derived else (),
        layout,
        dependencies=_dependencies(z, w, layout),
        graph=_saved(whole),
    )


def _saved(function: ca.Function) -> str:
    """Text that `casadi.Function.load` reads."""
    with TemporaryDirectory() as folder:
        file = Path(folder, "evaluate.casadi")
        function.save(str(file))
        return file.read_text(encoding="ascii")


def _dependencies(
    z: ca.SX, w: ca.SX, layout: Mapping[str, int]
) -> dict[int, list[tuple[int, bool]]]:
    """Rows that each row of w depends on, and whether the dependence is a constant."""
    first, known = layout["W"], layout["Z"]
    on: dict[int, list[tuple[int, bool]]] = {first + row: [] for row in range(layout["NW"])}
    jacobian = ca.jacobian(w, z)
    places = enumerate(zip(*jacobian.sparsity().get_triplet(), strict=True))
    for row, column, constant in sorted((*at, jacobian.nz[k].is_constant()) for k, at in places):
        on[first + row].append((known + column, constant))
    return on


def _sections(
    scenario: Scenario,
    system: System,
    results: list[Signal],
    tunable: tuple[str, ...],
    fixed: Mapping[str, Range],
) -> Mapping[str, list[Variable]]:
    """Rows in the order of the C code: time, inputs, parameters, states, rates, results."""
    discrete = system.period is not None
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
    """True if the only input is time, which every FMU has."""
    return [port.signal.name for port in system.inputs] == [SECONDS.name]


def _layout(sections: Mapping[str, list[Variable]], system: System) -> dict[str, int]:
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
