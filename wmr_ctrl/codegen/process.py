"""Run one command to its end, or kill it with everything that it started."""

import contextlib
import os
import signal
import subprocess
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

_PATIENCE = 0.2
"""Longest time until a thread notices that it shall stop [s]."""


@dataclass(frozen=True, slots=True)
class Finished:
    """Result of a command: exit code (negative: the signal), output, timeout."""

    code: int
    output: str
    timed_out: bool = False

    @property
    def how(self) -> str:
        """The ending in words, empty if the command succeeded."""
        if self.timed_out:
            return "did not finish in time"
        if self.code < 0:
            with contextlib.suppress(ValueError):
                return f"was killed by {signal.Signals(-self.code).name}"
            return f"was killed by signal {-self.code}"
        return f"ended with exit code {self.code}" if self.code else ""


def run_command(
    command: Sequence[str],
    *,
    timeout: float,
    folder: Path | None = None,
    environment: Mapping[str, str] | None = None,
    stop: threading.Event | None = None,
) -> Finished:
    """Run ``command`` in ``folder`` without input and return how it ended.

    ``environment`` is added to the process's own; messages come in English.  After ``timeout``
    seconds, when this process is interrupted, or when ``stop`` is set (in threads, which interrupts
    do not reach), the command's whole process group is killed: compiler drivers start children
    which would outlive them.

    Raises OSError if the command cannot be started.
    """
    process = subprocess.Popen(
        command,
        cwd=folder,
        env={**os.environ, "LC_ALL": "C", **(environment or {})},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        start_new_session=True,
    )
    try:
        output = _output(process, timeout, stop or threading.Event())
    except subprocess.TimeoutExpired:
        return Finished(-int(signal.SIGTERM), _kill(process), timed_out=True)
    except BaseException:
        _kill(process)
        raise
    return Finished(process.returncode, output)


def _output(process: subprocess.Popen[str], timeout: float, stop: threading.Event) -> str:
    """All output; raises TimeoutExpired when the time is over, or at once when ``stop`` is set."""
    end = time.monotonic() + timeout
    while True:
        try:
            return process.communicate(timeout=min(_PATIENCE, max(end - time.monotonic(), 0.0)))[0]
        except subprocess.TimeoutExpired:
            if stop.is_set() or time.monotonic() >= end:
                raise


def _kill(process: subprocess.Popen[str]) -> str:
    with contextlib.suppress(ProcessLookupError, PermissionError):
        if os.name == "posix":
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
    try:
        return process.communicate(timeout=10.0)[0] or ""
    except subprocess.TimeoutExpired:
        return ""
