"""What an FMU carries to show where it comes from: scenario, graph and a reference result."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from wmr_ctrl.fmi.model import FmuModel
from wmr_ctrl.fmi.package import write_archive
from wmr_ctrl.fmi.templates import render
from wmr_ctrl.fmi.variables import Role

EXTRA = "extra/org.wmr-ctrl"
GRAPH = f"{EXTRA}/evaluate.casadi"
"""The serialised function of a single block."""
RESULT = f"{EXTRA}/reference.csv"
"""The reference result."""
STARTS = f"{EXTRA}/reference.ssv"
"""Start values of inputs that it was made with, as an SSP parameter set."""
REFERENCES = "extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml"
"""What the files are there for, as the layered standard FMI-LS-REF says it."""
SECONDS = 2.0
TORQUES = {"tau_right": 5.0, "tau_left": 4.5}
"""Constant torques [N m] that the plant's reference result is driven with."""


def starts_of(model: FmuModel) -> dict[str, float]:
    """Start values of inputs that the reference result is made with."""
    return TORQUES if model.what == "plant" else {}


def references(model: FmuModel, tool: str) -> dict[str, str]:
    """The manifest of FMI-LS-REF, and what it speaks of besides result, scenario and graph."""
    folder, starts = "../org.wmr-ctrl", starts_of(model)
    text = (
        f"{_seconds(model):g} s of co-simulation from 0 s in steps of {model.step:g} s, all "
        f"parameters at their start values{', inputs as in reference.ssv' if starts else ''}"
    )
    related = [
        {"source": f"{folder}/reference.csv", "role": "result", "type": "text/csv", "text": text},
        {"source": f"{folder}/scenario.toml", "role": "configuration", "type": "application/toml",
         "text": "the scenario that this FMU was exported from"},
    ]  # fmt: skip
    if starts:
        kind = "application/x-ssp-parameter-set"
        text = "start values of inputs of the reference result"
        related.append(
            {"source": f"{folder}/reference.ssv", "role": "parameter", "type": kind, "text": text}
        )
    if model.graph:
        text = "serialised CasADi function: next state or rates, outputs, diagnostics"
        related.append(
            {"source": f"{folder}/evaluate.casadi", "role": "model", "type": "text/plain",
             "text": text}
        )  # fmt: skip
    files = {REFERENCES: render("fmi-ls-manifest.xml", related=related)}
    if starts:
        listed = [
            {"name": name, "value": repr(value), "unit": ""} for name, value in starts.items()
        ]
        values = {"name": "reference", "tool": tool, "units": [], "parameters": listed}
        files[STARTS] = render("parameters.ssv", m=values)
    return files


def _seconds(model: FmuModel) -> float:
    return min(SECONDS, model.scenario.clock.duration)


def reference_result(model: FmuModel, files: Mapping[str, bytes]) -> bytes:
    """CSV of two seconds of co-simulation with constant inputs: time, inputs and outputs."""
    from fmpy import simulate_fmu

    names = [v.name for v in model.variables if (v.output or v.role is Role.INPUT) and not v.array]
    with tempfile.TemporaryDirectory() as folder:
        path = write_archive(Path(folder) / "model.fmu", files)
        result = simulate_fmu(
            str(path),
            stop_time=_seconds(model),
            output_interval=model.step,
            step_size=model.step,
            start_values=starts_of(model),
            output=names,
            fmi_type="CoSimulation",
            debug_logging=False,
        )
    return _csv(result)


def _csv(result: np.ndarray) -> bytes:
    text = io.StringIO()
    text.write(",".join(f'"{name}"' for name in result.dtype.names or ()) + "\n")
    for row in result:
        text.write(",".join(repr(float(number)) for number in row) + "\n")
    return text.getvalue().encode()
