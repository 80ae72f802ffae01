"""Claims about the guard, the wheel maps and the sampled-data law, checked on their graphs."""

from __future__ import annotations

import pytest

from wmr_ctrl.proofs.check import check
from wmr_ctrl.proofs.claim import Claim
from wmr_ctrl.proofs.claims import guard, prox, resolvent, wheel_maps

pytest.importorskip("z3")
pytest.importorskip("flint")

CLAIMS = [c for module in (guard, wheel_maps, resolvent, prox) for c in module.CLAIMS]
REFUTED = {"guard.too-fast", "wheels.per-wheel"}


@pytest.mark.parametrize("claim", CLAIMS, ids=[claim.id for claim in CLAIMS])
def test_verdict(claim: Claim) -> None:
    entry = check(claim)

    if claim.statement is None:
        assert entry.verdict == "HAND"
    elif claim.id in REFUTED:
        assert entry.verdict == "REFUTED"
        assert entry.counterexample
    else:
        assert entry.verdict == "PROVED"
        assert entry.mutation_refuted


def test_what_a_claim_rests_on_exists() -> None:
    known = {claim.id for claim in CLAIMS} | {"eq75"}

    assert len({claim.id for claim in CLAIMS}) == len(CLAIMS)
    assert all(name in known for claim in CLAIMS for name in claim.uses)
