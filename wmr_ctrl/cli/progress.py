"""Progress on stderr: a bar with the time left in a terminal, now and then a line elsewhere."""

import sys
import threading
import time
from typing import Any, Self

import click

TICK = 0.25
"""Seconds between two looks at the clock where stderr is not a terminal."""
FIRST = INTERVAL = 3.0 - TICK
"""Seconds until the first line there, and between two: no command is silent for more than 3 s."""


class Silence:
    """Since when the command line has said nothing."""

    since = time.monotonic()

    @classmethod
    def broken(cls) -> None:
        """Now: a command begins, or a line was written."""
        cls.since = time.monotonic()


class Progress:
    """Context in which a job tells of its progress, in either of two ways.

    Called with the share that is done; or by ``start(total, text)``, ``advance(count)`` and
    ``done()`` for each phase.
    """

    def __init__(self, text: str, *, measured: bool = True) -> None:
        """Begin with a phase called ``text``; not ``measured``: only that something is going on."""
        self._text, self._measured = text, measured
        self._total, self._count = 1, 0

    def __enter__(self) -> Self:
        """Begin to show."""
        self._display = Bar() if sys.stderr.isatty() else Lines()
        self._display.phase(self._text, self._measured)
        return self

    def __exit__(self, *_error: object) -> None:
        """Clear what was shown, also after an error."""
        self._display.close()

    def __call__(self, share: float) -> None:
        """``share`` (0 to 1) of the present phase is done."""
        self._display.share(share)

    def start(self, total: int, text: str) -> None:
        """A phase of ``total`` steps begins."""
        self._total, self._count = max(1, total), 0
        self._display.phase(text, measured=True)

    def advance(self, count: int = 1) -> None:
        """``count`` further steps of the phase are done."""
        self._count += count
        self(self._count / self._total)

    def done(self) -> None:
        """The phase is over."""
        self(1.0)


class Bar:
    """A bar that rich draws, and that vanishes at the end."""

    def __init__(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn
        from rich.progress import Progress as Rich

        text, share, left = "{task.description}", TaskProgressColumn(), TimeRemainingColumn()
        columns = (TextColumn(text), BarColumn(), share, left, TextColumn("left"))
        self._rich = Rich(*columns, console=Console(stderr=True), transient=True)
        self._task: Any = None
        self._rich.start()

    def phase(self, text: str, measured: bool) -> None:
        """Replace the bar."""
        if self._task is not None:
            self._rich.remove_task(self._task)
        self._task = self._rich.add_task(text, total=1.0 if measured else None)

    def share(self, share: float) -> None:
        """Move the bar."""
        self._rich.update(self._task, completed=share, total=1.0)

    def close(self) -> None:
        """Clear the bar."""
        self._rich.stop()


class Lines:
    """A line every three seconds, also while nothing is heard of the job."""

    def __init__(self) -> None:
        self._next, self._text, self._begin, self._share = Silence.since + FIRST, "", 0.0, 0.0
        self._turn, self._ended = threading.Lock(), threading.Event()
        threading.Thread(target=self._watch, daemon=True).start()

    def phase(self, text: str, measured: bool) -> None:
        """Store the phase's text and begin."""
        with self._turn:
            self._text, self._begin, self._share = text, time.monotonic(), 0.0

    def share(self, share: float) -> None:
        """Take the share, and say so if the last line is long enough ago."""
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
        if now < self._next or not self._text:  # before the first phase there is nothing to name
            return
        Silence.broken()
        self._next = now + INTERVAL
        if 0 < self._share < 1:
            left = (now - self._begin) * (1 - self._share) / self._share
            said = f"{100 * self._share:.0f} %, about {left:.0f} s left"
        elif now - self._begin < 1:
            said = "begun"
        else:
            said = f"at work for {now - self._begin:.0f} s"
        click.echo(f"{self._text}: {said}", err=True)
