"""Errors as one paragraph on stderr and an exit code."""

from __future__ import annotations

import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import click

from wmr_ctrl.cli.console import say
from wmr_ctrl.errors import WmrError

DIFFERENCE, WRONG_INPUT, FMU_FAILED, FAULT, INTERRUPTED, BROKEN_PIPE = 1, 2, 3, 70, 130, 141


@contextmanager
def resumable(record: Path) -> Iterator[None]:
    """Long work with a ``record`` of what is done: who interrupts it is told that it goes on."""
    try:
        yield
    except KeyboardInterrupt:
        if record.exists():
            say("note", f"what is done is kept in {record}; the same command goes on from there.")
        raise


def explain(error: Exception, *, debug: bool) -> int:
    """Tell the user about ``error``, with its traceback if ``debug``; returns the exit code."""
    if debug:
        click.echo("".join(traceback.format_exception(error)), err=True, nl=False)
    text, code = _told(error)
    say("error", text)
    for note in vars(error).get("__notes__", ()):
        click.echo(note, err=True)
    return code


def _told(error: Exception) -> tuple[str, int]:
    match error:
        case click.Abort() | SystemError(__cause__=KeyboardInterrupt()):  # met within a library
            return "Interrupted.", INTERRUPTED
        case click.UsageError(ctx=click.Context() as ctx):
            return f"{error.format_message()} See '{ctx.command_path} --help'.", WRONG_INPUT
        case click.ClickException():
            return error.format_message(), WRONG_INPUT
        case WmrError():
            return str(error), WRONG_INPUT
        case OSError():
            return _system(error), WRONG_INPUT
        case _:
            return _fault(error), FAULT


def _system(error: OSError) -> str:
    reason = error.strerror or str(error) or type(error).__name__
    where = f"{error.filename}: " if error.filename else ""
    return f"{where}{reason}. Check that the file exists, may be accessed and fits on the disk."


def _fault(error: Exception) -> str:
    return (
        f"{type(error).__name__}: {error or 'no message'}. This should not happen: rerun with "
        "--debug to see where it comes from, and report it together with the command."
    )
