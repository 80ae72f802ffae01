"""Add a C compiler to a wheel's dependencies if the machine has none.

The compiler is the wheel `ziglang`, 0.4 GB when installed. A checkout is built for the machine on
which `pip install .` runs, so it needs no wheel if a compiler works there. A wheel that is built
from a source archive, as by `python -m build`, is for any machine: it always requires the compiler.
"""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import tempfile
from pathlib import Path

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

ROOT = Path(__file__).parent
PROBE = ROOT / "wmr_ctrl" / "codegen" / "probe.c"
NAMES = ("cc", "gcc", "clang")
VARIABLE = "WMR_CTRL_CC"
COMPILER = "ziglang>=0.13"
"""Compiler wheel; it exists for every platform of casadi's wheels, so it needs no marker."""


class CompilerHook(BuildHookInterface):
    """Hook that adds the compiler's wheel to the dependencies of a wheel that needs it."""

    def initialize(self, version: str, build_data: dict[str, object]) -> None:
        """Run before a wheel is built, also an editable one."""
        if not (built_here() and compiler()):
            build_data["dependencies"] = [*build_data.get("dependencies", []), COMPILER]


def built_here() -> bool:
    """True for a checkout: a source archive has a PKG-INFO at its top."""
    return not (ROOT / "PKG-INFO").exists()


def compiler() -> str:
    """The first command that compiles the probe of `wmr_ctrl.codegen.toolchain`, or nothing."""
    named = os.environ.get(VARIABLE, "").strip()
    if named:
        commands = [shlex.split(named, posix=os.name != "nt")]
    else:
        commands = [[found] for found in map(shutil.which, NAMES) if found]
    return next((shlex.join(command) for command in commands if _compiles(command)), "")


def _compiles(command: list[str]) -> bool:
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "probe.lib"
        call = [*command, "-shared", "-fPIC", "-o", str(out), str(PROBE), "-lm"]
        try:
            done = subprocess.run(call, capture_output=True, timeout=60, check=False)
        except (OSError, subprocess.TimeoutExpired):
            return False
        return done.returncode == 0 and out.exists()
