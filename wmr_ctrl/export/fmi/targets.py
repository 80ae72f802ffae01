"""Platforms that FMUs are built for, and the compilers that build for them."""

import os
import platform
import shlex
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass, replace
from importlib import metadata
from pathlib import Path

from wmr_ctrl.codegen.cache import build_cached
from wmr_ctrl.codegen.compiler import Toolchain, compile_library, compile_object, default_flags
from wmr_ctrl.codegen.dialect import HEADER
from wmr_ctrl.codegen.toolchain import find_toolchain, level_flags, zig_command
from wmr_ctrl.core.errors import CompilerError, UnknownNameError, install

from .files import Sources

VARIABLE = "WMR_CTRL_FMU_CC"
"""Environment variable that names the C compiler of FMUs for this machine."""
_MACHINES = {"amd64": "x86_64", "arm64": "aarch64"}
HEAVY = {
    "kernels.c": ("kernels.c", "kernels.h", HEADER),
    "jacobian.c": ("jacobian.c", "jacobian.h", HEADER),
}
"""Units that take long to compile, with all that they read: models share them across scenarios."""
LIGHT = "light.c"
"""File that joins all other units, which takes a third of the time; the FMU itself has them
separately."""


@dataclass(frozen=True)
class Target:
    """A platform: its name in FMI 2 and FMI 3, zig's triple, and the suffix of its libraries."""

    name: str
    fmi2: str
    triple: str
    suffix: str


TARGETS = (
    Target("x86_64-linux", "linux64", "x86_64-linux-gnu.2.17", ".so"),
    Target("x86_64-windows", "win64", "x86_64-windows-gnu", ".dll"),
    Target("aarch64-linux", "aarch64-linux", "aarch64-linux-gnu.2.17", ".so"),
    Target("x86_64-darwin", "darwin64", "x86_64-macos", ".dylib"),
    Target("aarch64-darwin", "aarch64-darwin", "aarch64-macos", ".dylib"),
)
"""Linux binaries need glibc 2.17 or later."""


def host() -> str:
    """Name of this machine's platform in FMI 3."""
    machine = platform.machine().lower()
    system = {"win32": "windows", "darwin": "darwin"}.get(sys.platform, "linux")
    return f"{_MACHINES.get(machine, machine)}-{system}"


def targets_of(name: str) -> tuple[Target, ...]:
    """The platforms named by ``host``, ``all`` or a platform's name."""
    if name == "all":
        return TARGETS
    wanted = host() if name == "host" else name
    chosen = tuple(target for target in TARGETS if target.name == wanted)
    if not chosen:
        raise UnknownNameError("target", wanted, ("host", "all", *(t.name for t in TARGETS)))
    return chosen


def build_for(targets: Sequence[Target], sources: Sources, identifier: str) -> dict[str, bytes]:
    """Libraries by platform, built several at a time.

    Raises CompilerError if one cannot be built, when all others are in the cache.
    """
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as workers:
        jobs = {t.name: workers.submit(compile_for, t, sources, identifier) for t in targets}
        try:
            wait(jobs.values())
        except BaseException:  # Ctrl-C: what has not begun need not
            workers.shutdown(cancel_futures=True)
            raise
    return {name: job.result().read_bytes() for name, job in jobs.items()}


def compile_for(target: Target, sources: Sources, identifier: str) -> Path:
    """The library for ``target``, from the cache if it was built before.

    Raises CompilerError if no compiler builds for that platform.
    """
    chain = toolchain_for(target)
    objects = [_object(chain, sources, unit) for unit in HEAVY if unit in sources.files]
    light = "".join(f'#include "{name}"\n' for name in sources.units if name not in HEAVY)

    def compile_in(folder: Path) -> Path:
        (folder / LIGHT).write_text(light, encoding="utf-8")
        library = folder / f"{identifier}{target.suffix}"
        return compile_library(chain, [folder / LIGHT, *objects], library, include=[folder])

    parts = (o.parent.name for o in objects)
    return build_cached(sources.files, compile_in, key=(*chain.key, identifier, *parts))


def _object(chain: Toolchain, sources: Sources, unit: str) -> Path:
    files = {name: sources.files[name] for name in HEAVY[unit]}

    def compile_in(folder: Path) -> Path:
        return compile_object(chain, folder / unit, folder / f"{unit}.o", include=[folder])

    return build_cached(files, compile_in, key=(*chain.key, "object"))


def toolchain_for(target: Target) -> Toolchain:
    """zig cc, which builds for every platform on every other; else this machine's compiler.

    A command in the environment variable WMR_CTRL_FMU_CC has priority, for this machine.
    """
    named = shlex.split(os.environ.get(VARIABLE, ""))
    if named and target.name == host():
        flags = (*default_flags(named), *level_flags())
        return Toolchain(tuple(named), named[0], "named in " + VARIABLE, flags)
    if zig_command():
        return _zig(target).with_flags(*level_flags())
    if target.name != host():
        raise CompilerError(
            f"building for {target.name} needs zig: `{install('compiler')}`, or export with "
            "--target host."
        )
    return find_toolchain()


def _zig(target: Target) -> Toolchain:
    command = (*zig_command(), "cc")
    version = f"zig {metadata.version('ziglang')}"
    base = Toolchain(command, "zig cc", version, default_flags(command))
    windows = target.suffix == ".dll"
    flags = tuple(flag for flag in base.flags if not (windows and flag == "-fPIC"))
    stripped = () if target.suffix == ".dylib" else ("-s",)
    return replace(base, flags=(*flags, *stripped, "-target", target.triple))
