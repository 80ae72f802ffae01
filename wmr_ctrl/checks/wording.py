"""Words that several checks share."""

from __future__ import annotations

from collections.abc import Iterable

SPEEDS = ("v1", "omega")
UNITS = ("m/s", "rad/s")
FORCE_UNITS = ("N", "N m")


def joined(parts: Iterable[str]) -> str:
    """The parts as in "a", "a and b" or "a, b and c"."""
    *head, last = parts
    return f"{', '.join(head)} and {last}" if head else last
