"""The program, as the script ``wmr-ctrl`` or as ``python -m wmr_ctrl``."""

import signal


def main() -> None:
    """Import the commands, during which Ctrl-C ends the process in silence, and do what is asked.

    Whoever ignores Ctrl-C, as a shell's background does, goes on ignoring it.
    """
    heard = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if heard:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from wmr_ctrl.cli import main as commands

    if heard:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    commands()


if __name__ == "__main__":
    main()
