"""What the commands print: paragraphs on stderr, tables and JSON on stdout."""

from __future__ import annotations

import json
import shutil
import textwrap
from collections.abc import Iterable, Sequence

import click

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
    if _before_last([*listed, *([header] if header else [])]) > width() - ROOM:
        cells = ((name, ", ".join(filter(None, rest))) for name, *rest in listed)
        return "\n".join(wrapped(f"{name}: {rest}", hang="  ") for name, rest in cells)
    grid = Table(box=SIMPLE_HEAD if header else None, show_header=bool(header), pad_edge=False)
    for i, name in enumerate(header or listed[0]):
        last = i == len(listed[0]) - 1
        grid.add_column(name if header else "", overflow="fold", no_wrap=not last)
    for row in listed:
        grid.add_row(*(Text(cell) for cell in row))
    console = Console(width=width(), color_system=None, legacy_windows=False)
    with console.capture() as capture:
        console.print(grid)
    return "\n".join(line.rstrip() for line in capture.get().strip().splitlines())


def _before_last(rows: Sequence[Sequence[str]]) -> int:
    """Columns that all cells of a table but the last of each row take, with the gaps after them."""
    return sum(max(map(len, column)) + 2 for column in list(zip(*rows, strict=True))[:-1])
