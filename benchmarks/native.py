"""Compile the benchmarks' C by the project's own toolchain and cache.

The floor is plain ``-O3``: no flag that gives up ``errno``, no instruction beyond the platform's
baseline, no fast-math, no vector mathematics library.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from wmr_ctrl.codegen.compiler import Toolchain, is_zig
from wmr_ctrl.codegen.package import package_files
from wmr_ctrl.codegen.toolchain import build_library, find_toolchain
from wmr_ctrl.world.scenario import Scenario

HERE = Path(__file__).resolve().parent
"""Folder of the benchmarks, which also holds their C."""

FLOOR_FLAGS = ("-std=c99", "-O3", "-ffp-contract=off", "-shared")


def floor_toolchain(extra: Sequence[str] = ()) -> Toolchain:
    """Return this machine's compiler with the floor's flags, then ``extra``."""
    found = find_toolchain()
    flags: tuple[str, ...] = FLOOR_FLAGS if os.name == "nt" else (*FLOOR_FLAGS, "-fPIC")
    if is_zig(found.command):  # undo its own defaults: this very processor, traps on overflow
        flags = (*flags, "-mcpu=baseline", "-fno-sanitize=undefined")
    return replace(found, flags=(*flags, *extra))


def load(files: Sequence[Path], name: str, extra: Sequence[str] = ()) -> ctypes.CDLL:
    """Compile ``files`` (C sources and headers of one folder) unless cached, and load the library.

    Raises CompilerError if there is no compiler or it refuses the source.
    """
    return _load({file.name: file.read_bytes() for file in files}, name, extra)


def load_filter(scenario: Scenario, own: str, *, float32: bool = False) -> ctypes.CDLL:
    """Compile the filter's package of a scenario with this folder's file ``own``.c, and load it.

    Raises as `load` does.
    """
    package = package_files("filter", scenario, float32=float32)
    wanted = ("wmr_filter.h", "wmr_filter.c", "arithmetic.h")
    sources = {name: package[name].encode() for name in wanted if name in package}
    return _load({**sources, f"{own}.c": (HERE / f"{own}.c").read_bytes()}, own)


def _load(sources: Mapping[str, bytes], name: str, extra: Sequence[str] = ()) -> ctypes.CDLL:
    return ctypes.CDLL(str(build_library(sources, floor_toolchain(extra), name=name)))
