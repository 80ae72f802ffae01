"""What a wheel needs beside the dependencies of pyproject.toml: a C compiler, where there is none.

The compiler is the wheel `ziglang`, 0.4 GB when installed.  A checkout is built for the machine on
which `pip install .` runs, so it goes without the wheel where a compiler works there.  Whoever
builds from a source archive, as `python -m build` does for its wheel, builds for any machine: that
wheel always asks for it.
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
"""It covers every platform that casadi's wheels cover, so it needs no marker."""


class CompilerHook(BuildHookInterface):
    """Adds the compiler's wheel to the dependencies of a wheel that needs it."""

    def initialize(self, version: str, build_data: dict[str, object]) -> None:
        """Before a wheel is built, an editable one too."""
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
