"""Claims that the paper does not have: guard, wheels, sampled-data law, the barrier's limits."""

from __future__ import annotations

import pytest

from wmr_ctrl.proofs.check import check
from wmr_ctrl.proofs.claim import Claim
from wmr_ctrl.proofs.claims import (
    all_claims,
    composition,
    gain,
    guard,
    guard_delay,
    newton,
    prox,
    resolvent,
    smooth,
    wheel_maps,
)

pytest.importorskip("z3")
pytest.importorskip("flint")

MODULES = (gain, guard, guard_delay, wheel_maps, resolvent, prox, newton, smooth, composition)
CLAIMS = [c for module in MODULES for c in module.CLAIMS]
LATE = {"guard.delay.longer", "guard.delay.ignored", "guard.delay.uncapped"}
REFUTED = {"guard.too-fast", "wheels.per-wheel", *LATE}


@pytest.mark.parametrize("claim", CLAIMS, ids=[claim.id for claim in CLAIMS])
def test_verdict(claim: Claim) -> None:
    entry = check(claim)

    if claim.statement is None:
        assert entry.verdict == "HAND"
    elif claim.id in REFUTED:
        assert entry.verdict == "REFUTED"
        assert entry.counterexample
    else:
        assert entry.verdict == ("PROVED" if entry.functions else "LEMMA")
        assert entry.mutation_refuted


def test_what_a_claim_rests_on_exists() -> None:
    known = {claim.id for claim in all_claims()}

    assert len({claim.id for claim in CLAIMS}) == len(CLAIMS)
    assert all(name in known for claim in CLAIMS for name in claim.premises)
