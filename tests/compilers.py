"""Compilers and emulators that only some tests need: where they are, and how they are called."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import pytest

from wmr_ctrl.codegen.cache_folder import cache_dir

FLAGS = ("-std=c99", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math")
ZIG = (sys.executable, "-P", "-m", "ziglang", "cc")
QEMU = ("qemu-aarch64", "qemu-aarch64-static")
WINE = ("wine64", "/usr/lib/wine/wine64")
NODE = ("node", "nodejs")
ARM_LIBRARIES = Path("/usr/aarch64-linux-gnu")
"""Where Debian's libc6-arm64-cross puts the C library of that processor."""
ARM = "aarch64-linux-gnu.2.17" if ARM_LIBRARIES.is_dir() else "aarch64-linux-musl"
"""Without that library zig compiles one of its own into the program, for most of a minute."""
BESIDE_QEMU = {"QEMU_LD_PREFIX": str(ARM_LIBRARIES)}
WINE_SETS_UP = threading.Lock()


def where(*names: str) -> str:
    """The first of these programs that is there; skips where none is."""
    path = next((path for path in map(shutil.which, names) if path), None)
    if path is None:
        pytest.skip(f"NOT RUN: {names[0]} is not on this machine")
    return path


def needs_compiler(command: Sequence[str]) -> None:
    """Skip where the compiler that a command calls is missing."""
    if tuple(command[: len(ZIG)]) != ZIG:
        where(command[0])
    elif importlib.util.find_spec("ziglang") is None:
        pytest.skip("NOT RUN: ziglang is not there")


def compile_in(folder: Path, command: Sequence[str]) -> None:
    """Run a compiler's command in a folder, with zig's parts in the tests' cache."""
    zig = str(cache_dir() / "zig")
    own = {"ZIG_GLOBAL_CACHE_DIR": zig, "ZIG_LOCAL_CACHE_DIR": zig}
    done = subprocess.run(
        list(command),
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, **own},
    )
    assert done.returncode == 0, done.stderr


def processor() -> set[str]:
    """Names of this processor's instructions, as Linux tells them."""
    path = Path("/proc/cpuinfo")
    text = path.read_text(encoding="utf-8") if path.is_file() else ""
    return {word for line in text.splitlines() if line.startswith("flags") for word in line.split()}


@lru_cache
def wine() -> dict[str, str]:
    """Environment in which wine keeps its files in the tests' cache, where they are set up by now.

    Setting up takes a minute of a processor and 700 MB, so all tests share it. Two programs that
    start wine at the same time in an empty folder both set it up, and then one of them may die: so
    it is done here, by one thread of one process, before any of them runs.
    """
    import fcntl

    home = cache_dir() / "wine"
    home.mkdir(parents=True, exist_ok=True)
    own = {"WINEDEBUG": "-all", "HOME": str(home), "WINEPREFIX": str(home / "prefix")}
    with WINE_SETS_UP, (home / "lock").open("w", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (ready := home / "ready").exists():
            subprocess.run(
                [where(*WINE), "wineboot", "-i"],
                capture_output=True, timeout=300, check=False, env={**os.environ, **own},
            )  # fmt: skip
            ready.touch()
    return own
