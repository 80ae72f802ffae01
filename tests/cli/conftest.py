"""The command line, called in this process and as a separate program."""

import math
import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

import wmr_ctrl
from wmr_ctrl.cli import console, root

CODE = """
import signal
from wmr_ctrl.__main__ import main
signal.signal(signal.SIGINT, signal.default_int_handler)
main()
"""
PROGRAM = (sys.executable, "-c", CODE)
"""Command line that reacts to Ctrl-C even if the tests were started to ignore it, as in a shell's
background."""
SHORT = ("--engine", "numpy", "--set", "clock.duration=0.2")
"""Options of a run that needs neither a compiler nor time."""


def words_of(*args):
    """Split a command line that is one text; several words stay as they are."""
    return shlex.split(*args) if len(args) == 1 and " " in str(args[0]) else [*map(str, args)]


@pytest.fixture
def wmr(monkeypatch):
    """Call `wmr-ctrl` in a terminal of 80 columns; the result has exit_code, stdout, stderr.

    It takes a command line, or words.

    Lines on stderr about a job's duration are removed, since they depend on the machine's load.
    """
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setattr(console, "FIRST", math.inf)

    def call(*args):
        return CliRunner().invoke(root, words_of(*args))

    return call


@pytest.fixture
def short_run(wmr):
    """Call `wmr-ctrl run` on a fifth of a second of a scenario."""

    def call(*args):
        return wmr("run", *words_of(*(args or ("paper-simulation",))), *SHORT)

    return call


@pytest.fixture(scope="session")
def environment():
    """Environment in which a Python process finds this package, installed or not."""
    found = str(Path(wmr_ctrl.__file__).parents[1])
    paths = [found, os.environ.get("PYTHONPATH", "")]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths)), "COLUMNS": "80"}


@pytest.fixture(scope="session")
def program_line():
    """Words that start `wmr-ctrl` as a separate process."""
    return PROGRAM


@pytest.fixture
def program(environment, tmp_path):
    """Run `wmr-ctrl` as a process in an empty folder."""

    def call(*args):
        command = (*PROGRAM, *words_of(*args))
        return subprocess.run(
            command, capture_output=True, text=True, env=environment, cwd=tmp_path, timeout=120
        )

    return call
