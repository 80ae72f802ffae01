"""The program as a shell sees it: exit codes, streams, signals, pipes."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from tests.commands import flat
from wmr_ctrl.cli.console import Interruption, explain, resumable
from wmr_ctrl.core.errors import ScenarioError

PIPE = subprocess.PIPE
posix = pytest.mark.skipif(os.name == "nt", reason="signals and pipes of POSIX")


@pytest.fixture
def started(environment, program_line, tmp_path):
    """Start `wmr-ctrl` and leave it running."""

    def start(*args, **options):
        command = (*program_line, *args)
        return subprocess.Popen(
            command, stderr=PIPE, text=True, env=environment, cwd=tmp_path, **options
        )

    return start


def test_result_goes_to_stdout_and_talk_to_stderr(program):
    done = program("run --engine numpy --set clock.duration=0.2 --json")

    assert done.returncode == 0
    assert json.loads(done.stdout)["outcome"] == "completed"
    assert done.stderr.startswith("law nn: stated in the scenario\nwarning: ")


def test_errors_are_exit_code_2_without_traceback(program):
    done = program("--bogus")

    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith("error: ")
    assert "Traceback" not in done.stderr


@posix
@pytest.mark.parametrize(
    "args", [("scenarios", "far-start"), ("laws",), ("check", "far-start", "--law", "pid")]
)
@pytest.mark.slow_but("args1")
def test_reader_that_leaves_early_is_no_error(started, args):
    process = started(*args, stdout=PIPE)
    process.stdout.close()

    _, stderr = process.communicate(timeout=60)
    slow = (" left", " s", " begun")  # progress: "33 %, about 5 s left", "at work for 2 s"
    assert all(line.endswith(slow) for line in stderr.splitlines())
    assert process.returncode == 141


def interrupted(process):
    """Both streams of a process after Ctrl-C."""
    process.send_signal(signal.SIGINT)
    return process.communicate(timeout=120)


SAY = """
import signal, sys
from wmr_ctrl.__main__ import main
class Telling:
    def find_spec(name, *_):
        if name == "wmr_ctrl.cli":
            print("here", flush=True)
sys.meta_path.insert(0, Telling)
signal.signal(signal.SIGINT, signal.default_int_handler)
main()
"""
"""The program, which says when it begins to import its commands; what Python does before, on its
own, ends in Python's own traceback."""


@posix
@pytest.mark.parametrize("seconds", [0.0, 0.03, 0.09, 0.18, 0.3, 0.42, 0.54])
@pytest.mark.slow_but("0.0", "0.09")
def test_interruption_of_the_imports_is_no_traceback(environment, tmp_path, seconds):
    line = (sys.executable, "-c", SAY, "run", "--engine", "numpy", "--set", "clock.duration=4000")
    process = subprocess.Popen(
        line, stdout=PIPE, stderr=PIPE, text=True, env=environment, cwd=tmp_path
    )
    assert process.stdout.readline() == "here\n"
    time.sleep(seconds)
    stdout, stderr = interrupted(process)

    assert process.returncode in (130, -signal.SIGINT)  # a shell says 130 for both
    assert stdout == ""
    assert "Traceback" not in stderr


def test_what_a_library_makes_of_an_interruption_is_one(monkeypatch, capsys):
    """An interrupt during NumPy's import becomes an ImportError, and during a class definition a
    RuntimeError.
    """
    assert explain(ImportError("numpy failed to import"), debug=False) == 70
    monkeypatch.setattr(Interruption, "heard", True)
    assert explain(ImportError("numpy failed to import"), debug=False) == 130
    assert explain(ScenarioError("a mistake"), debug=False) == 2
    assert "error: Interrupted." in capsys.readouterr().err


@pytest.mark.parametrize("heard", [False, True])
def test_what_is_done_is_named_where_a_library_makes_an_error_of_an_interruption(
    heard, monkeypatch, capsys, tmp_path
):
    monkeypatch.setattr(Interruption, "heard", heard)
    with pytest.raises(ValueError, match="closed"), resumable(tmp_path):
        raise ValueError("seek of closed file")
    assert ("the same command goes on" in flat(capsys.readouterr().err)) == heard


@posix
def test_interruption_is_exit_code_130_and_leaves_nothing(started, tmp_path):
    args = ("run", "--engine", "numpy", "--set", "clock.duration=4000", "--out", "a.npz")
    process = started(*args, stdout=PIPE)
    assert process.stderr.readline().startswith("law nn: ")
    stdout, stderr = interrupted(process)

    assert process.returncode == 130
    assert stdout == ""
    assert stderr.strip().endswith("error: Interrupted.")
    assert list(tmp_path.iterdir()) == []


DROP = """
import contextlib, signal, time
import wmr_ctrl.cli
from wmr_ctrl.__main__ import main
def commands():
    with contextlib.suppress(KeyboardInterrupt):  # as a library's own code may
        print("here", flush=True)
        time.sleep(60)
    try:
        time.sleep(60)
    except KeyboardInterrupt:
        time.sleep(0.5)  # what cleans up is left in peace
        raise SystemExit(130)
wmr_ctrl.cli.main = commands
signal.signal(signal.SIGINT, signal.default_int_handler)
main()
"""


@posix
def test_an_interruption_that_a_library_drops_comes_again(environment):
    process = subprocess.Popen(
        (sys.executable, "-c", DROP), stdout=PIPE, stderr=PIPE, text=True, env=environment
    )
    assert process.stdout.readline() == "here\n"
    _, stderr = interrupted(process)

    assert (process.returncode, stderr) == (130, "")
