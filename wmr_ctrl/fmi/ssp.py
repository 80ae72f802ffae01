"""SSP package: reference, controller and plant, wired, with units and parameter sets."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.fmi.blocks import parallel
from wmr_ctrl.fmi.export import TOOL, Progress, model_of, scenario_given, versions_of, write_fmu
from wmr_ctrl.fmi.model import FmuModel
from wmr_ctrl.fmi.package import write_archive
from wmr_ctrl.fmi.targets import targets_of
from wmr_ctrl.fmi.templates import render
from wmr_ctrl.fmi.units import units_of
from wmr_ctrl.fmi.variables import Role, Variable
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import (
    BODY_FORCE,
    DIAGNOSTICS,
    GUARD_DIAGNOSTICS,
    POSE,
    TAU_APPLIED,
    TORQUE,
    TORQUE_NOISE,
    VELOCITY,
)
from wmr_ctrl.world.effect import Effect, EffectRole

MARGIN = next(signal for signal in DIAGNOSTICS if signal.name == "margin")
SHOWN = tuple(
    name
    for signal in (*POSE, *VELOCITY, *TORQUE, MARGIN, *GUARD_DIAGNOSTICS)
    for name in signal.elements
)
"""Outputs of the whole system: its motion, and what the controller's monitor says of it."""
DISTURBANCE = tuple(s.name for s in (*TORQUE_NOISE, *BODY_FORCE))
"""Inputs of the whole system; zero where nobody connects them."""
ORDER = ("reference", "controller", "plant")
_NOT_IN = "without the scenario's noise and changes of the robot"


def export_ssp(
    *,
    law: str = "nn",
    scenario: str | Path | Scenario = "paper-simulation",
    fmi: str | int = "2",
    target: str = "host",
    out: str | Path = ".",
    progress: Progress | None = None,
) -> list[Path]:
    """Write ``wmr.ssp`` into the folder ``out``: FMI 2.0 FMUs of reference, ``law`` and plant.

    ``fmi``: "2", or "both", which is 2 here: SSP 1.0 came before FMI 3.

    The FMUs are set for masters that step all parts at once; see docs/fmu.md for what that master's
    delay does to each law.  The package has no noise and no changes of the robot: those come from
    outside.  Raises ArgumentError for FMI 3 and for effects that it cannot hold, by name;
    UnknownNameError, ScenarioError or CompilerError.
    """
    if 2 not in versions_of(fmi):
        raise ArgumentError(
            f"fmi = {fmi!r}: an SSP 1.0 package holds FMUs of FMI 2.0. Leave fmi out, or export "
            "the parts by themselves for FMI 3."
        )
    setup = settle(scenario_given(scenario), law)
    _check_contents(setup)
    models = {
        name: parallel(model_of(law if name == "controller" else name, law, setup.scenario))
        for name in ORDER
    }
    files = {"SystemStructure.ssd": _structure(models, setup.scenario).encode()}
    for name, model in models.items():
        files[f"resources/{name}.ssv"] = _parameters(name, model).encode()
        files[f"resources/{model.identifier}.fmu"] = _fmu(model, target)
    path = write_archive(Path(out) / "wmr.ssp", files)
    if progress:
        progress(f"{path}: reference, {law} and plant, {target}")
    return [path]


def _check_contents(setup: Setup) -> None:
    """Raise ArgumentError where the loop has more parts than reference, controller and plant.

    Numbers that are drawn at random come from outside, so an effect of draws alone is left out.
    """
    lost = [item for item in setup.effects if _is_lost(item, setup.scenario)]
    if lost:
        names = ", ".join(f"{item.name} ([{item.section.KEY}])" for item in lost)
        raise ArgumentError(
            f"an SSP package holds reference, controller and plant, and this scenario has more: "
            f"{names}. Export the closed-loop FMU, which has all, or take that out of the scenario."
        )


def _is_lost(effect: Effect, scenario: Scenario) -> bool:
    """Whether an effect would be missed: it acts, and is more than noise at the plant's inputs."""
    if effect.role is EffectRole.DISTURBANCE and effect.build(scenario).draws:
        return bool(effect.build(scenario).state)
    return effect.acts(scenario)


def _fmu(model: FmuModel, target: str) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{model.identifier}.fmu"
        return write_fmu(model, 2, targets_of(target), path, result=False).read_bytes()


def _structure(models: dict[str, FmuModel], scenario: Scenario) -> str:
    ports = {name: list(_ports(model)) for name, model in models.items()}
    every = [port["unit"] for listed in ports.values() for port in listed]
    return render(
        "SystemStructure.ssd",
        m={
            "tool": TOOL,
            "title": f"{scenario.title or scenario.name}; {_NOT_IN}",
            "stop": repr(scenario.clock.duration),
            "ports": [
                {"name": n, "kind": k, "unit": _unit_of(models, n)} for n, k in _outside(models)
            ],
            "parts": [_part(name, model, ports[name]) for name, model in models.items()],
            "connections": list(_connections(models)),
            "units": _units(every),
        },
    )


def _part(name: str, model: FmuModel, ports: list[dict[str, str]]) -> dict[str, Any]:
    return {
        "name": name,
        "source": f"resources/{model.identifier}.fmu",
        "parameters": f"resources/{name}.ssv",
        "ports": ports,
    }


def _ports(model: FmuModel) -> Iterator[dict[str, str]]:
    for v in model.variables:
        if v.role is Role.INPUT or (v.output and not v.array):
            yield {
                "name": v.name,
                "kind": "input" if v.role is Role.INPUT else "output",
                "unit": v.unit,
            }


def _outside(models: dict[str, FmuModel]) -> list[tuple[str, str]]:
    names = {v.name for model in models.values() for v in model.variables if v.output}
    return [
        *((name, "input") for name in DISTURBANCE),
        *((name, "output") for name in SHOWN if name in names),
    ]


def _unit_of(models: dict[str, FmuModel], name: str) -> str:
    return next(v.unit for model in models.values() for v in model.variables if v.name == name)


def _connections(models: dict[str, FmuModel]) -> Iterator[list[tuple[str, str]]]:
    """Each input to the output of its name; the applied torque is the controller's own."""
    owner = {v.name: part for part, model in models.items() for v in model.variables if v.output}
    renamed = dict(zip(TAU_APPLIED.elements, (s.name for s in TORQUE), strict=True))
    for part, model in models.items():
        for v in model.variables:
            if v.role is Role.INPUT:
                yield _line(owner, renamed.get(v.name, v.name), part, v)
    for name in SHOWN:
        yield [("startElement", owner[name]), ("startConnector", name), ("endConnector", name)]


def _line(owner: dict[str, str], source: str, part: str, v: Variable) -> list[tuple[str, str]]:
    start = [] if source in DISTURBANCE else [("startElement", owner[source])]
    return [*start, ("startConnector", source), ("endElement", part), ("endConnector", v.name)]


def _parameters(name: str, model: FmuModel) -> str:
    listed = [v for v in model.variables if v.parameter and not v.integer]
    return render(
        "parameters.ssv",
        m={
            "name": name,
            "tool": TOOL,
            "units": _units([v.unit for v in listed]),
            "parameters": [
                {"name": v.name, "value": repr(v.start), "unit": v.unit} for v in listed
            ],
        },
    )


def _units(names: list[str]) -> list[dict[str, Any]]:
    return [{"name": unit.name, "base": list(unit.exponents.items())} for unit in units_of(names)]
