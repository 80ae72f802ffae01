"""How long jobs tell of their progress, without knowing who shows it."""

from __future__ import annotations

from typing import Protocol


class Progress(Protocol):
    """Whatever shows progress; each phase of a job is one ``start``, many ``advance``, ``done``."""

    def start(self, total: int, text: str) -> None:
        """A phase of ``total`` steps begins; ``text`` says what it does."""

    def advance(self, count: int = 1) -> None:
        """``count`` further steps of the phase are done."""

    def done(self) -> None:
        """The phase is over, finished or given up."""


class Silent:
    """Progress that nobody looks at."""

    def start(self, total: int, text: str) -> None:
        """Show nothing."""

    def advance(self, count: int = 1) -> None:
        """Show nothing."""

    def done(self) -> None:
        """Show nothing."""
