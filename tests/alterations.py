"""Alter the product, one place at a time, and report whether the ledger or a test notices.

``python -m tests.alterations [WORD ...]`` alters the result of each function that a PROVED entry
names (only those whose name contains one of the words): for every caller it is scaled, negated or
moved, in turn, until an entry that names the function is no longer PROVED.  One change alone would
not do: a bound that is larger than it must be is still a bound, and a multiple of zero is zero.
Then come the alterations of single signs and constants in the source
(`tests.proofs.test_alterations`), and those of world, emitter, C runtime and checks, which tests
must notice (`tests.altered_files`).  A word such as ``fmu/`` or ``world/`` selects only
alterations of files whose path contains it.
Prints one line each; the exit code is 1 if one survives.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from tests.altered_files import ALTERED_FILES, altered_copy, check_tests, copy_of_tree, failing
from tests.proofs.noticing import is_noticed
from tests.proofs.test_alterations import ALTERATIONS, changes_a_verdict
from wmr_ctrl.results.ledger import PROVED, REFUTED, load
from wmr_proofs.claims import all_claims
from wmr_proofs.noticed import CHANGES

WITNESSES = 20
"""Entries that are asked about one function."""


@dataclass(frozen=True)
class Outcome:
    """One alteration, and the entry that noticed it; empty if none did."""

    what: str
    change: str
    noticed_by: str


def naming():
    """PROVED entries by functions they name: first those that noticed it before, then by time."""
    found = {}
    for entry in sorted(load().entries, key=lambda entry: entry.seconds):
        for name in entry.functions if entry.verdict == PROVED else ():
            found.setdefault(name, []).append(entry)
    for name, entries in found.items():
        entries.sort(key=lambda entry: entry.altered.get(name) != REFUTED)
    return found


def of_graphs(words):
    """Alterations of functions' results."""
    claims = {claim.id: claim for claim in all_claims()}
    for name, entries in naming().items():
        if not words or any(word in name for word in words):
            asked = [(claims[e.id], change) for e in entries[:WITNESSES] for change in CHANGES]
            yield next(
                (Outcome(name, change, claim.id) for claim, change in asked
                 if is_noticed(claim, name, CHANGES[change])),
                Outcome(name, " or ".join(CHANGES), ""),
            )  # fmt: skip


def of_source(words):
    """Alterations of single signs and constants."""
    for function, old, new, ids in ALTERATIONS:
        name = f"{function.__module__}:{function.__qualname__}"
        if not words or any(word in name for word in words):
            yield Outcome(name, f"{old} -> {new}", changes_a_verdict(function, old, new, ids))


def of_files(words):
    """Alterations of files, on a copy of the tree."""
    wanted = [a for a in ALTERED_FILES if not words or any(word in a.path for word in words)]
    if not wanted:
        return
    with tempfile.TemporaryDirectory(prefix="altered") as folder:
        base = copy_of_tree(Path(folder))
        check_tests(base, wanted)
        for item in wanted:
            with altered_copy(base, item):
                yield Outcome(item.path, f"{item.old} -> {item.new}", failing(base, item.tests))


def main(words):
    """Print every outcome and their number; return 1 if one survived."""
    outcomes = []
    for outcome in chain(of_graphs(words), of_source(words), of_files(words)):
        outcomes.append(outcome)
        noticed = outcome.noticed_by or "SURVIVED"
        change = " ".join(outcome.change.split())
        sys.stdout.write(f"{outcome.what} [{change}]: {noticed}\n")
        sys.stdout.flush()
    survivors = [outcome for outcome in outcomes if not outcome.noticed_by]
    sys.stdout.write(f"{len(outcomes)} alterations, {len(survivors)} survived\n")
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
