"""Make the committed ledger and its page anew: ``python -m tests.proofs.record [ID ...]``.

``--words`` checks nothing.  ``--examine`` alters the functions of entries that were not tried yet
(for named entries also those that were left open), and asks the second solvers.  ``--confirm`` asks
only these solvers, about entries that none of them has confirmed yet.

With ids only those entries are checked; the others stay as committed, with the present words of the
claims.  That is refused if an entry's graph, relations or method have changed.
"""

import argparse
import re
import sys
from dataclasses import replace
from pathlib import Path

from tests.proofs.ledger_page import page
from tests.proofs.second_solvers import confirmed_by
from wmr_ctrl.results.ledger import COMMITTED, OPEN, Ledger, load
from wmr_proofs.alterations import functions_of
from wmr_proofs.certificates import FOLDER, index, save_index, words_hash
from wmr_proofs.claim import CLAIMED
from wmr_proofs.claims import all_claims
from wmr_proofs.comparison import stale
from wmr_proofs.entry import graph_hash
from wmr_proofs.methods.spec import Z3
from wmr_proofs.noticed import tried
from wmr_proofs.runner import prove, selected

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "ledger.md"
COUNTING = (ROOT / "README.md", ROOT / "docs" / "proofs.md")
COUNT = r"\d+ of \d+ entries by z3"


def record(ledger):
    """Save the ledger where `load` finds it, the page in docs/, and the counts on other pages.

    The index of certificates gets the hashes of the present words; rows of removed entries are
    dropped.
    """
    ledger.save(COMMITTED)
    PAGE.write_text(page(ledger), "utf-8")
    for path in COUNTING:
        text = path.read_text("utf-8")
        path.write_text(re.sub(COUNT, certified(ledger), text), encoding="utf-8")
    words = {claim.id: words_hash(claim) for claim in all_claims()}
    for key in index().keys() - words.keys():
        (FOLDER / f"{key}.json.xz").unlink(missing_ok=True)
    save_index({key: row | {"claim": words[key]} for key, row in index().items() if key in words})


def certified(ledger):
    """Return the number of z3 entries with certificates, as worded on the `COUNTING` pages."""
    asked = [entry for entry in ledger.entries if re.search(r"\bZ3\b", entry.method)]
    return f"{sum(1 for entry in asked if entry.certificate)} of {len(asked)} entries by z3"


def merged(new, old):
    """Every claim's entry: the new one, else the old one.

    SystemExit if an old entry is about another claim than the program's.
    """
    entries, fresh = {**old.by_id(), **new.by_id()}, new.by_id()
    claims = {claim.id: claim for claim in all_claims()}
    known = [key for key in selected(()) if key in entries]
    kept = {key: graph_hash(claims[key]) for key in known if key not in fresh}
    others = stale(kept, Ledger(tuple(entries[key] for key in kept)))
    if others:
        raise SystemExit(f"graph, relations or method have changed; check anew: {' '.join(others)}")
    return Ledger(tuple(replace(entries[key], **claims[key].words()) for key in known))


def examined(entry, anew=False):
    """An entry with the effects of altering its functions, and with the solvers that agree.

    ``anew``: try again what was left open.
    """
    known = {key: said for key, said in entry.altered.items() if said != OPEN or not anew}
    altered = tried(claim := _claim_of(entry), functions_of(claim), known)
    found = replace(entry, altered=altered)
    sys.stderr.write(f"{entry.id}: {found.alterations}\n")
    return confirmed(found)


def confirmed(entry):
    """Return an entry with the other solvers that agree, if none has confirmed it yet.

    No solver runs if all obligations have certificates.
    """
    claim = _claim_of(entry)
    if (
        entry.certificate
        or entry.confirmed_by
        or not claim.statement
        or not isinstance(claim.method, Z3)
    ):
        return entry
    agree = confirmed_by(claim.statement(CLAIMED), entry.satisfied_at)
    sys.stderr.write(f"{entry.id}: confirmed by {', '.join(agree) or 'no other'}\n")
    return replace(entry, confirmed_by=agree)


def _claim_of(entry):
    return next(claim for claim in all_claims() if claim.id == entry.id)


def _backed(asked):
    known = load().by_id()
    wanted = (known[key] for key in selected(asked) if key in known)
    return [entry for entry in wanted if entry.verdict in ("PROVED", "LEMMA")]


def main(arguments=None):
    """Check the requested entries, and record them."""

    def show(share, entry):
        sys.stderr.write(f"{100 * share:.0f} % {entry.id}: {entry.verdict}\n")

    parser = argparse.ArgumentParser(prog="python -m tests.proofs.record", description=__doc__)
    parser.add_argument("ids", nargs="*", metavar="ID", help="entries, or globs of them; none: all")
    only = parser.add_mutually_exclusive_group()
    only.add_argument("--words", action="store_true", help="check nothing, renew the words")
    only.add_argument("--examine", action="store_true", help="alter the functions of entries")
    only.add_argument("--confirm", action="store_true", help="ask the second solvers")
    given = parser.parse_args(arguments)
    if given.words:
        checked = Ledger(())
    elif given.examine:
        named, wanted = bool(given.ids), {"", OPEN} if given.ids else {""}
        entries = (e for e in _backed(given.ids) if wanted & set(e.altered.values()))
        checked = Ledger(tuple(examined(entry, named) for entry in entries))
    elif given.confirm:
        checked = Ledger(tuple(map(confirmed, _backed(given.ids))))
    else:
        checked = prove(given.ids, show)
    record(merged(checked, load() if COMMITTED.exists() else Ledger(())))


if __name__ == "__main__":
    main()
