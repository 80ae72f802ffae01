"""What an FMU carries to show where it comes from: scenario, graph and a reference result."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from wmr_ctrl.fmi.model import FmuModel
from wmr_ctrl.fmi.package import write_archive
from wmr_ctrl.fmi.variables import Role

EXTRA = "extra/org.wmr-ctrl"
GRAPH = f"{EXTRA}/evaluate.casadi"
"""The serialised function of a single block."""
SECONDS = 2.0
TORQUES = {"tau_right": 5.0, "tau_left": 4.5}
"""Constant torques [N m] that the plant's reference result is driven with."""


def reference_result(model: FmuModel, files: Mapping[str, bytes]) -> bytes:
    """CSV of two seconds of co-simulation with constant inputs: time, inputs and outputs."""
    from fmpy import simulate_fmu

    names = [v.name for v in model.variables if (v.output or v.role is Role.INPUT) and not v.array]
    with tempfile.TemporaryDirectory() as folder:
        path = write_archive(Path(folder) / "model.fmu", files)
        result = simulate_fmu(
            str(path),
            stop_time=min(SECONDS, model.scenario.clock.duration),
            output_interval=model.step,
            step_size=model.step,
            start_values=TORQUES if model.what == "plant" else {},
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
