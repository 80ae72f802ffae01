"""`wmr_proofs.check` accepts the certificates that `wmr_proofs.find` finds."""

from fractions import Fraction

import pytest

from wmr_proofs.check import check
from wmr_proofs.find import NotFound, _factors, point, proof

HEAD = "(set-logic QF_NRA)\n(declare-fun |x| () Real)\n(declare-fun |y| () Real)\n"
LARGER = "(assert (< (ite (<= |x| |y|) |y| |x|) |x|))"
"""max(x, y) < x."""
QUOTIENT = "(assert (> |x| 0.0))\n(assert (< (* (/ |y| |x|) |x|) |y|))"
SQUARE = "(assert (< (+ (* |x| |x|) (* |y| |y|)) (* 2.0 (* |x| |y|))))"


def text(*assertions):
    return HEAD + "\n".join([*assertions, "(check-sat)", ""])


@pytest.mark.parametrize("wrong", [LARGER, QUOTIENT, SQUARE], ids=["choice", "quotient", "square"])
def test_certificates_of_contradictions_are_accepted(wrong):
    assert check(text(wrong), {"proof": proof(text(wrong))}) == "unsat"


def test_nothing_is_found_where_the_assertions_can_be_met():
    met = text("(assert (< (* |x| |x|) |y|))", "(assert (> |x| 2.0))")

    with pytest.raises(NotFound):
        proof(met, 2.0)
    assert check(met, {"point": point(met, {"x": "5/2"})}) == "sat"
    assert point(met, {"x": "5/2"})["|x|"] == "5/2"


def test_a_number_has_no_factors():
    assert _factors({(): Fraction(3)}) == _factors({}) == []
