"""The command line ``wmr-ctrl``: parse, call, print.

Nothing heavier than click is imported before a command runs.
"""

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def _ended_by_interrupt() -> Iterator[None]:
    """Within, Ctrl-C ends the process with 130 and without a traceback: nothing is begun yet."""
    usual = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if not usual or threading.current_thread() is not threading.main_thread():
        yield
        return
    signal.signal(signal.SIGINT, lambda *_: os._exit(130))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


with _ended_by_interrupt():
    from wmr_ctrl.cli.root import main as main
    from wmr_ctrl.cli.root import root as root
