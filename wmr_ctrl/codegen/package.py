"""A law as a self-contained C99 package: header, source, example, test vectors, build file."""

import json
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import casadi as ca
import jinja2

from wmr_ctrl.control.controller import controller, refusing_controller
from wmr_ctrl.control.filter.channels import ELAPSED, FLAGS
from wmr_ctrl.control.filter.filter import called_filter, derived_numbers
from wmr_ctrl.control.filter.rounding_ranges import check_single_precision
from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.core.errors import printable
from wmr_ctrl.core.signals import (
    COMMAND,
    GUARD_ACTED,
    GUARD_DIAGNOSTICS,
    LARGEST,
    ODOMETRY_AGE,
    REFUSED,
    Signal,
    places,
)
from wmr_ctrl.world.encoder import ENCODER, MOVED, Encoder, reader
from wmr_ctrl.world.model.system import Output, Port, System, stack
from wmr_ctrl.world.references import Circle
from wmr_ctrl.world.scenario import Scenario, scenario_hash
from wmr_ctrl.world.speed_loop_first_order import FirstOrderGains

from . import single_precision
from .dialect import HEADER
from .emit import QUALIFIERS, Kernel, split
from .kernels import controller_kernel
from .layouts import arranged
from .resources import c_texts
from .source import cached_definition
from .vectors import SAMPLES, TOLERANCES, vectors_of

FILES = ("wmr_{law}.h", "wmr_{law}.c", "example.c", "vectors.h", "check.c", "CMakeLists.txt",
         "README.md")  # fmt: skip
FILTER, CORRIDOR = "filter", "corridor"
"""The command filter and the corridor's monitor, which are packaged as laws are."""
_CALL = re.compile(r"\b(?!wmr_)([a-z][a-z0-9]*)\(")
_ROOT = re.compile(r"\bwmr_(sqrt|hypot|asin|acos)\(")
_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
TEMPLATES = Path(__file__).parent / "templates"
"""Folder of the texts of packages."""
WORTH_KEEPING = 50
"""Cost (see `Graph.cost`) from which on a filter keeps what hangs on its parameters alone."""
HIDDEN = (MOVED, REFUSED)
"""Inputs of a kernel that the C around it makes."""
RECORD = TEMPLATES / "footprint.json"
"""Measured footprints of packages."""


@dataclass(frozen=True)
class Field:
    """One member of a struct: C name, number of elements, unit, meaning, values."""

    name: str
    size: int
    unit: str
    meaning: str
    values: tuple[float, ...]

    @property
    def declared(self) -> str:
        """C declaration of the member."""
        return self.name if self.size == 1 else f"{self.name}[{self.size}]"

    @property
    def elements(self) -> list[tuple[str, float]]:
        """Each element's C expression and value."""
        if self.size == 1:
            return [(self.name, self.values[0])]
        return [(f"{self.name}[{k}]", value) for k, value in enumerate(self.values)]


def package_files(
    law: str,
    scenario: Scenario,
    *,
    float32: bool = False,
    counting: bool = True,
    layout: str | None = None,
) -> dict[str, str]:
    """File name to text of the package of ``law`` with the numbers of ``scenario`` as defaults.

    The law "filter" is the command filter of a scenario that has one; the package of a law for a
    base that takes velocities contains that filter.  ``counting``: if the scenario has encoders,
    the inputs are counts instead of velocities.  ``layout``: one of LAYOUTS, None for a folder
    without tool.

    Raises ScenarioError or UnknownNameError as building the law does, ArgumentError for encoders
    whose velocity needs more than counts.
    """
    setup = None if law == FILTER else settle(scenario, law)
    filters = scenario.filter.kind != "none" and (setup is None or setup.takes_velocity)
    if float32 and filters and scenario.filter.kind == "governor":
        check_single_precision(scenario)
    system = called_filter(scenario) if setup is None else packaged(setup, counting=counting)
    if float32 and (scenario.guard.enabled or filters):
        system = single_precision.with_margin(system, _margin(scenario, filters))
    return files_of(law, system, scenario, float32=float32, layout=layout)


def files_of(
    law: str,
    system: System,
    scenario: Scenario,
    *,
    float32: bool = False,
    layout: str | None = None,
) -> dict[str, str]:
    """Files of a package for a System called ``law``: a law, the filter or a monitor."""
    governs = scenario.filter.kind == "governor" and FLAGS in _signals(system.outputs)
    step = replace(step_kernel(system), whole=governs)
    context = {**_context(law, scenario, system, step, float32), "layout": layout}
    engine = text_engine(TEMPLATES)
    names = {name.format(law=law): name.format(law="law") for name in FILES}
    if law in (FILTER, CORRIDOR):
        names |= {name: f"{law}_{name}" for name in ("example.c", "README.md")}
    files = {
        name: engine.get_template(f"{source}.j2").render(context) for name, source in names.items()
    }
    files |= {} if float32 else c_texts(HEADER)
    return files if layout is None else arranged(files, layout, engine, context)


def packaged(setup: Setup, *, counting: bool = True) -> System:
    """The controller; its last output says whether a guard or filter acted.

    With encoders its inputs are counts, not velocities: the last input is the change of the
    counters, which the surrounding C code computes.
    """
    core = refusing_controller(setup) if setup.takes_velocity else controller(setup)
    if setup.scenario.guard.enabled and not setup.takes_velocity:
        (active,) = (i.expr for i in core.diagnostics if i.signal == GUARD_DIAGNOSTICS[0])
        acted = Output(GUARD_ACTED, ca.logic_or(active[0], active[1]))
        core = replace(core, outputs=(*core.outputs, acted))
    if ENCODER not in setup.effects or not counting:
        return core
    front = reader(setup.scenario)
    known = {item.signal.name: item for item in core.params}
    shared = stack(known.get(item.signal.name, item).sym for item in front.params)
    y, update = ca.substitute([front.y, front.update], [front.p], [shared])
    made = {item.signal: y[i] for i, item in enumerate(front.outputs)}
    old = stack(item.sym for item in core.inputs if item.signal in made)
    new = stack(made[item.signal] for item in core.inputs if item.signal in made)
    exprs = ca.substitute([core.update, *(item.expr for item in core.outputs)], [old], [new])
    signals = (item.signal for item in core.outputs)
    return replace(
        core,
        inputs=(*(i for i in core.inputs if i.signal not in made), *front.inputs),
        state=(*core.state, *front.state),
        params=(*core.params, *(i for i in front.params if i.signal.name not in known)),
        update=ca.vertcat(exprs[0], update),
        outputs=tuple(map(Output, signals, exprs[1:])),
        diagnostics=(),
    )


def step_kernel(system: System) -> Kernel:
    """The package's one kernel: a sample of the law."""
    return controller_kernel(system, "step")


def prepared_from(step: Kernel) -> tuple[tuple[int, ...], int]:
    """Indices of the parameters from which slow values are computed, and the number of these
    values.

    Both are empty if recomputing costs no more than checking for changes.
    """
    before, _ = split(step.graph, whole=step.whole)
    if sum(before.cost(number) for number in range(len(before.nodes))) < WORTH_KEEPING:
        return (), 0
    places = {node.place[1] for node in before.nodes if node.op == ca.OP_INPUT and node.place}
    return tuple(sorted(places)), len(before.stores)


def _context(
    law: str, scenario: Scenario, system: System, step: Kernel, float32: bool
) -> Mapping[str, Any]:
    shown, given = _signals(system.outputs), _signals(system.inputs)
    sends, guarded, filters = COMMAND[0] in shown, GUARD_ACTED in shown, FLAGS in shown
    periods = () if sends else single_precision.PERIODS.get((law, guarded), ())
    at = {name: place.start for name, place in places(given).items()}
    inputs = sum(signal.size for signal in given if signal not in HIDDEN)
    later = [at[s.name] for s in (ODOMETRY_AGE, ELAPSED) if sends and s in given]
    half = 2 ** (scenario.section(Encoder).bits - 1)
    made_of, prepared = prepared_from(step) if law == FILTER else ((), 0)
    tabled = filters and scenario.filter.kind == "band"
    shared = shared_context(law, scenario, system, replace(step, prepared=prepared > 0), float32)
    circle = scenario.reference if isinstance(scenario.reference, Circle) else Circle()
    return {
        **shared, "step": step, "sends": sends, "guarded": guarded, "tabled": tabled,
        "most_angle": shared["number"](math.pi if float32 else LARGEST),
        "inputs": fields_of(item for item in system.inputs if item.signal not in HIDDEN),
        "state": fields_of(system.state),
        "counts": {"inputs": inputs,
                   "memory": max(system.x.numel() + tabled + len(made_of) + prepared, 1)},
        "vectors": vectors_of(system, scenario.limits, float32=float32, half=half),
        "samples": SAMPLES, "tolerance": TOLERANCES[float32],
        "margin": _margin(scenario, filters), "timed": ELAPSED in given,
        "checked": min([inputs, *later]),
        "endless": [i for i, p in enumerate(system.p0) if math.isinf(p)],
        "periods": [f"{1e3 * period:g} ms" for period in periods],
        "footprint": known_footprint(law, float32, guarded, step.operations),
        "nearest": nearest_footprint(law, float32, guarded, step.operations),
        "circle": circle, "tau": scenario.section(FirstOrderGains).tau,
        "made_of": made_of, "prepared": prepared,
        "form": "slew" if scenario.filter.slew is not None else scenario.filter.kind,
        "derived": [*map(c_name_of, derived_numbers(scenario))] if filters else [],
        "encoders": MOVED in given, "half": half, "at": at,
    }  # fmt: skip


def shared_context(
    law: str, scenario: Scenario, system: System, step: Kernel, float32: bool
) -> dict[str, Any]:
    """Variables of every package's templates."""
    dialect = single_precision.package_dialect(float32)
    text = cached_definition(step, dialect)
    return {
        "law": law, "library": f"wmr_{law}", "scenario": scenario, "system": system, "step": step,
        "scenario_hash": scenario_hash(scenario),
        "float32": float32, "real": "float" if float32 else "double", "number": dialect.number,
        "largest": single_precision.LARGEST_SINGLE if float32 else LARGEST,
        "parameters": fields_of(system.params), "outputs": signals_of(system.outputs),
        "qualifiers": QUALIFIERS, "flags": flags_refused(), "kernel": text,
        "calls": library_calls(text, float32),
    }  # fmt: skip


def flags_refused() -> str:
    """The lines of arithmetic.h on compiler flags, for packages without that file."""
    text = c_texts(HEADER)[HEADER]
    return text[text.index("/* Flags") :].partition("\n\n")[0]


def _signals(items: Iterable[Port | Output]) -> list[Signal]:
    return [item.signal for item in items]


def _margin(scenario: Scenario, filters: bool) -> float:
    """Share of the limits that a single-precision package subtracts as a margin."""
    banded = filters and scenario.filter.kind == "band"
    return single_precision.BAND_MARGIN if banded else single_precision.MARGIN


def library_calls(kernel: str, float32: bool) -> list[str]:
    """Functions of the C library that a kernel's text calls, sorted."""
    text = _COMMENT.sub("", kernel)
    if float32:
        return sorted(set(_CALL.findall(text)) - {"if", "for", "while", "sizeof"})
    return ["sqrt"] if _ROOT.search(text) else []


def fields_of(ports: Iterable[Port]) -> list[Field]:
    """Struct members for numbers with values."""
    named = ((p.signal, p.value) for p in ports)
    return [Field(c_name(s), s.size, s.unit, s.meaning, values) for s, values in named]


def signals_of(outputs: Iterable[Output]) -> list[Field]:
    """Struct members for results."""
    named = (item.signal for item in outputs)
    return [Field(c_name(s), s.size, s.unit, s.meaning, ()) for s in named]


def c_name(signal: Signal) -> str:
    """The name of a signal as C can write it: ``gains.nn.eta`` as gains_nn_eta."""
    return c_name_of(signal.name)


def c_name_of(name: str) -> str:
    """A dotted name as C can write it."""
    return re.sub(r"\W+", "_", name).strip("_")


@dataclass(frozen=True)
class Footprint:
    """Memory [bytes] and instructions per sample of a package on a Cortex-M4F.

    Bytes of code with constants, of writable data, and of stack: ``stack`` is the sum of the frames
    of the package's own functions, without libm's, as the GNU Arm compiler reports it; ``deepest``
    is the stack used in ten seconds of closed loop on an emulated board, with libm and caller.
    ``instructions`` is the median there, ``most_instructions`` the slowest sample. None: not
    measured.
    """

    operations: int
    code: int
    data: int
    stack: int
    deepest: int | None
    instructions: int | None
    most_instructions: int | None
    compiler: str


def known_footprint(law: str, float32: bool, guarded: bool, operations: int) -> Footprint | None:
    """The recorded footprint of a law's package; None if it was not measured.

    A record is valid only for the kernel that it was made with, recognised by its number of
    operations.  A scenario may need another kernel.
    """
    nearest = nearest_footprint(law, float32, guarded, operations)
    return nearest if nearest and nearest.operations == operations else None


def nearest_footprint(law: str, float32: bool, guarded: bool, operations: int) -> Footprint | None:
    """Footprint of the measured package whose number of operations is nearest."""
    recorded = json.loads(RECORD.read_text(encoding="utf-8")) if RECORD.is_file() else {}
    listed = (Footprint(**item) for item in recorded.get(footprint_key(law, float32, guarded), ()))
    return min(listed, key=lambda item: abs(item.operations - operations), default=None)


def footprint_key(law: str, float32: bool, guarded: bool = False) -> str:
    """Name under which a package's footprints are recorded, one for each form of its kernel."""
    return f"{law}-{'float32' if float32 else 'double'}{'-guard' if guarded else ''}"


@cache
def text_engine(folder: Path, *, markup: bool = False, blocks: bool = True) -> jinja2.Environment:
    """The templates of a folder: C, Modelica, MATLAB, Markdown, or with ``markup`` XML and HTML.

    Its filter ``comment`` is for every text that a user supplies; ``blocks`` leave no lines of
    their own.
    """
    engine = jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder), undefined=jinja2.StrictUndefined,
        autoescape=markup, trim_blocks=blocks, lstrip_blocks=blocks, keep_trailing_newline=True,
    )  # fmt: skip
    engine.filters["comment"] = comment
    return engine


def comment(text: str) -> str:
    """A text that is safe in a comment of C and in Markdown: it neither ends nor begins one."""
    return printable(text).replace("*/", "* /").replace("/*", "/ *").replace("`", "'")
