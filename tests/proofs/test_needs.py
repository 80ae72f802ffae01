"""When an alteration of a function counts as noticed."""

from dataclasses import replace

import casadi as ca
import pytest

from tests.proofs import noticing
from wmr_proofs import noticed
from wmr_proofs.claims import all_claims
from wmr_proofs.methods.spec import Z3
from wmr_proofs.relation import at_least
from wmr_proofs.statement import Statement
from wmr_proofs.symbols import symbols

CLAIM = next(claim for claim in all_claims() if claim.id == "guard.anchor")


def least(extra):
    t = symbols("x")
    return Statement(t, (at_least(ca.fabs(t["x"]) + extra),))


@pytest.mark.parametrize("extra, fails", [(0, False), (-1, True)])
def test_a_refuted_statement_fails_and_a_proved_one_does_not(extra, fails):
    assert noticing.fails(CLAIM, least(extra)) is fails


def test_an_open_end_counts_only_if_the_claim_itself_needs_no_more_patience(monkeypatch):
    hard = Statement(symbols("x"), (at_least(ca.exp(ca.SX.sym("y"))),))
    patient, quick = Z3(effort=77), Z3(effort=1)
    answers = {patient.effort: "PROVED", quick.effort: "OPEN"}
    monkeypatch.setattr(noticed, "short_budget", lambda method: quick)
    monkeypatch.setattr(noticed, "verdict_of", lambda method, _: answers[method.effort])
    claim = replace(CLAIM, method=patient)

    monkeypatch.setattr(noticed, "proves_quickly", lambda key: False)
    assert not noticing.fails(claim, hard)

    monkeypatch.setattr(noticed, "proves_quickly", lambda key: True)
    assert noticing.fails(claim, hard)
