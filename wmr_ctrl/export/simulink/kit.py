"""The Simulink kit of a law: a level-2 C S-function on its C package, scripts, a page.

The S-function adds nothing to the law: it copies ports and the parameters of its dialog into the
package's structs, calls the step and copies the torques out. It needs a few macros of Simulink's
header; the tests compile it with a header of ours that imitates them.
"""

import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from wmr_ctrl.codegen.package import (
    Field,
    comment,
    fields_of,
    package_files,
    packaged,
    signals_of,
    text_engine,
)
from wmr_ctrl.control.given import law_of
from wmr_ctrl.control.numbers import ranges_of
from wmr_ctrl.control.outside import check_plain_loop, check_takes_torques
from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.core.signals import LARGEST, REFERENCE, elements
from wmr_ctrl.results import write_all
from wmr_ctrl.world.model.dynamics import plant
from wmr_ctrl.world.model.system import Port
from wmr_ctrl.world.scenario import Scenario

_TEMPLATES = Path(__file__).parent
_SOURCES = ("wmr_{law}.h", "wmr_{law}.c", "arithmetic.h")
"""Files of the package that the S-function is compiled with."""
_RENDERED = {
    "sfun_wmr_{law}.c": "sfun.c.j2",
    "wmr_block.m": "wmr_block.m.j2",
    "wmr_loop.m": "wmr_loop.m.j2",
    "wmr_ccaller.m": "wmr_ccaller.m.j2",
    "README.md": "README.md.j2",
}
CLOCK = "clock.control"
"""The one parameter that is fixed: the S-function's sample time."""


def export_simulink(
    *, law: str | None = None, scenario: Scenario, out: str | Path = "."
) -> list[Path]:
    """Write the kit of ``law`` into the folder ``out``, all files or none; returns their paths.

    Raises the errors of `kit_files`, and ResultFileError if it cannot be written.
    """
    return write_all(kit_files(law_of(scenario, law), scenario), Path(out))


def kit_files(law: str, scenario: Scenario) -> dict[str, str]:
    """File name to text: S-function, its sources, the scripts, the page.

    Raises ArgumentError for effects that a loop of reference, law and plant would miss, and
    ScenarioError or UnknownNameError as building the law does.
    """
    check_takes_torques(scenario, "Simulink kits are written")
    setup = settle(scenario, law)
    check_plain_loop(setup, "the Simulink kit")
    sources = package_files(law, scenario)
    engine = text_engine(_TEMPLATES)
    infinite = {math.inf: "HUGE_VAL", -math.inf: "-HUGE_VAL"}
    engine.filters["number"] = lambda value: infinite.get(value) or repr(float(value))
    engine.filters |= {"quoted": _quoted, "matlab": _matlab}
    context = _context(setup)
    files = {name: engine.get_template(t).render(context) for name, t in _RENDERED.items()}
    rendered = {name.format(law=law): text for name, text in files.items()}
    return rendered | {name: sources[name] for name in (item.format(law=law) for item in _SOURCES)}


def _context(setup: Setup) -> Mapping[str, Any]:
    system, scenario, robot = packaged(setup), setup.scenario, plant(setup.scenario)
    tuned = [port for port in system.params if port.signal.name != CLOCK]
    ranges = ranges_of(scenario, (port.signal.name for port in tuned))
    return {
        "law": setup.name,
        "system": system,
        "scenario": scenario,
        "robot": robot,
        "inputs": fields_of(system.inputs),
        "outputs": signals_of(system.outputs),
        "parameters": [_parameter(port, ranges.get(port.signal.name)) for port in tuned],
        "ordered": {"limits.v_u1", "limits.v_u2"} <= {port.signal.name for port in tuned},
        "memory": fields_of(system.state) or [Field("nothing", 1, "", "", (0,))],
        "reference": elements(REFERENCE),
    }


def _parameter(port: Port, known: tuple[float, float] | None) -> Mapping[str, Any]:
    """One parameter of the S-function: its values and their ranges."""
    signal = port.signal
    low, high = (
        math.copysign(math.inf, end) if abs(end) >= LARGEST else end
        for end in known or (-LARGEST, LARGEST)
    )
    numbers = "a number" if signal.size == 1 else f"{signal.size} numbers"
    ends = [f"at least {low:g}"] * (low > -math.inf) + [f"at most {high:g}"] * (high < math.inf)
    (field,) = fields_of([port])
    told = {"low": low, "high": high, "wanted": ", ".join([numbers, *ends])}
    return {**vars(field), "value": port.value, "dotted": signal.name, **told}


def _matlab(values: Iterable[float]) -> str:
    """Numbers in MATLAB syntax: a scalar, or a column in the order of the C struct."""
    shown = [repr(value).replace("inf", "Inf") for value in values]
    return shown[0] if len(shown) == 1 else f"[{'; '.join(shown)}]"


def _quoted(text: str) -> str:
    """A text for use in a MATLAB character vector."""
    return comment(text).replace("'", "''")
