"""The law in plain C beside the FMU's binary, and a description of how to call it.

For production code that wants the law without FMI's calls, such as a block that wraps a C function:
the package that `wmr-ctrl codegen` writes, and ``interface.xml`` with sources, header, structs, the
expressions of its functions and where each of the FMU's variables stands in the structs.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from wmr_ctrl.codegen.package import c_name, package_files
from wmr_ctrl.control.controller import controller
from wmr_ctrl.control.setup import settle
from wmr_ctrl.fmi.model import FmuModel
from wmr_ctrl.fmi.provenance import EXTRA
from wmr_ctrl.fmi.templates import render
from wmr_ctrl.laws import LAWS
from wmr_ctrl.signals import Signal

FOLDER = f"{EXTRA}/code"
INTERFACE = f"{FOLDER}/interface.xml"
NOTE = f". Plain C of one sample, and how to call it: {INTERFACE}"
"""What the model description says of it after the title."""
_STRUCTS = ("parameters", "state", "inputs", "outputs")


def plain_code(model: FmuModel) -> Iterator[tuple[str, str]]:
    """Files of a law's model: the package, whose ports are those of the FMU, and its interface."""
    if model.what not in LAWS:
        return
    law, scenario = model.what, model.scenario
    for name, text in package_files(law, scenario, counting=False).items():
        yield f"{FOLDER}/{name}", text
    system = controller(settle(scenario, law))
    shown = {
        "law": law,
        "title": model.title,
        "period": repr(scenario.clock.control),
        "structs": _STRUCTS,
        "variables": [
            *_variables("parameter", "parameters", (port.signal for port in system.params)),
            *_variables("input", "inputs", (port.signal for port in system.inputs)),
            *_variables("output", "outputs", (item.signal for item in system.outputs)),
        ],
    }
    yield INTERFACE, render("interface.xml", m=shown)


def _variables(causality: str, struct: str, signals: Iterable[Signal]) -> Iterator[dict[str, str]]:
    for signal in signals:
        for i, (name, unit) in enumerate(zip(signal.elements, signal.units, strict=True)):
            place = f"[{i}]" if signal.size > 1 else ""
            yield {
                "name": name,
                "causality": causality,
                "expression": f"{struct}.{c_name(signal)}{place}",
                "unit": unit,
                "text": signal.meaning,
            }
