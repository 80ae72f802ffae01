"""Compilers and emulators that only some tests need: where they are, and how they are called."""

import importlib.util
import os
import shutil
import sys
from functools import lru_cache
from pathlib import Path

import pytest

from tests.commands import finished
from wmr_ctrl.codegen.cache import cache_dir
from wmr_ctrl.codegen.compiler import WITHOUT_RUNTIME
from wmr_ctrl.export.page.module import LINKING

FLAGS = ("-std=c99", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math")
ZIG = (sys.executable, "-P", "-m", "ziglang", "cc", "-s")
"""Command of the zig compiler, which links without symbols, as for FMUs."""
WASM = (*ZIG, "-target", "wasm32-wasi", "-O2")
SIMD128 = ("-Xclang", "-target-feature", "-Xclang", "+simd128")
"""Vectors of WebAssembly for what is compiled: for -msimd128 zig builds its C library anew."""
QEMU = ("qemu-aarch64", "qemu-aarch64-static")
WINE = ("wine64", "/usr/lib/wine/wine64")
NODE = ("node", "nodejs")
ARM_LIBRARIES = Path("/usr/aarch64-linux-gnu")
"""Folder of that processor's C library, as Debian's libc6-arm64-cross installs it."""
ARM = "aarch64-linux-gnu.2.17" if ARM_LIBRARIES.is_dir() else "aarch64-linux-musl"
"""Target for zig; without that library zig compiles its own into the program, for most of a minute.
"""
BESIDE_QEMU = {"QEMU_LD_PREFIX": str(ARM_LIBRARIES)}


def where(*names):
    """The first of these programs that is installed; skips if none is."""
    path = next((path for path in map(shutil.which, names) if path), None)
    if path is None:
        pytest.skip(f"NOT RUN: {names[0]} is not on this machine")
    return path


def needs_compiler(command):
    """Skip if the compiler that a command calls is missing."""
    if tuple(command[: len(ZIG)]) != ZIG:
        where(command[0])
    elif importlib.util.find_spec("ziglang") is None:
        pytest.skip("NOT RUN: ziglang is not there")


def compile_in(folder, command):
    """Run a compiler's command in a folder, with zig's parts in the tests' cache."""
    zig = str(cache_dir() / "zig")
    own = {"ZIG_GLOBAL_CACHE_DIR": zig, "ZIG_LOCAL_CACHE_DIR": zig}
    finished(command, cwd=folder, env={**os.environ, **own})


def compile_program(folder, command, units, out):
    """A program of units; WebAssembly is linked as the page's module, without a C library."""
    suffix = Path(out).suffix
    if suffix != ".wasm":
        zig = tuple(command[: len(ZIG)]) == ZIG and suffix != ".exe"
        own = WITHOUT_RUNTIME if zig else ("-lm",)
        compile_in(folder, [*command, *units, *own, "-o", out])
        return
    objects = []
    for unit in units:
        objects.append(f"{len(objects)}.o")
        compile_in(folder, [*command, "-c", unit, "-o", objects[-1]])
    compile_in(folder, [*command, *LINKING, "-rtlib=compiler-rt", *objects, "-o", out])


def processor():
    """Names of this processor's instructions, as Linux reports them."""
    path = Path("/proc/cpuinfo")
    text = path.read_text(encoding="utf-8") if path.is_file() else ""
    return {word for line in text.splitlines() if line.startswith("flags") for word in line.split()}


@lru_cache
def wine():
    """Environment in which wine starts a program quickly, with a folder of the tests' cache as
    home.

    Setting up a Windows takes wine a minute of a processor and 700 MB. A stamp file says that the
    set-up is complete.  Command-line programs do not need it: in this mode libraries come from
    wine's own installation.
    """
    home = cache_dir() / "wine"
    prefix = home / "prefix"
    prefix.mkdir(parents=True, exist_ok=True)
    (prefix / ".update-timestamp").write_text("disable\n", encoding="utf-8")
    return {
        "WINEDEBUG": "-all", "HOME": str(home), "WINEPREFIX": str(prefix), "WINEBOOTSTRAPMODE": "1"
    }  # fmt: skip
