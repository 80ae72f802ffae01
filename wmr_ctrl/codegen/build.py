"""From a scenario and a law to a compiled closed loop."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

from wmr_ctrl.codegen.dialect import HEADER
from wmr_ctrl.codegen.kernels import LoopSystems, loop_kernels, loop_systems, plant_phases
from wmr_ctrl.codegen.manifest import Kernels, manifest
from wmr_ctrl.codegen.resources import runtime_dir
from wmr_ctrl.codegen.source import sources
from wmr_ctrl.codegen.toolchain import build_library, find_toolchain
from wmr_ctrl.errors import CompilerError
from wmr_ctrl.laws.sample import own_diagnostics
from wmr_ctrl.scenario import Scenario

RUNTIME = (
    "library.c", "loop.c", "loop.h", "noise.c", "noise.h", HEADER, "export.h",
)  # fmt: skip


def build_loop(scenario: Scenario, law: str) -> Kernels:
    """Compile the closed loop of ``law`` on ``scenario``, or find it in the cache.

    Numbers are parameters, so that scenarios of one structure share a library.  Raises
    CompilerError without a working compiler.
    """
    systems = loop_systems(scenario, law)
    generated = sources(systems.by_role(), loop_kernels(systems))
    library = _built(unity(generated))
    return Kernels(str(library), described(scenario, law, systems), digest(generated))


def described(scenario: Scenario, law: str, systems: LoopSystems) -> dict[str, Any]:
    """The manifest of a loop."""
    own = own_diagnostics(systems.controller)
    phases = plant_phases(scenario, systems.plant)
    return manifest(law, systems.controller.title, systems.by_role(), own, phases)


def _built(files: dict[str, str | bytes]) -> Path:
    """A library for this very processor; for any of its kind if the compiler cannot do that."""
    try:
        return build_library(files, find_toolchain(native=not find_toolchain().misaligns_vectors))
    except CompilerError:
        return build_library(files)


def unity(generated: dict[str, str], files: tuple[str, ...] = RUNTIME) -> dict[str, str | bytes]:
    """Generated and hand-written sources; the first of ``files`` is the only unit to compile."""
    runtime = {name: (runtime_dir() / name).read_text(encoding="utf-8") for name in files}
    included = {_as_header(name): text for name, text in {**runtime, **generated}.items()}
    unit = included.pop(_as_header(files[0])).replace('.c"', '.inc"')
    return {**included, files[0]: unit}


def digest(generated: dict[str, str]) -> str:
    """Hash of the generated sources: which graphs a run was made from."""
    text = json.dumps(generated, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _as_header(name: str) -> str:
    return str(Path(name).with_suffix(".inc")) if name.endswith(".c") else name
