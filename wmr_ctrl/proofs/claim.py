"""Claim: one line of the ledger before it is checked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from wmr_ctrl.proofs.methods.spec import Method
from wmr_ctrl.proofs.statement import Statement

PRINTED, CORRECTED, OURS = "printed", "corrected", "ours"


@dataclass(frozen=True)
class Claim:
    """What is claimed, what it means for a robot, and how it is checked.

    ``statement(s)`` builds the claim's relations from the product's graphs: with s = 1 as claimed,
    with s = -1 with one sign or constant altered (the mutation, which the same method must refute).
    A claim without statement has its verdict given (HAND, OPEN or DEFINITION).  ``premises`` names
    the entries that it rests on.
    """

    id: str
    equations: tuple[int, ...]
    form: str
    claim: str
    meaning: str
    hypotheses: str = ""
    statement: Callable[[float], Statement] | None = None
    method: Method | None = None
    verdict: str = ""
    premises: tuple[str, ...] = ()
    theme: str = ""

    def words(self) -> dict[str, Any]:
        """What the ledger's entry says in the claim's own words."""
        return {
            "equations": self.equations,
            "form": self.form,
            "claim": self.claim,
            "meaning": self.meaning,
            "hypotheses": self.hypotheses,
            "premises": self.premises,
            "theme": self.theme,
        }
