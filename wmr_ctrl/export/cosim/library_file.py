"""The library of an unpacked FMU for this machine: where it is, whether it loads, or its build."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import fmpy

from wmr_ctrl.codegen.compiler import TIMEOUT, run_command
from wmr_ctrl.codegen.toolchain import find_toolchain
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.export.fmi.targets import TARGETS, host

_WITHOUT_PREFIX = ("FMI2_OVERRIDE_FUNCTION_PREFIX", "FMI3_OVERRIDE_FUNCTION_PREFIX")
"""Macros by which sources leave the model's name out of their functions' names."""


def place_of(folder: Path, version: int, model: str) -> Path:
    """Place of this machine's library in an unpacked FMU.

    In FMI 2 a processor's own folder comes before the one that FMPy takes, which may hold another
    processor's library.
    """
    name = model + fmpy.sharedLibraryExtension
    if version == 3:
        return Path("binaries", fmpy.platform_tuple, name)
    own = (Path("binaries", target.fmi2, name) for target in TARGETS if target.name == host())
    there = (place for place in own if (folder / place).is_file())
    return next(there, Path("binaries", fmpy.platform, name))


def try_to_load(folder: Path, inside: Path) -> None:
    """Raise ArgumentError unless a process of its own can load an unpacked FMU's library.

    One that is cut off or overwritten ends the process that loads it instead of raising.
    """
    here, library = inside.parent.name, folder.absolute() / inside
    if not library.is_file():
        raise ArgumentError(_why_none(folder, inside))
    load = [sys.executable, "-I", "-S", "-c", "import ctypes as c, sys; c.CDLL(sys.argv[1])"]
    done = subprocess.run(
        [*load, str(library)], cwd=library.parent, capture_output=True, text=True, check=False
    )
    if done.returncode:
        *_, said = ("", *done.stderr.strip().splitlines())
        _, ours, why = said.removeprefix("OSError: ").rpartition(f"{library}: ")
        if done.returncode != 1:
            why = "the process that tried was ended by it, so it is damaged or cut off"
        elif ours and "No such file" in why:  # the loader's word for another processor's
            why = "it is for another processor"
        raise ArgumentError(
            f"its library {inside.as_posix()} cannot be loaded on this machine: {why}. "
            f"Copy the file again, or export it again for {here}."
        )


def _why_none(folder: Path, inside: Path) -> str:
    """Reason why an FMU has no library for this machine, and the remedy."""
    here, lacks = inside.parent.name, f"it has no {inside.as_posix()}"
    named = sorted(item.name for item in (folder / inside).parent.glob(f"*{inside.suffix}"))
    if named:
        return (
            f"{lacks} but {', '.join(named)} there, and a library has the name of its "
            f"modelIdentifier, {inside.stem}. Rename it, or export it again."
        )
    others = sorted(item.name for item in folder.glob("binaries/*") if any(item.iterdir()))
    sources = (
        " It has its sources: build them (--compile)." if (folder / "sources").is_dir() else ""
    )
    return (
        f"{lacks}, and this platform is {here}; it is built for "
        f"{', '.join(others) or 'no platform'}. Export it for {here}.{sources}"
    )


def build_sources(folder: Path, inside: Path, description: Any) -> None:
    """Build an unpacked FMU's C sources into its library for this machine, unless it has one.

    Raises ArgumentError where it has none or they cannot be built, CompilerError without compiler.
    """
    if (folder / inside).is_file():
        return
    sets = [part for one in description.buildConfigurations[:1] for part in one.sourceFileSets]
    if not sets:
        raise ArgumentError(
            f"{_why_none(folder, inside)} It names no sources that could be built instead."
        )
    if foreign := sorted({part.language for part in sets if "++" in (part.language or "")}):
        raise ArgumentError(f"its sources are {foreign[0]}, and only C is built. Build it there.")
    chain, own = find_toolchain(), folder / "sources"
    defined = [f"{d.name}={d.value}" if d.value else d.name
               for part in sets for d in part.preprocessorDefinitions]  # fmt: skip
    flags = ["-O2", "-shared", "-w", *([] if inside.suffix == ".dll" else ["-fPIC"])]
    flags += [f"-D{item}" for item in (*_WITHOUT_PREFIX, *defined)]
    folders = [own, Path(fmpy.__file__).parent / "c-code"]
    flags += [f"-I{item.absolute()}" for item in folders]
    files = [str((own / name).absolute()) for part in sets for name in part.sourceFiles]
    library = (folder / inside).absolute()
    library.parent.mkdir(parents=True, exist_ok=True)
    command = [*chain.command, *flags, *files, "-o", str(library), "-lm"]
    done = run_command(command, timeout=TIMEOUT, folder=own)
    if done.how:
        lines = [line for line in done.output.splitlines() if "error" in line]
        said = (lines or [done.output[-200:]])[0].strip()
        raise ArgumentError(
            f"its sources cannot be built by {chain.name}, which {done.how}: {said}. Export it for "
            f"{inside.parent.name}."
        )
