"""Commands that are run, and the compiler's flags."""

import signal
import sys
import threading

import pytest

from wmr_ctrl.codegen.compiler import Finished, is_zig, run_command


def run(script, **given):
    return run_command([sys.executable, "-c", script], **{"timeout": 60.0, **given})


def test_output_and_exit_code_of_a_command_are_kept(tmp_path):
    done = run("import os, sys; print(os.getcwd(), os.environ['X']); sys.exit(3)",
               folder=tmp_path, environment={"X": "y"})  # fmt: skip

    assert (done.code, done.how) == (3, "ended with exit code 3")
    assert done.output.split() == [str(tmp_path), "y"]
    assert run("").how == ""


def test_a_command_that_takes_too_long_or_is_to_stop_is_killed():
    stop = threading.Event()
    stop.set()

    assert run("import time; time.sleep(60)", timeout=0.3).how == "did not finish in time"
    assert run("import time; time.sleep(60)", stop=stop).timed_out
    assert Finished(-int(signal.SIGKILL), "").how == "was killed by SIGKILL"
    with pytest.raises(OSError, match="no_such_command"):
        run_command(["no_such_command"], timeout=1.0)


def test_zig_is_known_by_its_name():
    assert is_zig([sys.executable, "-m", "ziglang", "cc"])
    assert not is_zig(["/usr/bin/cc"])
