"""Manifest: what a compiled library holds, as plain data for layers that never import CasADi."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from wmr_ctrl.codegen.source import sizes
from wmr_ctrl.model.system import Output, Port, System, values
from wmr_ctrl.signals import LOG_HEAD, Signal


def manifest(
    law: str,
    title: str,
    systems: Mapping[str, System],
    own: tuple[Signal, ...],
    phases: list[tuple[int, list[float]]],
) -> dict[str, Any]:
    """Sizes, signals, parameter values and start values of every System of one closed loop."""
    roles = {role: _role(system) for role, system in systems.items()}
    columns = [asdict(signal) for signal in (*LOG_HEAD, *own)]
    return {
        "law": law,
        "title": title,
        "systems": roles,
        "columns": columns,
        "phases": [{"step": step, "parameters": row} for step, row in phases],
    }


def _role(system: System) -> dict[str, Any]:
    groups: dict[str, tuple[Port | Output, ...]] = {
        "inputs": system.inputs,
        "state": system.state,
        "parameters": system.params,
        "outputs": system.outputs,
        "diagnostics": system.diagnostics,
    }
    named = {key: [asdict(item.signal) for item in group] for key, group in groups.items()}
    return {
        **named,
        "sizes": sizes(system),
        "parameter_values": values(system.params),
        "start": values(system.state),
    }


@dataclass(frozen=True)
class Kernels:
    """A compiled closed loop: path of the library, its manifest, and the hash of its content."""

    library: str
    manifest: Mapping[str, Any]
    digest: str
