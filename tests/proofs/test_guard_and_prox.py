"""Claims that the paper does not have: guard, wheels, sampled-data law, the barrier's limits."""

from __future__ import annotations

import pytest

from wmr_ctrl.results.ledger import Entry, load
from wmr_proofs.check import check
from wmr_proofs.claim import PRINTED, Claim
from wmr_proofs.claims import all_claims

pytest.importorskip("z3")
pytest.importorskip("flint")

KINDS = ("gain", "guard", "wheels", "world", "transport", "prox", "smooth", "prediction")
CLAIMS = {c.id: c for c in all_claims() if c.id.startswith(KINDS) and c.form != PRINTED}
LATE = {"guard.delay.longer", "guard.delay.ignored", "guard.delay.uncapped"}
LATEST = {"guard.late.half", "guard.late.unmixed", "guard.varying.unvaried"}
REFUTED = {"guard.too-fast", "wheels.per-wheel", *LATE, *LATEST}
KNOWN = load().by_id()
SAMPLE = (
    "gain.none guard.too-fast guard.graceful guard.delay.room guard.late.tail guard.late.half "
    "guard.varying.moved guard.rounding.single wheels.reach world.push prox.margin-smooth "
    "prox.newton-angular transport.root smooth.convex"
)
"""Quick ones of each kind and method; test_claims.py proves all, the slow test of it."""


@pytest.mark.parametrize("key", SAMPLE.split())
def test_verdict(key: str) -> None:
    """The committed functions are tried first, which is faster."""
    assert_as_due(CLAIMS[key], check(CLAIMS[key], KNOWN[key]))


def test_committed_verdicts_are_those_that_are_due() -> None:
    for key, claim in CLAIMS.items():
        assert_as_due(claim, KNOWN[key])


def assert_as_due(claim: Claim, entry: Entry) -> None:
    if claim.statement is None:
        assert entry.verdict == "HAND"
    elif claim.id in REFUTED:
        assert entry.verdict == "REFUTED"
        assert entry.counterexample
    else:
        assert entry.verdict == ("PROVED" if entry.altered else "LEMMA")
        assert entry.mutation_refuted


def test_what_a_claim_rests_on_exists() -> None:
    known = {claim.id for claim in all_claims()}

    assert all(name in known for claim in all_claims() for name in claim.premises)
