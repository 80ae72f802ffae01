"""The Modelica package WheeledRobot: plant, reference, every law, closed loops, imported FMUs.

Everything in it comes from the Systems of a scenario: ports with their units, parameters with their
values, and the graphs themselves. A law is a block that calls one function at each sample, and that
function has one vector as its result (next memory, torques, diagnostics): ordinary Modelica 3,
which the tested compilers accept.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import casadi as ca

from wmr_ctrl.codegen.emit import kernel
from wmr_ctrl.codegen.package import text_engine
from wmr_ctrl.control.controller import controller
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.control.outside import check_plain_loop
from wmr_ctrl.control.setup import check_scenario, settle
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.section import quantities
from wmr_ctrl.core.signals import TIME, Signal
from wmr_ctrl.results import write_all
from wmr_ctrl.version import __version__
from wmr_ctrl.world.model.dynamics import plant
from wmr_ctrl.world.model.system import Output, Port, System, stack
from wmr_ctrl.world.references.kind import reference
from wmr_ctrl.world.scenario import Change, Scenario

from . import diagram
from .statements import algorithm, equations, literal

FILE = "WheeledRobot.mo"
CLOCK = "clock.control"
RESULT = "y"
"""Name of a function's one result."""
_TEMPLATES = Path(__file__).parent
_ESCAPES = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t"}


@dataclass(frozen=True)
class Member:
    """A port or parameter in Modelica."""

    signal: Signal
    value: tuple[float, ...] = ()

    @property
    def name(self) -> str:
        """The signal's name as an identifier: ``gains.mb.rho`` as gains_mb_rho."""
        return re.sub(r"\W+", "_", self.signal.name, flags=re.ASCII).strip("_")

    @property
    def size(self) -> str:
        """``[n]`` for a vector, empty for a scalar."""
        return "" if self.signal.size == 1 else f"[{self.signal.size}]"

    @property
    def unit(self) -> str:
        """Unit modification: one, one for all elements, or one per element."""
        units = self.signal.units
        if self.signal.size == 1:
            return f'unit = "{units[0]}"'
        if len(set(units)) == 1:
            return f'each unit = "{units[0]}"'
        return "unit = {" + ", ".join(f'"{item}"' for item in units) + "}"

    @property
    def start(self) -> str:
        """The value: a number, or an array of them."""
        return literal(self.value[0]) if self.signal.size == 1 else vector(self.value)

    @property
    def meaning(self) -> str:
        """Comment: the signal's meaning."""
        return self.signal.meaning

    @property
    def elements(self) -> tuple[str, ...]:
        """Expressions of the elements."""
        if self.signal.size == 1:
            return (self.name,)
        return tuple(f"{self.name}[{k}]" for k in range(1, self.signal.size + 1))


def members(items: Iterable[Port | Output]) -> list[Member]:
    """Members of ports or outputs, in order."""
    return [Member(p.signal, p.value if isinstance(p, Port) else ()) for p in items]


def vector(numbers: Iterable[float]) -> str:
    """An array constructor."""
    listed = list(numbers)
    if len(listed) > 8 and len(set(listed)) == 1:
        return f"fill({literal(listed[0])}, {len(listed)})"
    return "{" + ", ".join(map(literal, listed)) + "}"


def quoted(text: str) -> str:
    """A text for use between the quotation marks of a string."""
    return "".join(_ESCAPES.get(c, c if c.isprintable() else " ") for c in text)


def export_modelica(*, scenario: Scenario, out: str | Path = ".") -> list[Path]:
    """Write WheeledRobot.mo atomically into the folder ``out``; returns its path.

    Raises the errors of `modelica_package`, and ResultFileError if it cannot be written.
    """
    return write_all({FILE: modelica_package(scenario)}, Path(out))


def modelica_package(scenario: Scenario) -> str:
    """Text of the package for a scenario: its numbers are the defaults, its changes the plant's.

    Noise is left out, since random numbers come from outside.  Raises ArgumentError for effects
    that a loop of reference, controller and plant would lack, and for a reference with state;
    ScenarioError or UnknownNameError as building a law does.
    """
    check_scenario(scenario)
    setups = [settle(scenario, name) for name in LAWS]
    check_plain_loop(setups[0], "the Modelica package")
    controllers = [controller(setup) for setup in setups]
    clock = Member(*scenario.number(CLOCK))
    robot, desired = plant(scenario), members(reference(scenario).outputs)
    inputs, outputs = members(controllers[0].inputs), members(controllers[0].outputs)
    sides = (desired, inputs, outputs, members(robot.inputs), members(robot.outputs))
    ports = diagram.places_of_parts(*([member.name for member in side] for side in sides))
    parts = ("reference", "controller", "plant")
    noisy = any(item.active(scenario) for item in setups[0].effects)
    engine = text_engine(_TEMPLATES)
    engine.filters["quoted"] = quoted
    return engine.get_template("package.mo.j2").render(
        version=__version__,
        scenario=scenario,
        clock=clock,
        noisy=noisy,
        reference=_reference(scenario),
        controller={"inputs": inputs, "outputs": outputs},
        plant=_plant(scenario, robot),
        laws=[_law(system, clock) for system in controllers],
        ports=ports,
        diagram=diagram,
        wires=diagram.wires_of_loop(ports),
        imported={name: diagram.wires_within(ports[name]) for name in parts},
    )


def _function(system: System) -> Mapping[str, object]:
    """One vector (next memory, outputs, diagnostics) of inputs, memory and parameters."""
    given = {"u": system.u, "x": system.x, "p": system.p}
    shown = stack(item.expr for item in (*system.outputs, *system.diagnostics))
    used = {name: sym for name, sym in given.items() if sym.numel()}
    step = kernel("step", system.title, used, {RESULT: ca.vertcat(system.update, shown)})
    declared, statements = algorithm(step.graph)
    return {
        "title": system.title,
        "assignments": _assignments(system),
        "sizes": {name: step.function.numel_in(name) for name in step.inputs},
        "result": step.function.numel_out(RESULT),
        "locals": declared,
        "statements": statements,
    }


def _elements(items: Iterable[Port | Output]) -> list[str]:
    return [element for member in members(items) for element in member.elements]


def _array(elements: Iterable[str]) -> str:
    return f"{{{', '.join(elements)}}}"


def _law(system: System, clock: Member) -> Mapping[str, object]:
    """A sampled block: its parameters, memory, and outputs as parts of the function's result."""
    parameters, memory = members(system.params), system.x0
    arguments = [_array(_elements(system.inputs))]
    arguments += ["pre(memory)"] * bool(memory)
    arguments += [_array(_elements(system.params))]
    taken = {item.signal.name for item in system.outputs}
    shown = [item for item in members(system.diagnostics) if item.signal.name not in taken]
    return {
        "name": system.name,
        "class_name": system.name[:1].upper() + system.name[1:],
        "parameters": [clock, *(item for item in parameters if item.name != clock.name)],
        "memory": vector(memory) if memory else "",
        "count": len(memory),
        "call": f"({', '.join(arguments)})",
        "diagnostics": shown,
        "ports": diagram.edge([item.name for item in shown], diagram.EDGE, 90),
        **_function(system),
    }


def _assignments(system: System) -> list[tuple[str, str]]:
    """Each output and diagnostic with its part of the function's result."""
    shown = _elements((*system.outputs, *system.diagnostics))
    return [(name, f"result[{k}]") for k, name in enumerate(shown, start=len(system.x0) + 1)]


def _reference(scenario: Scenario) -> Mapping[str, object]:
    """The desired trajectory: a function of time and parameters."""
    system = reference(scenario)
    if system.x.numel() or [item.signal for item in system.inputs] != [TIME]:
        raise ArgumentError(
            f"the reference {scenario.reference_kind.name} has memory, which the Modelica package "
            "cannot represent. Choose another reference.kind, or export the reference as an FMU."
        )
    parameters = members(system.params)
    numbers = [_array(_elements(system.params))] if parameters else []
    return {
        "parameters": parameters,
        "outputs": members(system.outputs),
        "call": f"({', '.join(['{time}', *numbers])})",
        **_function(system),
    }


def _plant(scenario: Scenario, system: System) -> Mapping[str, object]:
    """The robot as equations, its changes as parameters with the time of each."""
    inputs, state = members(system.inputs), members(system.state)
    taken = {item.signal.name for item in system.state}
    more = [item for item in system.outputs if item.signal.name not in taken]
    changes, now = _changes(scenario)
    names = {
        "u": _elements(system.inputs),
        "x": _elements(system.state),
        "p": [now.get(name, (name, ""))[0] for name in _elements(system.params)],
    }
    given = {"u": system.u, "x": system.x, "p": system.p}
    rate = {"rate": system.update, "y": stack(item.expr for item in more)}
    whole = kernel("plant", system.title, given, rate)
    left = {("rate", k): f"der({name})" for k, name in enumerate(names["x"])}
    left |= {("y", k): item.name for k, item in enumerate(members(more))}
    lines = equations(whole.graph, lambda vector, k: names[vector][k], left)
    return {
        "title": system.title,
        "inputs": inputs,
        "state": state,
        "outputs": members(more),
        "parameters": [*members(system.params), *changes],
        "now": list(now.values()),
        "equations": lines,
        "locals": sorted(set(re.findall(r"^(t\d+) =", "\n".join(lines), flags=re.M))),
        "disturbances": [m for m in inputs if not m.name.startswith("tau")],
    }


def _changes(scenario: Scenario) -> tuple[list[Member], dict[str, tuple[str, str]]]:
    """Parameters ``changes_1_t`` and so on; by changed parameter its name and value in time."""
    listed: list[Member] = []
    now: dict[str, tuple[str, str]] = {}
    fields = dict(quantities(Change))
    for k, change in enumerate(scenario.changes, start=1):
        for name, value in {"t": change.t, **change.values()}.items():
            signal = Signal(f"changes.{k}.{name}", fields[name].unit, fields[name].doc)
            listed.append(Member(signal, (value,)))
        for name in change.values():
            before = now.get(f"robot_{name}", ("", f"robot_{name}"))[1]
            after = f"(if time < changes_{k}_t then {before} else changes_{k}_{name})"
            now[f"robot_{name}"] = (f"robot_{name}_now", after)
    return listed, now
