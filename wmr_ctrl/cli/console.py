"""Output of the commands: paragraphs, errors and progress on stderr, tables and JSON on stdout.

Progress is a bar with the time left in a terminal, now and then a line elsewhere.
"""

import json
import shutil
import sys
import textwrap
import threading
import time
import traceback
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Self

import click

from wmr_ctrl.core.errors import WmrError
from wmr_ctrl.core.late_bound import late_bound

DIFFERENCE, WRONG_INPUT, FMU_FAILED, FAULT, INTERRUPTED, BROKEN_PIPE = 1, 2, 3, 70, 130, 141
"""Exit codes."""
WIDEST = 100
ROOM = 12
"""Columns that the last cell of a table's rows needs at least."""
COLOURS = {"error": "red", "warning": "yellow", "note": "cyan", "wrote": "green"}


def width() -> int:
    """Columns to fill: the terminal's, 80 without a terminal, never more than 100."""
    return max(40, min(WIDEST, shutil.get_terminal_size((80, 24)).columns))


def say(label: str, text: str) -> None:
    """Print ``label: text`` on stderr as one wrapped paragraph without control characters."""
    filled = wrapped(f"{label}: {text}", hang="  ")
    head = click.style(f"{label}:", fg=COLOURS.get(label), bold=True)
    click.echo(head + filled[len(label) + 1 :], err=True)


def wrapped(text: str, indent: str = "", hang: str = "") -> str:
    """The text as one paragraph of at most `width` columns, with its white space normalised."""
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
    """Print one JSON document on stdout, with null for every number that is not finite."""
    click.echo(json_text(value))


def json_text(value: object) -> str:
    """JSON document of a value, with null for numbers that are not finite."""
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


LEAST = 1e-3
"""Smaller figures are not written out."""


def short_number(value: float, least: float = LEAST) -> str:
    """A number with three digits, or "<least" below ``least``: table cells have to be short."""
    return f"<{least:g}" if 0 < abs(value) < least else f"{float(f'{value:.3g}'):g}"


def note_missing_proofs() -> None:
    """Note on stderr that corridors are left out because the extra proofs is not installed."""
    from wmr_ctrl.theory.door import LEFT_OUT, is_open

    if not is_open():
        say("note", LEFT_OUT)


DRAWS_CORRIDORS = ("plot_run", "write_run_page", "plot_runs", "animate_runs")


def write_file(path: str | None, function: str, content: object, text: str = "") -> None:
    """Write ``path``, if it is given, by a `late_bound` function; ``text`` names its progress."""
    if not path:
        return
    if function in DRAWS_CORRIDORS:
        note_missing_proofs()
    if text:
        with Progress(text) as progress:
            late_bound(function)(content, path, progress)
    else:
        late_bound(function)(content, path)
    say("wrote", path)


@contextmanager
def resumable(record: Path) -> Iterator[None]:
    """Context of long work that keeps a ``record``; after an interruption it prints how to
    continue.
    """
    try:
        yield
    except BaseException as error:
        stopped = isinstance(error, KeyboardInterrupt) or Interruption.heard
        if stopped and record.exists():
            say("note", f"what is done is kept in {record}; the same command goes on from there.")
        raise


def explain(error: Exception, *, debug: bool) -> int:
    """Tell the user about ``error``, with its traceback if ``debug``; returns the exit code."""
    if debug:
        click.echo("".join(traceback.format_exception(error)), err=True, nl=False)
    text, code = _told(error)
    say("error", text)
    return code


def _told(error: Exception) -> tuple[str, int]:
    match error:
        case click.Abort():
            return "Interrupted.", INTERRUPTED
        case click.UsageError(ctx=click.Context() as ctx):
            text = error.format_message().removesuffix(".")
            if "extra argument" in text and any("--scenario" in p.opts for p in ctx.command.params):
                text += ": a scenario is given by --scenario"
            return f"{text}. See '{ctx.command_path} --help'.", WRONG_INPUT
        case click.ClickException():
            return error.format_message(), WRONG_INPUT
        case WmrError():
            return str(error), WRONG_INPUT
        case OSError():
            reason = error.strerror or str(error) or type(error).__name__
            where = f"{error.filename}: " if error.filename else ""
            remedy = "Check that the file exists, may be accessed and fits on the disk."
            return f"{where}{reason}. {remedy}", WRONG_INPUT
        case _ if Interruption.heard:
            return "Interrupted.", INTERRUPTED
        case _:
            text = (
                f"{type(error).__name__}: {error or 'no message'}. This should not happen: rerun "
                "with --debug to see where it comes from, and report it together with the command."
            )
            return text, FAULT


TICK = 0.25
"""Seconds between two looks at the clock where stderr is not a terminal."""
FIRST = INTERVAL = 3.0 - TICK
"""Seconds until the first line of progress, and between two: none may be silent for over 3 s."""


FORESEEN = 0.2
"""Share of a job before which its time left is not told: the beginning is not like the rest."""


class Interruption:
    """True if Ctrl-C was pressed: libraries may turn it into an error of their own."""

    heard = False


class Silence:
    """Time of the command line's last output."""

    since = time.monotonic()

    @classmethod
    def broken(cls) -> None:
        """Restart the count: a command began, or a line was written."""
        cls.since = time.monotonic()


class Progress:
    """Context in which a job called ``text`` reports its progress; it is called with the share."""

    def __init__(self, text: str) -> None:
        self._text = text

    def __enter__(self) -> Self:
        self._display = (Bar if sys.stderr.isatty() else Lines)(self._text)
        return self

    def __exit__(self, *_error: object) -> None:
        self._display.close()

    def __call__(self, share: float) -> None:
        """Report the ``share`` (0 to 1) that is done."""
        self._display.share(share)


class Bar:
    """Progress bar drawn by rich, removed at the end; before the first share it shows activity."""

    def __init__(self, text: str) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn
        from rich.progress import Progress as Rich

        name, share, left = "{task.description}", TaskProgressColumn(), TimeRemainingColumn()
        columns = (TextColumn(name), BarColumn(), share, left, TextColumn("left"))
        self._rich = Rich(*columns, console=Console(stderr=True), transient=True)
        self._task = self._rich.add_task(text, total=None)
        self._rich.start()

    def share(self, share: float) -> None:
        """Move the bar."""
        self._rich.update(self._task, completed=share, total=1.0)

    def close(self) -> None:
        """Clear the bar."""
        self._rich.stop()


class Lines:
    """Progress lines, one every three seconds, also while the job reports nothing."""

    def __init__(self, text: str) -> None:
        self._text, self._begin, self._share = text, time.monotonic(), 0.0
        self._next = Silence.since + FIRST
        self._turn, self._ended = threading.Lock(), threading.Event()
        threading.Thread(target=self._watch, daemon=True).start()

    def share(self, share: float) -> None:
        """Store the share, and print a line if the last one is long enough ago."""
        with self._turn:
            self._share = share
            if 0 < share < 1:
                self._say()

    def close(self) -> None:
        """End the lines."""
        self._ended.set()

    def _watch(self) -> None:
        while not self._ended.wait(TICK):
            with self._turn:
                if not self._ended.is_set():
                    self._say()

    def _say(self) -> None:
        now = time.monotonic()
        if now < self._next:
            return
        Silence.broken()
        self._next = now + INTERVAL
        if 0 < self._share < 1:
            left = (now - self._begin) * (1 - self._share) / self._share
            said = f"{100 * self._share:.0f} %"
            said += f", about {left:.0f} s left" if self._share >= FORESEEN else ""
        elif now - self._begin < 1:
            said = "begun"
        else:
            said = f"at work for {now - self._begin:.0f} s"
        click.echo(f"{self._text}: {said}", err=True)
