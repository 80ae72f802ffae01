"""Redirection of standard output to standard error while foreign code runs."""

import ctypes as ct
import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stdout, suppress
from threading import Lock

_LOCK = Lock()
_UNDO = ExitStack()
_running: set[object] = set()


@contextmanager
def diverted() -> Iterator[None]:
    """Context in which output of libraries and embedded interpreters goes to standard error.

    It affects the whole process, until the last thread leaves it.
    """
    one = object()
    with _LOCK:
        if not _running:
            _flush()
            _UNDO.enter_context(redirect_stdout(sys.stderr))
            with suppress(OSError):  # no standard output, or no standard error
                _divert(_UNDO)
        _running.add(one)
    try:
        yield
    finally:
        with _LOCK:
            _running.remove(one)
            if not _running:
                _flush()
                _UNDO.close()


def _divert(undo: ExitStack) -> None:
    """Redirect file descriptor 1 to the target of 2 until ``undo`` is closed."""
    kept = os.dup(1)
    undo.callback(os.close, kept)
    undo.callback(os.dup2, kept, 1)
    os.dup2(2, 1)


def _flush() -> None:
    """Flush Python's and C's output buffers."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(AttributeError, OSError, ValueError):
            stream.flush()
    with suppress(OSError, AttributeError):
        library = ct.cdll.ucrtbase if os.name == "nt" else ct.CDLL(None)
        library.fflush(None)
