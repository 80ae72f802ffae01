"""The program, as the script ``wmr-ctrl`` or as ``python -m wmr_ctrl``."""

import os
import signal
import sys


def main() -> None:
    """Import the commands, during which Ctrl-C ends the process silently, and run the command line.

    If the process already ignores Ctrl-C, as in a shell's background, it continues to ignore it.
    """
    # Threads of OpenBLAS wait busily for each other: twenty times the work for matrices as small as
    # these on a busy machine.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    heard = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if heard:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from wmr_ctrl.cli import main as commands

    if heard:
        signal.signal(signal.SIGINT, _interrupt)
        if sys.platform != "win32":
            signal.signal(signal.SIGALRM, _interrupt)
    try:
        commands()
    finally:
        _repeat(0.0)


def _interrupt(number: int, _: object) -> None:
    """Raise KeyboardInterrupt, and raise it again if library code dropped it.

    Library code, such as CasADi's while it builds expressions, may drop a Python exception.
    """
    from wmr_ctrl.cli.console import Interruption

    Interruption.heard = True
    sys.unraisablehook = lambda _: None  # what was torn by it need not be told
    _repeat(0.1)
    error = sys.exc_info()[1]
    while error and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    if number == signal.SIGINT or error is None:
        raise KeyboardInterrupt


def _repeat(seconds: float) -> None:
    """Call `_interrupt` again after ``seconds``; 0 cancels the call."""
    if sys.platform != "win32":
        signal.setitimer(signal.ITIMER_REAL, seconds)


if __name__ == "__main__":
    main()
