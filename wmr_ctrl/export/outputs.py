"""Outputs for other tools: FMUs, SSP package, Modelica package, Simulink kit."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib import import_module
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.files import one_command
from wmr_ctrl.world.scenario import Scenario, load_scenario

if TYPE_CHECKING:
    from .api_types import ExportOptions

SCENARIO = "paper-simulation"
"""The scenario where none is named."""
_WRITERS = {
    "ssp": ("wmr_ctrl.export.fmi.ssp", "export_ssp"),
    "modelica": ("wmr_ctrl.export.modelica", "export_modelica"),
    "simulink": ("wmr_ctrl.export.simulink", "export_simulink"),
}
"""Module and function that write an output; all others are FMUs."""


def read_by(what: str) -> tuple[str, ...]:
    """Names of the options of an output: the arguments of the function that writes it."""
    return tuple(signature(_writer(what)).parameters)


@one_command()
def write_output(what: str, options: ExportOptions) -> list[Path]:
    """Write ``what``; returns the files' paths.

    Raises ArgumentError for an option that this output does not have.
    """
    for name in options:
        if name not in read_by(what):
            raise ArgumentError(f"the output {what!r} does not use {name}. Leave it out.")
    given: dict[str, Any] = {**options}
    if what in ("modelica", "simulink"):
        chosen = options.get("scenario", SCENARIO)
        given["scenario"] = chosen if isinstance(chosen, Scenario) else load_scenario(chosen)
    return _writer(what)(**given)


def _writer(what: str) -> Callable[..., list[Path]]:
    module, name = _WRITERS.get(what, ("wmr_ctrl.export.fmi.fmu_files", "export_fmu"))
    write: Callable[..., list[Path]] = vars(import_module(module))[name]
    return write if what in _WRITERS else partial(write, what)
