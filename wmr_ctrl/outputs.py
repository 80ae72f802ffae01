"""What is written for other tools: FMUs, SSP package, Modelica package, Simulink kit."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.scenario import Scenario, load_scenario

if TYPE_CHECKING:
    from wmr_ctrl.api_types import ExportOptions

SCENARIO = "paper-simulation"
"""The scenario where none is named."""


def read_by(what: str) -> tuple[str, ...]:
    """Names of the options that an output reads: those of the function that writes it."""
    return tuple(signature(_writer(what)).parameters)


def write_output(what: str, options: ExportOptions) -> list[Path]:
    """Write ``what``; returns the files' paths.

    ArgumentError for an option that it has no use for.
    """
    for name in options:
        if name not in read_by(what):
            raise ArgumentError(f"the output {what!r} does not read {name}. Leave it out.")
    given: dict[str, Any] = {**options}
    if what in ("modelica", "simulink"):
        given["scenario"] = _scenario(options)
    return _writer(what)(**given)


def _writer(what: str) -> Callable[..., list[Path]]:
    if what == "ssp":
        from wmr_ctrl.fmi.ssp import export_ssp

        return export_ssp
    if what == "modelica":
        from wmr_ctrl.modelica import export_modelica

        return export_modelica
    if what == "simulink":
        from wmr_ctrl.simulink import export_simulink

        return export_simulink
    from wmr_ctrl.fmi.export import export_fmu

    return partial(export_fmu, what)


def _scenario(options: ExportOptions) -> Scenario:
    given = options.get("scenario", SCENARIO)
    return given if isinstance(given, Scenario) else load_scenario(given)
