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
    guard_lateness,
    guard_latest_motion,
    guard_varying,
    guard_varying_motion,
    newton,
    prox,
    prox_mass,
    prox_push,
    resolvent,
    smooth,
    transport,
    wheel_maps,
)
from wmr_ctrl.proofs.ledger import Entry, load

pytest.importorskip("z3")
pytest.importorskip("flint")

MODULES = (
    gain,
    guard,
    guard_delay,
    guard_lateness,
    guard_latest_motion,
    guard_varying,
    guard_varying_motion,
    wheel_maps,
    resolvent,
    transport,
    prox,
    prox_mass,
    prox_push,
    newton,
    smooth,
    composition,
)
CLAIMS = [c for module in MODULES for c in module.claim.listed]
LATE = {"guard.delay.longer", "guard.delay.ignored", "guard.delay.uncapped"}
LATEST = {"guard.late.half", "guard.late.unmixed", "guard.varying.unvaried"}
REFUTED = {"guard.too-fast", "wheels.per-wheel", *LATE, *LATEST}
VARYING = {f"guard.varying.{name}" for name in ("left", "graceful", "steady.graceful")}
VARYING |= {f"guard.varying.{name}counts" for name in ("", "steady.")}
SLOW = {"gain.ceiling", "guard.late.graceful", "prox.linear-smooth", "smooth.quotient", *VARYING}
KNOWN = load().by_id()


SAMPLE = [claim for claim in CLAIMS[::6] if claim.id not in SLOW]


@pytest.mark.parametrize("claim", SAMPLE, ids=[claim.id for claim in SAMPLE])
def test_verdict(claim: Claim) -> None:
    """One in six; test_claims.py proves all of them anew, and finds what is committed.

    The committed functions are tried first, which is faster.
    """
    assert_as_due(claim, check(claim, KNOWN.get(claim.id)))


def test_committed_verdicts_are_those_that_are_due() -> None:
    for claim in CLAIMS:
        assert_as_due(claim, KNOWN[claim.id])


def assert_as_due(claim: Claim, entry: Entry) -> None:
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
