"""Finding: what a method found out about one statement."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

PROVED, REFUTED, LEMMA, OPEN = "PROVED", "REFUTED", "LEMMA", "OPEN"
DEFINITION, HAND, NOT_CHECKED = "DEFINITION", "HAND", "NOT_CHECKED"


@dataclass(frozen=True)
class Finding:
    """Verdict (PROVED, REFUTED or OPEN), what was counted on the way, and an exact point.

    The point violates the statement where it is refuted, and satisfies its hypotheses where it is
    proved (so that they are not empty).
    """

    verdict: str
    evidence: Mapping[str, Any] = field(default_factory=dict)
    point: Mapping[str, Fraction] | None = None


def written(point: Mapping[str, Any]) -> dict[str, str]:
    """A point as exact text: ``p/q``, or ``1 pi``."""
    return {name: v if isinstance(v, str) else str(Fraction(v)) for name, v in point.items()}
