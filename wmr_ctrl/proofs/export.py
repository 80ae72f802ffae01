"""Obligations of the z3 entries as SMT-LIB 2 files, for whoever trusts another solver more."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from wmr_ctrl.proofs.claim import CLAIMED
from wmr_ctrl.proofs.claims import all_claims
from wmr_ctrl.proofs.methods.second import obligations, uses_z3

README = """\
# Obligations of the ledger's z3 entries

One folder per entry, one file per query, in SMT-LIB 2 (logic QF_NRA: real numbers, no quantifiers).
Division by 0 means an arbitrary number, as the standard has it; that it is never read is what the
files `domain-*.smt2` ask.

| file | the claim needs |
|---|---|
| `goal-N.smt2` | `unsat`: hypotheses and the negated goal contradict each other |
| `domain-N.smt2` | `unsat`: no denominator is 0, no root or logarithm outside its domain |
| `hypotheses.smt2` | `sat`: the hypotheses can be met |

With any solver that reads SMT-LIB 2, for instance

    cvc5 --tlimit=60000 guard.upper/goal-1.smt2
    cvc5 --tlimit=60000 --nl-cov --nl-ext=none guard.upper/goal-1.smt2
    z3 -T:60 guard.upper/goal-1.smt2

Symbols named `sin of N`, `log of N` and so on stand for that function of the N-th argument; of
them only what is asserted in the file is known. What the symbols of a file mean is in the claim:
`wmr-ctrl prove --only guard.upper`.
"""


def export(folder: Path, ids: Iterable[str]) -> int:
    """Write the files of these entries under ``folder``; the number of obligations.

    OSError where a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "README.md").write_text(README, encoding="utf-8")
    wanted, count = set(ids), 0
    for claim in all_claims():
        if claim.id not in wanted or claim.statement is None or not uses_z3(claim.method):
            continue
        place = folder / claim.id
        place.mkdir(exist_ok=True)
        for item in obligations(claim.statement(CLAIMED)):
            text = f"; {claim.id}, {item.name}: {item.wanted} is needed\n{item.text}"
            (place / f"{item.name}.smt2").write_text(text, encoding="utf-8")
            count += 1
    return count
