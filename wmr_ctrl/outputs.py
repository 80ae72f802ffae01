"""What is written for other tools: FMUs, SSP package, Modelica package, Simulink kit."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, cast

from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.scenario import Scenario, load_scenario

if TYPE_CHECKING:
    from wmr_ctrl.api_types import ExportOptions, FmuOptions, SspOptions

SCENARIO = "paper-simulation"
"""The scenario where none is named."""
_COMMON = ("law", "scenario", "fmi", "target", "out", "progress")
_FMUS = (*_COMMON, "arrays")
_READ = {
    "ssp": (*_COMMON, "plant", "controller", "map_file", "delay_known"),
    "modelica": ("scenario", "out"),
    "simulink": ("law", "scenario", "out"),
}


def read_by(what: str) -> tuple[str, ...]:
    """Names of the options that an output reads."""
    return _READ.get(what, _FMUS)


def write_output(what: str, options: ExportOptions) -> list[Path]:
    """Write ``what``; returns the files' paths.

    ArgumentError for an option that it has no use for.
    """
    for name in options:
        if name not in read_by(what):
            raise ArgumentError(f"the output {what!r} does not read {name}. Leave it out.")
    if what == "ssp":
        from wmr_ctrl.fmi.ssp import export_ssp

        return export_ssp(**cast("SspOptions", options))
    if what == "modelica":
        from wmr_ctrl.modelica import export_modelica

        return export_modelica(scenario=_scenario(options), out=options.get("out", "."))
    if what == "simulink":
        from wmr_ctrl.simulink import export_simulink

        law, out = options.get("law", "nn"), options.get("out", ".")
        return export_simulink(law=law, scenario=_scenario(options), out=out)
    from wmr_ctrl.fmi.export import export_fmu

    return export_fmu(what, **cast("FmuOptions", options))


def _scenario(options: ExportOptions) -> Scenario:
    given = options.get("scenario", SCENARIO)
    return given if isinstance(given, Scenario) else load_scenario(given)
