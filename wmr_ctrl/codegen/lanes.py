"""Many robots at once: the loop's kernels for lanes, one library for all vector instructions.

The library holds the loop once for each set of vector instructions of its kind of processor, from
the same generated text; which of them runs is decided when it is used (batch_dispatch.c).
"""

from __future__ import annotations

import platform
from collections.abc import Iterator
from dataclasses import dataclass

from wmr_ctrl.codegen.build import described, digest, unity
from wmr_ctrl.codegen.compiler import Toolchain, is_zig
from wmr_ctrl.codegen.dialect import HEADER, LANES
from wmr_ctrl.codegen.kernels import loop_kernels, loop_systems
from wmr_ctrl.codegen.manifest import Kernels
from wmr_ctrl.codegen.objects import Unit, build_units
from wmr_ctrl.codegen.resources import runtime_dir
from wmr_ctrl.codegen.source import sources
from wmr_ctrl.codegen.toolchain import find_toolchain
from wmr_ctrl.scenario import Scenario

_RUNTIME = (
    "batch_library.c", "batch.c", "batch.h", HEADER, "noise.c", "noise.h", "export.h",
)  # fmt: skip
_DISPATCH = "batch_dispatch.c"


@dataclass(frozen=True)
class Vectors:
    """A set of vector instructions: its name, how many doubles it takes, the x86-64 level."""

    name: str
    lanes: int
    target: str | None


BASELINE = Vectors("baseline", 2, None)
"""Runs on every processor of the platform's kind."""
X86 = (Vectors("avx512", 8, "x86-64-v4"), Vectors("avx2", 4, "x86-64-v3"))


def vector_sets() -> tuple[Vectors, ...]:
    """The sets of this platform's kind of processor, best first."""
    return (*(X86 if platform.machine().lower() in ("x86_64", "amd64") else ()), BASELINE)


def build_batch(scenario: Scenario, law: str) -> Kernels:
    """Compile the closed loop of ``law`` for lanes, or find it in the cache.

    The manifest is that of `build_loop`.  Raises CompilerError.
    """
    systems, toolchain = loop_systems(scenario, law), find_toolchain()
    generated = sources(systems.by_role(), loop_kernels(systems), LANES)
    dispatch = (runtime_dir() / _DISPATCH).read_text(encoding="utf-8")
    files = {**unity(generated, _RUNTIME), _DISPATCH: dispatch}
    units = [
        Unit(item.name, _RUNTIME[0], tuple(flags_of(item, toolchain)), item is not BASELINE)
        for item in ((BASELINE,) if toolchain.misaligns_vectors else vector_sets())
    ]
    library = build_units(files, units, Unit("dispatch", _DISPATCH), toolchain, name="batch")
    return Kernels(str(library), described(scenario, law, systems), digest(generated))


def flags_of(vectors: Vectors, toolchain: Toolchain) -> Iterator[str]:
    """Flags that compile for a set of vector instructions."""
    yield f"-DWMR_SET={vectors.name}"
    yield f"-DWMR_LANES={vectors.lanes}"
    if vectors.target and is_zig(toolchain.command):
        yield f"-mcpu={vectors.target.replace('-', '_')}"
    elif vectors.target:
        yield f"-march={vectors.target}"
