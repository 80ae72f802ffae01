"""Make the committed ledger and its page anew: ``python -m wmr_ctrl.proofs.record`` in the tree."""

from __future__ import annotations

import sys
from pathlib import Path

from wmr_ctrl.proofs.ledger import COMMITTED, Entry, Ledger
from wmr_ctrl.proofs.page import page
from wmr_ctrl.proofs.runner import prove

PAGE = Path(__file__).parents[2] / "docs" / "proofs.md"


def record(ledger: Ledger) -> None:
    """Save the ledger where `load` finds it, and the page in docs/."""
    ledger.save(COMMITTED)
    PAGE.write_text(page(ledger), encoding="utf-8")


def _show(done: int, total: int, entry: Entry) -> None:
    print(f"{done}/{total} {entry.id}: {entry.verdict}", file=sys.stderr)


if __name__ == "__main__":
    record(prove(progress=_show))
