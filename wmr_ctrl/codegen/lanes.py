"""Many robots at once: the loop's kernels for lanes, compiled for what the processor has."""

from __future__ import annotations

import importlib
import platform
from dataclasses import dataclass
from typing import Any

from wmr_ctrl.codegen.build import described, digest, unity
from wmr_ctrl.codegen.compiler import Toolchain, is_zig
from wmr_ctrl.codegen.dialect import LANES
from wmr_ctrl.codegen.kernels import loop_kernels, loop_systems
from wmr_ctrl.codegen.manifest import Kernels
from wmr_ctrl.codegen.source import sources
from wmr_ctrl.codegen.toolchain import build_library, find_toolchain
from wmr_ctrl.errors import CompilerError, UnknownNameError
from wmr_ctrl.scenario import Scenario

_RUNTIME = ("batch_library.c", "batch.c", "batch.h", "lanes.h", "noise.c", "noise.h")


@dataclass(frozen=True)
class Vectors:
    """A set of vector instructions: how many doubles it takes, and the target's name."""

    lanes: int
    target: str | None
    feature: str | None


VECTORS = {
    "avx512": Vectors(8, "x86-64-v4", "AVX512_SKX"),
    "avx2": Vectors(4, "x86-64-v3", "AVX2"),
    "baseline": Vectors(2, None, None),
}
"""Best first; ``baseline`` runs on every processor of the platform's kind."""


def available() -> tuple[str, ...]:
    """The sets that this machine's processor has, best first."""
    has = _features()
    x86 = platform.machine().lower() in ("x86_64", "amd64")
    return tuple(
        name
        for name, item in VECTORS.items()
        if item.feature is None or (x86 and has.get(item.feature, False))
    )


def build_batch(scenario: Scenario, law: str, vectors: str | None = None) -> Kernels:
    """Compile the closed loop of ``law`` for lanes, or find it in the cache.

    ``vectors`` is one of `available`; without it the best that the compiler can do is taken.  The
    manifest is that of `build_loop`.  Raises CompilerError, UnknownNameError.
    """
    if vectors is not None and vectors not in available():
        raise UnknownNameError("set of vector instructions", vectors, available())
    systems = loop_systems(scenario, law)
    generated = sources(systems.by_role(), loop_kernels(systems), LANES)
    files = unity(generated, _RUNTIME)
    library = _first_built(files, available() if vectors is None else (vectors,))
    return Kernels(library, described(scenario, law, systems), digest(generated))


def toolchain_for(vectors: Vectors) -> Toolchain:
    """This machine's compiler with the flags for a set of vector instructions."""
    found = find_toolchain()
    flags = [f"-DWMR_LANES={vectors.lanes}"]
    if vectors.target and is_zig(found.command):
        flags.append(f"-mcpu={vectors.target.replace('-', '_')}")
    elif vectors.target:
        flags.append(f"-march={vectors.target}")
    return found.with_flags(*flags)


def _first_built(files: dict[str, str | bytes], sets: tuple[str, ...]) -> str:
    last: CompilerError | None = None
    for name in sets:
        try:
            return str(build_library(files, toolchain_for(VECTORS[name]), name="batch"))
        except CompilerError as error:
            last = error
    raise last or CompilerError("there is no set of vector instructions to compile for.")


def _features() -> dict[str, Any]:
    """What NumPy found out about the processor; nothing where it does not tell."""
    for name in ("numpy._core._multiarray_umath", "numpy.core._multiarray_umath"):
        try:
            return dict(importlib.import_module(name).__cpu_features__)
        except (ImportError, AttributeError):
            continue
    return {}
