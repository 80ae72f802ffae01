"""Extra files of an FMU: scenario, graph, reference result, and a law in plain C.

The plain C is for production code that uses the law without FMI's calls, such as a block that wraps
a C function.  It is the package that `wmr-ctrl codegen` writes, and ``interface.xml`` with sources,
header, structs, the expressions of its functions and the place of each of the FMU's variables in
the structs.
"""

import tempfile
from collections.abc import Mapping
from contextlib import chdir
from pathlib import Path

from wmr_ctrl.codegen.package import FILTER, c_name, package_files
from wmr_ctrl.control.controller import controller
from wmr_ctrl.control.filter import filter_system
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.control.setup import settle

from .files import render
from .model_description import FmuModel, Role

EXTRA = "extra/org.wmr-ctrl"
GRAPH = f"{EXTRA}/evaluate.casadi"
"""The function of a single block, for `casadi.Function.load`."""
RESULT = f"{EXTRA}/reference.csv"
"""The reference result."""
STARTS = f"{EXTRA}/reference.ssv"
"""Start values of inputs that it was made with, as an SSP parameter set."""
REFERENCES = "extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml"
"""Manifest of the files, by the layered standard FMI-LS-REF."""
SECONDS = 2.0
TORQUES = {"tau_right": 5.0, "tau_left": 4.5}
"""Constant torques [N m] that the plant's reference result is driven with."""
FOLDER = f"{EXTRA}/code"
INTERFACE = f"{FOLDER}/interface.xml"
NOTE = f". Plain C of one sample, and how to call it: {INTERFACE}"
"""Sentence on the C package in the model description, after the title."""


def plain_code(model: FmuModel) -> dict[str, str]:
    """The package of a law or the filter, with the FMU's ports, and its interface."""
    if model.what not in (*LAWS, FILTER):
        return {}
    law, scenario = model.what, model.scenario
    package = package_files(law, scenario, counting=False)
    system = filter_system(scenario) if law == FILTER else controller(settle(scenario, law))
    files = {f"{FOLDER}/{name}": text for name, text in package.items()}
    return files | {INTERFACE: render("interface.xml", model=model, system=system, c_name=c_name)}


def references(model: FmuModel, tool: str) -> dict[str, str]:
    """The manifest of FMI-LS-REF, and its files besides result, scenario and graph."""
    starts = _starts_of(model)
    shown = {"model": model, "seconds": _seconds(model), "starts": starts}
    files = {REFERENCES: render("fmi-ls-manifest.xml", **shown)}
    if starts:
        values = [{"name": key, "value": value} for key, value in starts.items()]
        files[STARTS] = render("parameters.ssv", name="reference", tool=tool, values=values)
    return files


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
