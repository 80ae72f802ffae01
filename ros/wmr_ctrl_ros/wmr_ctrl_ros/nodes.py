"""Entry points: the Python that has wmr_ctrl takes over from the one that colcon's scripts name."""

from __future__ import annotations

import os
import sys
from importlib.util import find_spec
from pathlib import Path

CHOSEN = "WMR_CTRL_PYTHON"
"""Environment variable that names the Python of the virtual environment with wmr_ctrl."""


def run_filter() -> int:
    """Start ``wmr_filter``."""
    return _run("filter")


def run_drive() -> int:
    """Start ``wmr_drive``."""
    return _run("drive")


def _run(node: str) -> int:
    python = _python()
    if not python:
        sys.stderr.write(
            f"error: wmr_ctrl was not found. Name the Python of the virtual environment with it "
            f"in {CHOSEN}, or activate that environment: python3 -m venv --system-site-packages "
            "ENV, with ROS 2 sourced, and ENV/bin/pip install in the folder of wmr_ctrl.\n"
        )
        return 2
    words = [python, "-m", "wmr_ctrl.ros2", node, *sys.argv[1:]]
    try:
        os.execv(python, words)
    except OSError as error:
        sys.stderr.write(f"error: {python} cannot be run: {error.strerror}. Set {CHOSEN}.\n")
        return 2


def _python() -> str:
    """Python that is named, this one, or that of an active environment; "" where none is."""
    named, active = os.environ.get(CHOSEN, ""), os.environ.get("VIRTUAL_ENV", "")
    if named:
        return named
    if find_spec("wmr_ctrl"):
        return sys.executable
    candidate = Path(active) / "bin" / "python"
    return str(candidate) if active and candidate.is_file() else ""
