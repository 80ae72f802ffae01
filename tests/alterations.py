"""Alter the product, one function at a time, and report whether the ledger notices.

``python -m tests.alterations [WORD ...]`` alters each function that a PROVED entry names (only
those whose name contains one of the words).  Its result is scaled or negated for every caller, and
the entries that name it are checked, the quickest first, until one is no longer PROVED. Then come
the alterations of single signs and constants in the source (`tests.proofs.test_alterations`), and
those of world, emitter, C runtime and checks, which tests must notice (`tests.altered_files`).  A
word such as ``fmu/`` or ``world/`` selects only alterations of files whose path contains it.
Prints one line each; the exit code is 1 if one survives that is not known to change nothing.
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
from wmr_ctrl.results.ledger import load
from wmr_proofs.claims import all_claims
from wmr_proofs.noticed import CHANGES

WITNESSES = 20
"""Entries that are asked about one alteration."""
TRIED = ("* 9/8", "* -1")
ANY_SCALE = "changes nothing: A(q)' q' = 0 says the same for any multiple of A"
FLAG = "changes nothing: a flag is read as 0 or not 0"
EQUIVALENT = {
    ("wmr_proofs.paper_functions:constraint", "* 9/8"): ANY_SCALE,
    ("wmr_proofs.paper_functions:constraint", "* -1"): ANY_SCALE,
    ("wmr_proofs.paper_functions:conditions", "* 9/8"): FLAG,
    ("wmr_ctrl.control.guard.guard:feasible", "* 9/8"): FLAG,
    ("wmr_proofs.paper_barrier:h", "* 9/8"): FLAG,
    ("wmr_proofs.paper_barrier:h", "* -1"): FLAG,
}
"""(function, change) of alterations that nothing could notice, with the reason."""


@dataclass(frozen=True)
class Outcome:
    """One alteration, and the entry that noticed it; empty if none did."""

    what: str
    change: str
    noticed_by: str

    @property
    def survived(self):
        """True if nothing noticed the alteration, although something should have."""
        return not self.noticed_by and (self.what, self.change) not in EQUIVALENT


def naming():
    """PROVED entries by the functions that they name, the quickest first."""
    found = {}
    for entry in sorted(load().entries, key=lambda entry: entry.seconds):
        for name in entry.functions if entry.verdict == "PROVED" else ():
            found.setdefault(name, []).append(entry)
    return found


def of_graphs(words):
    """Alterations of functions' results."""
    claims = {claim.id: claim for claim in all_claims()}
    for name, entries in naming().items():
        if words and not any(word in name for word in words):
            continue
        for change in TRIED:
            asked = (claims[entry.id] for entry in entries[:WITNESSES])
            first = next((c.id for c in asked if is_noticed(c, name, CHANGES[change])), "")
            yield Outcome(name, change, first)


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
        noticed = outcome.noticed_by or EQUIVALENT.get((outcome.what, outcome.change), "SURVIVED")
        change = " ".join(outcome.change.split())
        sys.stdout.write(f"{outcome.what} [{change}]: {noticed}\n")
        sys.stdout.flush()
    survivors = [outcome for outcome in outcomes if outcome.survived]
    sys.stdout.write(f"{len(outcomes)} alterations, {len(survivors)} survived\n")
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
