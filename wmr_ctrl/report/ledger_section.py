"""What the report shows of the committed proof ledger."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from wmr_ctrl.proofs.ledger import load


def ledger_section(stale: Sequence[str] | None) -> dict[str, Any]:
    """Counts, refuted entries, and those that no program closed.

    ``stale`` are ids whose graph has changed since; None where that was not compared.
    """
    ledger = load()
    return {
        "tally": list(ledger.tally().items()),
        "refuted": [entry for entry in ledger.entries if entry.verdict == "REFUTED"],
        "unproved": [entry for entry in ledger.entries if entry.verdict in ("HAND", "OPEN")],
        "stale": stale,
    }
