"""The Simulink kit of a law: a level-2 C S-function on its C package, a script, a page.

The S-function adds nothing to the law: it copies ports into the package's structs, calls the step
and copies the torques out.  What Simulink's own header gives it is a few macros; the tests run it
against a header of ours that mimics those.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jinja2

from wmr_ctrl.codegen.package import c_name, package_files, packaged
from wmr_ctrl.control.setup import beyond_noise, settle
from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.model.plant import plant
from wmr_ctrl.results import write_all
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import REFERENCE

_TEMPLATES = Path(__file__).parent
_SOURCES = ("wmr_{law}.h", "wmr_{law}.c", "arithmetic.h")
"""Files of the package that the S-function is compiled with."""


def export_simulink(*, law: str = "nn", scenario: Scenario, out: str | Path = ".") -> list[Path]:
    """Write the kit of ``law`` into the folder ``out``, all files or none; returns their paths.

    Raises what `kit_files` raises, OSError if the folder cannot be made, ResultFileError for a
    file.
    """
    return write_all(kit_files(law, scenario), Path(out))


def kit_files(law: str, scenario: Scenario) -> dict[str, str]:
    """File name to text: S-function, its sources, the script, the page.

    Raises ArgumentError for effects that a loop of reference, law and plant would miss, and
    ScenarioError or UnknownNameError as building the law does.
    """
    setup = settle(scenario, law)
    missed = [item.title for item in beyond_noise(setup)]
    if missed:
        raise ArgumentError(
            f"the Simulink kit holds reference, law and plant, and the scenario {scenario.name} "
            f"has more: {', '.join(missed)}. Export the closed-loop FMU, which has all, or take "
            "that out of the scenario."
        )
    sources = package_files(law, scenario)
    context = _context(law, scenario)
    engine = jinja2.Environment(
        loader=jinja2.FileSystemLoader(_TEMPLATES), trim_blocks=True, lstrip_blocks=True,
        keep_trailing_newline=True, undefined=jinja2.StrictUndefined,
    )  # fmt: skip
    named = {f"sfun_wmr_{law}.c": "sfun.c.j2", "wmr_loop.m": "wmr_loop.m.j2",
             "README.md": "README.md.j2"}  # fmt: skip
    files = {name: engine.get_template(source).render(context) for name, source in named.items()}
    return files | {name: sources[name] for name in (item.format(law=law) for item in _SOURCES)}


def _context(law: str, scenario: Scenario) -> Mapping[str, Any]:
    system, robot = packaged(settle(scenario, law)), plant(scenario)
    outputs = [item.signal for item in robot.outputs]
    return {
        "law": law,
        "title": system.title,
        "scenario": scenario.name,
        "period": repr(scenario.clock.control),
        "duration": repr(scenario.clock.duration),
        "inputs": [{"name": c_name(p.signal), "size": p.signal.size, "unit": p.signal.unit}
                   for p in system.inputs],
        "outputs": [{"name": c_name(o.signal), "size": o.signal.size, "unit": o.signal.unit}
                    for o in system.outputs],
        "reference": [signal.name for signal in REFERENCE],
        "robot_inputs": [port.signal.name for port in robot.inputs],
        "robot_outputs": [signal.name for signal in outputs],
    }  # fmt: skip
