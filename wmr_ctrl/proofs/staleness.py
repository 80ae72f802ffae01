"""Whether the committed ledger still speaks of the graphs that the program has."""

from __future__ import annotations

from wmr_ctrl.proofs.ledger import load, stale


def stale_entries() -> list[str] | None:
    """Ids whose graph has changed since the ledger was committed; None without the extras."""
    try:
        from wmr_ctrl.proofs.runner import hashes

        return stale(hashes(), load())
    except ImportError:
        return None
