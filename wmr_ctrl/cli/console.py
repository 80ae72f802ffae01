"""Output of the commands: paragraphs and errors on stderr, tables and JSON on stdout."""

import json
import shutil
import textwrap
import traceback
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import click

from wmr_ctrl.errors import WmrError

DIFFERENCE, WRONG_INPUT, FMU_FAILED, FAULT, INTERRUPTED, BROKEN_PIPE = 1, 2, 3, 70, 130, 141
"""Exit codes."""
WIDEST = 100
ROOM = 12
"""Columns that the last cell of a table's rows needs at least."""
COLOURS = {"error": "red", "warning": "yellow", "note": "cyan", "wrote": "green"}


def width() -> int:
    """Columns to fill: the terminal's, 80 where there is none, never more than 100."""
    return max(40, min(WIDEST, shutil.get_terminal_size((80, 24)).columns))


def say(label: str, text: str) -> None:
    """Print ``label: text`` on stderr as one wrapped paragraph without control characters."""
    filled = wrapped(f"{label}: {text}", hang="  ")
    head = click.style(f"{label}:", fg=COLOURS.get(label), bold=True)
    click.echo(head + filled[len(label) + 1 :], err=True)


def wrapped(text: str, indent: str = "", hang: str = "") -> str:
    """The text as one paragraph of at most `width` columns, whatever white space it came with."""
    clean = "".join(c if c.isprintable() else " " for c in text)
    return textwrap.fill(
        " ".join(clean.split()),
        width(),
        initial_indent=indent,
        subsequent_indent=indent + hang,
        break_long_words=False,
        break_on_hyphens=False,
    )


def print_json(value: object) -> None:
    """Print one JSON document on stdout, with null for whatever is not a finite number."""
    click.echo(json_text(value))


def json_text(value: object) -> str:
    """The same document as a text."""
    from wmr_ctrl.results import json_safe

    return json.dumps(json_safe(value), indent=2, allow_nan=False)


def table(rows: Iterable[Sequence[str]], header: Sequence[str] = ()) -> str:
    """Rows of cells as an aligned table, the last column wrapped; as paragraphs in a narrow one."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    listed = list(rows)
    columns = list(zip(*listed, *([header] if header else []), strict=True))[:-1]
    widths = [max(len(line) for cell in column for line in cell.split("\n")) for column in columns]
    if sum(widths) + 2 * len(widths) > width() - ROOM:
        cells = ((name, ", ".join(filter(None, rest))) for name, *rest in listed)
        return "\n".join(wrapped(f"{name}: {rest}", hang="  ") for name, rest in cells)
    grid = Table(box=SIMPLE_HEAD if header else None, show_header=bool(header), pad_edge=False)
    for i, name in enumerate(header or listed[0]):
        last = i == len(listed[0]) - 1
        grid.add_column(Text(name if header else ""), overflow="fold", no_wrap=not last)
    for row in listed:
        grid.add_row(*(Text(cell) for cell in row))
    console = Console(width=width(), color_system=None, legacy_windows=False)
    with console.capture() as capture:
        console.print(grid)
    lines = (line.rstrip() for line in capture.get().splitlines())
    return textwrap.dedent("\n".join(lines)).strip("\n")


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
            reason = error.strerror or str(error) or type(error).__name__
            where = f"{error.filename}: " if error.filename else ""
            remedy = "Check that the file exists, may be accessed and fits on the disk."
            return f"{where}{reason}. {remedy}", WRONG_INPUT
        case _:
            text = (
                f"{type(error).__name__}: {error or 'no message'}. This should not happen: rerun "
                "with --debug to see where it comes from, and report it together with the command."
            )
            return text, FAULT
