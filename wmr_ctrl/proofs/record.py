"""Make the committed ledger and its page anew: ``python -m wmr_ctrl.proofs.record [ID ...]``.

With ids only those entries are checked; the others stay as committed.
"""

from __future__ import annotations

import sys
from pathlib import Path

from wmr_ctrl.proofs.ledger import COMMITTED, Entry, Ledger, load
from wmr_ctrl.proofs.page import page
from wmr_ctrl.proofs.runner import prove, selected

PAGE = Path(__file__).parents[2] / "docs" / "proofs.md"


def record(ledger: Ledger) -> None:
    """Save the ledger where `load` finds it, and the page in docs/."""
    ledger.save(COMMITTED)
    PAGE.write_text(page(ledger), encoding="utf-8")


def merged(new: Ledger, old: Ledger) -> Ledger:
    """Every claim's entry: the new one where there is one."""
    entries = {**old.by_id(), **new.by_id()}
    return Ledger(tuple(entries[key] for key in selected(()) if key in entries))


def _show(done: int, total: int, entry: Entry) -> None:
    sys.stderr.write(f"{done}/{total} {entry.id}: {entry.verdict}\n")


if __name__ == "__main__":
    checked = prove(sys.argv[1:], _show)
    record(merged(checked, load() if COMMITTED.exists() else Ledger(())))
