"""Outputs for other tools: FMUs, SSP package, Modelica package, Simulink kit; films."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from importlib import import_module
from inspect import signature
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.files import one_command
from wmr_ctrl.world.scenario import Scenario, load_scenario

if TYPE_CHECKING:
    from wmr_ctrl.results import Run
    from wmr_ctrl.simulation.campaign import PhaseProgress

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
    """Names of the options of an output, which are those of the function that writes it."""
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


def film_run(run: Run, path: str | PathLike[str], progress: PhaseProgress | None = None) -> None:
    """Film a run on the rigid body in three dimensions; as `Run.film`."""
    from wmr_ctrl.report.animate import MOST_MOMENTS, check_film, write_moments
    from wmr_ctrl.report.course import course_behind
    from wmr_ctrl.simulation.engines import runnable
    from wmr_ctrl.simulation.physics.film import moments_of
    from wmr_ctrl.world.scenario import loads_scenario

    check_film(path, run.settings.plant_kind)
    loop = runnable(loads_scenario(str(run.provenance["scenario_toml"])), run.law, "mujoco")
    moments = moments_of(loop, run, MOST_MOMENTS[Path(path).suffix.lower()])
    course = course_behind(run)
    tube = None if course is None else course[0, moments.rows]
    write_moments(run, replace(moments, tube=tube), path, progress)
