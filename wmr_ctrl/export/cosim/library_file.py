"""This machine's library in an unpacked FMU: its place, a test of loading it, or its build."""

import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import fmpy
from fmpy.model_description import ModelDescription

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.export.fmi.targets import TARGETS, host

_WITHOUT_PREFIX = "-DFMI2_OVERRIDE_FUNCTION_PREFIX -DFMI3_OVERRIDE_FUNCTION_PREFIX"
"""Compiler flags with which functions have no prefix of the model's name."""


def place_of(folder: Path, version: int, model: str) -> Path:
    """Path of this machine's library in an unpacked FMU.

    In FMI 2 a processor's own folder has priority over the one that FMPy uses, which may contain
    another processor's library.
    """
    name = model + fmpy.sharedLibraryExtension
    if version == 3:
        return Path("binaries", fmpy.platform_tuple, name)
    own = (Path("binaries", target.fmi2, name) for target in TARGETS if target.name == host())
    there = (place for place in own if (folder / place).is_file())
    return next(there, Path("binaries", fmpy.platform, name))


def try_to_load(folder: Path, inside: Path) -> None:
    """Raise ArgumentError unless a separate process can load an unpacked FMU's library.

    A truncated or overwritten library ends the process that loads it instead of raising.
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
    """Reason why an FMU lacks a library for this machine, with the remedy."""
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


def build_sources(folder: Path, inside: Path, description: ModelDescription) -> None:
    """Build an unpacked FMU's sources into its library for this machine, unless it has one.

    FMPy calls CMake for it.  Raises ArgumentError if there are no sources, or the build fails.
    """
    if (folder / inside).is_file():
        return
    if not description.buildConfigurations:
        raise ArgumentError(
            f"{_why_none(folder, inside)} It names no sources that could be built instead."
        )
    try:
        from fmpy.build import build_platform_binary

        flags = {"CMAKE_C_FLAGS:STRING": _WITHOUT_PREFIX}
        with TemporaryDirectory() as place:
            build_platform_binary(folder, place, cmake_options=flags)
    except Exception as error:  # FMPy raises bare Exceptions
        raise ArgumentError(
            f"its sources cannot be built by CMake ({error}), whose messages, if it is installed, "
            f"are on standard error. Export it for {inside.parent.name}."
        ) from error
