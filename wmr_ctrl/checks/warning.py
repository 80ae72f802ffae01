"""Warning: one thing that theory has to say against a run; and words that several checks share."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

SPEEDS = ("v1", "omega")
UNITS = ("m/s", "rad/s")
FORCE_UNITS = ("N", "N m")


@dataclass(frozen=True, slots=True)
class Warning:
    """A sentence of what, by how much, and the remedy.

    ``key`` is the scenario's key (or ``law``) that the remedy starts from; ``equation`` names the
    place that the statement rests on: one of the paper, such as ``"Eq. (9)"``, or a limit.
    ``objects``: whether something is expected to go wrong; if not, a promise is only narrower than
    it might be, and a run that shows no fault needs no change.
    """

    key: str
    sentence: str
    equation: str
    objects: bool = True

    def __str__(self) -> str:
        """The sentence, then the place that it rests on."""
        return f"{self.sentence} [{self.equation}]"


def joined(parts: Iterable[str]) -> str:
    """The parts as in "a", "a and b" or "a, b and c"."""
    *head, last = parts
    return f"{', '.join(head)} and {last}" if head else last
