"""Extra files of an FMU: scenario, graph, and reference result."""

import tempfile
from collections.abc import Mapping
from contextlib import chdir
from pathlib import Path

from .model_description import FmuModel, Role

EXTRA = "extra/org.wmr-ctrl"
GRAPH = f"{EXTRA}/evaluate.casadi"
"""The function of a single block, for `casadi.Function.load`."""
RESULT = f"{EXTRA}/reference.csv"
"""The reference result."""
SECONDS = 2.0
TORQUES = {"tau_right": 5.0, "tau_left": 4.5}
"""Constant torques [N m] that the plant's reference result is driven with."""


def _starts_of(model: FmuModel) -> dict[str, float]:
    """Start values of the inputs for the reference result."""
    return TORQUES if model.what == "plant" else {}


def _seconds(model: FmuModel) -> float:
    return min(SECONDS, model.scenario.clock.duration)


def reference_result(model: FmuModel, files: Mapping[str, bytes]) -> bytes:
    """CSV of two seconds of co-simulation with constant inputs: time, inputs and outputs.

    ``files``: the model description, and the library for this machine in all its places.
    """
    from fmpy import simulate_fmu

    names = [v.name for v in model.variables if (v.output or v.role is Role.INPUT) and not v.array]
    step = model.scenario.clock.control
    with tempfile.TemporaryDirectory() as folder:
        for name, content in files.items():
            path = Path(folder) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        with chdir("."):  # FMPy stays in another folder if it cannot load the library
            result = simulate_fmu(
                folder,
                validate=False,
                stop_time=_seconds(model),
                output_interval=step,
                step_size=step,
                start_values=_starts_of(model),
                output=names,
                fmi_type="CoSimulation",
                debug_logging=False,
            )
    lines = [",".join(f'"{name}"' for name in result.dtype.names or ())]
    lines += [",".join(repr(float(number)) for number in row) for row in result]
    return "\n".join([*lines, ""]).encode()
