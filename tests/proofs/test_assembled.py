"""What is done to the guard where it is put together does not stay unnoticed."""

from __future__ import annotations

from dataclasses import replace

import pytest

from wmr_ctrl.control import controller
from wmr_ctrl.guard import guard
from wmr_ctrl.proofs.alterations import altered
from wmr_ctrl.proofs.claim import CLAIMED
from wmr_ctrl.proofs.claims import all_claims
from wmr_ctrl.proofs.ledger import OPEN, PROVED, REFUTED

pytest.importorskip("z3")

ENTRIES = {claim.id: claim for claim in all_claims() if claim.id.startswith("guard.assembled.")}


def bypassed(asked, *others):
    """The guard's answer with the force that was asked for in the place of the safe one."""
    return replace(guard.guarded(asked, *others), force=asked)


def unsafe_anchor(asked, v, both, coming):
    """The safe point that the wheels keep free is whatever was asked for."""
    return replace(guard.guarded(asked, v, both, coming), safe=asked)


def rounded_down(_count):
    """Nothing kept back against rounding."""
    return 0.0


def reached_about(both, phi, half_track):
    """Brakes within the wheels' reach to a rounding."""
    first, second = (b.braking for b in (both.axis(0), both.axis(1)))
    return first + second / half_track <= phi * (1 + 2.0**-44)


@pytest.mark.parametrize(
    ("key", "module", "name", "stand_in"),
    [
        ("guard.linear-first", controller, "guarded", bypassed),
        ("controller.rotation-first", controller, "guarded", bypassed),
        ("controller.linear-first-late", controller, "guarded", unsafe_anchor),
        ("guard.rotation-first-late", guard, "rounding", rounded_down),
        ("controller.linear-first", guard, "feasible", lambda _: 1),
        ("keeps.guard.linear-first", controller, "guarded", bypassed),
        ("keeps.guard.rotation-first", controller, "guarded", unsafe_anchor),
        ("keeps.controller.linear-first", guard, "within_reach", reached_about),
    ],
)
def test_what_is_exported_is_what_the_entries_speak_of(monkeypatch, key, module, name, stand_in):
    claim = ENTRIES[f"guard.assembled.{key}"]
    method = replace(claim.method, effort=1, seconds=1)  # far less than it is given, and enough
    assert method.decide(claim.statement(CLAIMED)).verdict == PROVED

    monkeypatch.setattr(module, name, stand_in)
    assert method.decide(claim.statement(CLAIMED)).verdict in (REFUTED, OPEN)


def test_a_late_monitor_that_tells_ten_times_the_push_is_refuted():
    (claim,) = (item for item in all_claims() if item.id == "guard.monitor-late")
    with altered("wmr_ctrl.guard.monitor:LateMotion.least_push", lambda push: 10 * push):
        method = replace(claim.method, effort=1, seconds=1)
        assert method.decide(claim.statement(CLAIMED)).verdict == REFUTED
