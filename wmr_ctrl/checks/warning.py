"""Warning: one thing that theory has to say against a run."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Warning:
    """A sentence of what, by how much, and the remedy.

    ``key`` is the scenario's key (or ``law``) that the remedy starts from; ``equation`` names the
    place in the paper that the statement rests on, such as ``"Eq. (9)"``.
    """

    key: str
    sentence: str
    equation: str

    def __str__(self) -> str:
        """The sentence, then its place in the paper."""
        return f"{self.sentence} [{self.equation}]"
