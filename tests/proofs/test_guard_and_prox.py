"""Claims that are not in the paper: guard, wheels, sampled-data law, the barrier's limits."""

import pytest

from wmr_ctrl.results.ledger import load
from wmr_proofs.claim import PRINTED
from wmr_proofs.claims import all_claims

pytest.importorskip("z3")
pytest.importorskip("flint")

KINDS = ("gain", "guard", "wheels", "world", "transport", "prox", "smooth", "prediction")
CLAIMS = {c.id: c for c in all_claims() if c.id.startswith(KINDS) and c.form != PRINTED}
LATE = {"guard.delay.longer", "guard.delay.uncapped"}
REFUTED = {"guard.too-fast", "wheels.per-wheel", "guard.late.half", *LATE}
KNOWN = load().by_id()


def test_committed_verdicts_are_those_that_are_due():
    for key, claim in CLAIMS.items():
        assert_as_due(claim, KNOWN[key])


def assert_as_due(claim, entry):
    if claim.statement is None:
        assert entry.verdict == "HAND"
    elif claim.id in REFUTED:
        assert entry.verdict == "REFUTED"
        assert entry.counterexample
    else:
        assert entry.verdict == ("PROVED" if entry.altered else "LEMMA")
        assert entry.mutation_refuted


def test_what_a_claim_rests_on_exists():
    known = {claim.id for claim in all_claims()}

    assert all(name in known for claim in all_claims() for name in claim.premises)
