"""Outputs for other tools: FMUs, SSP package, Modelica package, Simulink kit; films."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from inspect import signature
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.scenario import Scenario, load_scenario

if TYPE_CHECKING:
    from wmr_ctrl.api_types import ExportOptions
    from wmr_ctrl.campaign import PhaseProgress
    from wmr_ctrl.results import Run

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
        chosen = options.get("scenario", SCENARIO)
        given["scenario"] = chosen if isinstance(chosen, Scenario) else load_scenario(chosen)
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


def film_run(run: Run, path: str | PathLike[str], progress: PhaseProgress | None = None) -> None:
    """Film a run on the rigid body in three dimensions; as `Run.film`."""
    from wmr_ctrl.engines import runnable_plantless
    from wmr_ctrl.physics.film import moments_of
    from wmr_ctrl.report.animate import MOST_MOMENTS, check_film, write_moments
    from wmr_ctrl.scenario import loads_scenario

    check_film(path, run.settings.plant_kind)
    loop = runnable_plantless(loads_scenario(str(run.provenance["scenario_toml"])), run.law)
    moments = moments_of(loop, run, MOST_MOMENTS[Path(path).suffix.lower()])
    write_moments(run, moments, path, progress)
