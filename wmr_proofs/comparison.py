"""Comparison of the verdicts of a run of `prove` with the committed ledger."""

from collections.abc import Mapping
from dataclasses import dataclass

from wmr_ctrl.results.ledger import UNCHECKED, Entry, Ledger


@dataclass(frozen=True)
class Difference:
    """An entry whose verdict differs from the committed one."""

    id: str
    committed: str
    now: str


def differences(ledger: Ledger, committed: Ledger, complete: bool = True) -> list[Difference]:
    """Verdicts that differ; with ``complete``, also entries that only one of both has."""
    known, found = committed.by_id(), ledger.by_id()
    ids = [*known, *(i for i in found if i not in known)] if complete else list(found)
    pairs = ((i, _verdict(known, i), _verdict(found, i)) for i in ids)
    return [Difference(i, old, new) for i, old, new in pairs if old != new]


def stale(hashes: Mapping[str, str], committed: Ledger) -> list[str]:
    """Ids whose hash differs from that of the committed verdict."""
    known = ((entry.id, entry.graph_hash) for entry in committed.entries if entry.graph_hash)
    return [key for key, hashed in known if hashes.get(key, hashed) != hashed]


def exit_code(ledger: Ledger, committed: Ledger, complete: bool = True) -> int:
    """0 as committed; 1 if a verdict differs; 3 if entries could not be checked."""
    changed = [d for d in differences(ledger, committed, complete) if d.now != "NOT_CHECKED"]
    if changed:
        return 1
    return UNCHECKED if any(entry.verdict == "NOT_CHECKED" for entry in ledger.entries) else 0


def _verdict(entries: Mapping[str, Entry], key: str) -> str:
    return entries[key].verdict if key in entries else "(no entry)"
