"""Compile a setup's closed loop for one robot, or for several robots in vector lanes.

Numbers are parameters, so setups of one structure share graphs, C text and library.  The library
for lanes contains the loop once for each set of vector instructions of its kind of processor, from
the same generated text; dispatch.c chooses one at run time.
"""

import hashlib
import json
import platform
import re
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from wmr_ctrl.control.loop import WINDOW, Graphs, LoopGraphs, PlantlessGraphs
from wmr_ctrl.control.numbers import structure_of
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.core.compiled import CompiledLoop, LawLayout, LoopLayout
from wmr_ctrl.core.errors import CompilerError
from wmr_ctrl.core.signals import PLANT_STATE, Signal, elements
from wmr_ctrl.world.model.system import values

from . import kernels
from .cache import build_cached
from .compiler import Toolchain, is_zig
from .dialect import LANES, SCALAR
from .emit import Kernel
from .resources import c_texts
from .source import sources
from .toolchain import Unit, build_library, build_units, find_toolchain

LOOP = ("library.c", "loop.c", "loop.h", "noise.c", "noise.h", "arithmetic.h", "export.h")
NATIVE = ("native.c", *LOOP)
OUTSIDE = ("outside.c", *LOOP[1:])
LAW = ("law.c", "arithmetic.h", "export.h")
GPU = ("gpu.c", "gpu_types.h", "seed.c", "seed.h", *LOOP[1:-1])
_DISPATCH = "dispatch.c"


@dataclass(frozen=True)
class Instructions:
    """A set of vector instructions: its name, how many doubles it takes, the x86-64 level."""

    name: str
    lanes: int
    target: str | None


BASELINE = Instructions("baseline", 2, None)
"""Runs on every processor of the platform's kind."""
X86 = (Instructions("avx512", 8, "x86-64-v4"), Instructions("avx2", 4, "x86-64-v3"))


def vector_sets() -> tuple[Instructions, ...]:
    """The sets of this platform's kind of processor, best first."""
    return (*(X86 if platform.machine().lower() in ("x86_64", "amd64") else ()), BASELINE)


def build_loop(setup: Setup, *, watched: bool = False) -> CompiledLoop:
    """Compile the closed loop of a setup for one robot, or find it in the cache.

    Its runs have a log; with ``watched`` it can also run without one, which takes longer to
    compile. Raises CompilerError without a working compiler.
    """
    program = program_of(setup)
    text = program.generated_watched if watched else program.generated
    return filled(program, setup, _for_this_processor(unity(text)), digest(text))


def build_law(setup: Setup) -> CompiledLoop:
    """The controller alone, for callers of single samples, with the numbers of its loop."""
    program = program_of(setup)
    law = program.loop.controller
    text = sources(kernels.sizes_of("controller", law), [kernels.controller_kernel(law)], SCALAR)
    return filled(program, setup, _for_this_processor(unity(text, LAW)), digest(text))


def build_batch(setup: Setup) -> CompiledLoop:
    """The closed loop for lanes of robots, with and without a log."""
    program = program_of(setup)
    return filled(program, setup, program.lanes, digest(program.generated_lanes))


def build_gpu(setup: Setup) -> CompiledLoop:
    """The loop's text for a graphics processor, from that of `build_batch`, in the cache.

    The machine that runs it also compiles it.  Raises CacheError if it cannot be stored.
    """
    program = program_of(setup)
    text = one_text(GPU, program.generated_lanes)
    library = build_cached({"loop.cu": text}, lambda folder: folder / "loop.cu")
    return filled(program, setup, library, digest(program.generated_lanes))


def build_plantless(setup: Setup) -> CompiledLoop:
    """The closed loop for one robot with an external plant; its columns are those of `build_loop`.

    That plant supplies the state, and path length and skid if a sensor needs them.
    """
    program = program_of(setup, external_plant=True)
    loop = program.loop
    text = sources(kernels.plantless_constants(loop), kernels.plantless_kernels(loop), SCALAR)
    library = _for_this_processor(unity(text, OUTSIDE))
    return filled(program, setup, library, digest(text))


class Program:
    """Graphs, C text and libraries of one structure, each made on first use."""

    def __init__(self, setup: Setup, structure: Hashable, *, external_plant: bool = False) -> None:
        """Compose the graphs of a setup of this structure, with or without the plant."""
        self.loop = LoopGraphs(setup, external_plant=external_plant)
        self.structure = hashlib.sha256(repr(structure).encode()).hexdigest()[:16]
        loop = self.loop
        self.layout = LoopLayout(
            loop.controller.title, loop.columns,
            tuple(item.signal for item in (*loop.fast, *loop.slow)),
            tuple(item.signal for item in loop.parameters.ports), kernels.findings_of(loop), WINDOW,
        )  # fmt: skip

    @cached_property
    def generated(self) -> dict[str, str]:
        """C text for one robot with a log."""
        return sources(kernels.loop_constants(self.loop), kernels.logged_kernels(self.loop), SCALAR)

    @cached_property
    def generated_watched(self) -> dict[str, str]:
        """C text for one robot, with the monitor's sums for runs without a log."""
        return sources(kernels.loop_constants(self.loop), kernels.loop_kernels(self.loop), SCALAR)

    @cached_property
    def generated_lanes(self) -> dict[str, str]:
        """C text for lanes."""
        return sources(kernels.loop_constants(self.loop), kernels.loop_kernels(self.loop), LANES)

    @cached_property
    def lanes(self) -> Path:
        """The library for lanes."""
        toolchain = find_toolchain()
        files = unity(self.generated_lanes, LOOP) | c_texts(_DISPATCH)
        chosen = (BASELINE,) if toolchain.misaligns_vectors else vector_sets()
        units = [
            Unit(item.name, LOOP[0], tuple(flags_of(item, toolchain)), item is not BASELINE)
            for item in chosen
        ]
        return build_units(files, units, Unit("dispatch", _DISPATCH), toolchain, name="batch")


def lanes_library(driver: str, sizes: Mapping[str, int], several: Sequence[Kernel]) -> Path:
    """A library of ``several`` kernels in lanes, with the runtime's ``driver``."""
    generated = sources(sizes, several, LANES)
    generated.pop("exports.h")
    runtime = c_texts("arithmetic.h", "export.h", "lanes.h", driver)
    texts = {name.replace(".c", ".inc"): text for name, text in generated.items()}
    return _for_this_processor({**texts, **runtime})


def _for_this_processor(files: dict[str, str | bytes]) -> Path:
    """Compile for this very processor, or for any of its kind if the compiler cannot do that."""
    try:
        return build_library(files, find_toolchain(native=not find_toolchain().misaligns_vectors))
    except CompilerError:
        return build_library(files)


_PROGRAMS: dict[Hashable, Program] = {}
_MOST_PROGRAMS = 256


def program_of(setup: Setup, *, external_plant: bool = False) -> Program:
    """The program of a setup's structure, kept for the next setup that shares it."""
    structure = structure_of(setup)
    place = structure, external_plant, setup.effects, setup.scenario.reference_kind
    if place not in _PROGRAMS:
        if len(_PROGRAMS) >= _MOST_PROGRAMS:
            _PROGRAMS.pop(next(iter(_PROGRAMS)))
        _PROGRAMS[place] = Program(setup, structure, external_plant=external_plant)
    return _PROGRAMS[place]


def filled(program: Program, setup: Setup, library: Path, hashed: str) -> CompiledLoop:
    """A CompiledLoop of the program with the numbers of a setup."""
    own = program.loop.controller
    ports = own.inputs, own.state, own.params
    inputs, state, parameters = (tuple(item.signal for item in part) for part in ports)
    numbers = tuple(values(own.state)), numbers_of(setup, parameters)
    law, texts = LawLayout(inputs, state, parameters, *numbers), (str(library), hashed)
    return _numbered((*texts, program.structure), program.layout, law, setup, program.loop)


def _numbered(
    texts: tuple[str, str, str], layout: LoopLayout, law: LawLayout, setup: Setup, loop: Graphs
) -> CompiledLoop:
    """A CompiledLoop of a library, with a setup's numbers in the layout's order.

    ``texts``: library, its hash and that of its structure.  The state at t = 0 has the scenario's
    pose and velocity, and the graphs' own values for the rest.
    """
    first, initial = numbers_of(setup, layout.parameters), setup.scenario.initial
    steps, rows = zip(*phases_of(setup, layout.parameters, first), strict=True)
    start = (*initial.pose, *initial.velocity, *loop.x0[len(PLANT_STATE) :])
    return CompiledLoop(*texts, layout, law, rows, steps, start, delay_steps_of(loop, first))


def build_outside(setup: Setup, loop: PlantlessGraphs) -> CompiledLoop:
    """Compile sensors, disturbances and drives, for an external controller and plant.

    Raises CompilerError without a working compiler.
    """
    generated = sources(kernels.outside_constants(loop), kernels.outside_kernels(loop), SCALAR)
    parameters = tuple(item.signal for item in loop.parameters.ports)
    signals = tuple(item.signal for item in (*loop.fast, *loop.slow))
    layout = LoopLayout("", (), signals, parameters, kernels.FINDINGS, ())
    texts = (str(_for_this_processor(unity(generated, OUTSIDE))), digest(generated), "")
    return _numbered(texts, layout, LawLayout((), (), (), (), ()), setup, loop)


def numbers_of(setup: Setup, parameters: tuple[Signal, ...]) -> tuple[float, ...]:
    """A setup's values of parameters, by their keys, flat and in order."""
    return tuple(number for item in parameters for number in setup.value(item.name))


def delay_steps_of(loop: Graphs, parameters: tuple[float, ...]) -> int:
    """Number of plant steps that a command is in transit, for the values of a loop's parameters."""
    return round(float(loop.delay_steps(parameters)))


def phases_of(
    setup: Setup, parameters: tuple[Signal, ...], first: tuple[float, ...]
) -> list[tuple[int, tuple[float, ...]]]:
    """(first plant step, parameter values) of each phase: the start, then every Change."""
    names = elements(parameters)
    row, phases = list(first), [(0, first)]
    for change in setup.scenario.changes:
        for key, value in change.values().items():
            if f"robot.{key}" in names:
                row[names.index(f"robot.{key}")] = value
        phases.append((first_step_at(change.t, setup.scenario.clock.plant), tuple(row)))
    return phases


def first_step_at(time: float, step: float) -> int:
    """Index of the first plant step [s] that starts at or after ``time`` [s]."""
    index = round(time / step)
    return index if abs(index * step - time) <= 1e-9 * max(1.0, time) else int(-(-time // step))


def flags_of(vectors: Instructions, toolchain: Toolchain) -> Iterator[str]:
    """Compiler flags for a set of vector instructions."""
    yield f"-DWMR_SET={vectors.name}"
    yield f"-DWMR_LANES={vectors.lanes}"
    if vectors.target and is_zig(toolchain.command):
        yield f"-mcpu={vectors.target.replace('-', '_')}"
    elif vectors.target:
        yield f"-march={vectors.target}"
    if vectors.target and toolchain.fuses_pairs:
        yield "-fno-tree-vectorize"  # lanes are vectors already, and their scalars must not fuse


def unity(generated: dict[str, str], files: tuple[str, ...] = NATIVE) -> dict[str, str | bytes]:
    """Generated and hand-written sources; only the first of ``files`` is a unit to compile."""
    every = {_as_header(name): text for name, text in (c_texts(*files) | generated).items()}
    included = {name: text.replace('.c"\n', '.inc"\n') for name, text in every.items()}
    unit = included.pop(_as_header(files[0]))
    return {**included, files[0]: unit}


def one_text(files: Sequence[str], generated: Mapping[str, str]) -> str:
    """Generated and hand-written sources joined into one text without includes."""
    left = {**c_texts(*files), **generated}

    def included(match: re.Match[str]) -> str:
        own = match[1] == '"'
        return INCLUDE.sub(included, left.pop(match[2], "")) if own else ""

    return INCLUDE.sub(included, left.pop(files[0]))


INCLUDE = re.compile(r'^#include (["<])([^">]+)[">].*\n', re.MULTILINE)


def digest(generated: dict[str, str]) -> str:
    """Hash of the generated sources, which identifies the graphs that a run was made from."""
    text = json.dumps(generated, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _as_header(name: str) -> str:
    return str(Path(name).with_suffix(".inc")) if name.endswith(".c") else name
