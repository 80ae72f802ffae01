"""Operations that CasADi cancels are defined wherever the hypotheses of an entry hold."""

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import casadi as ca
import pytest

from wmr_ctrl.results.ledger import LEMMA, OPEN, PROVED, load
from wmr_proofs.cancelled import cancelled_operations, positive_sums, uncancelled, undefined
from wmr_proofs.claim import CLAIMED, Claims
from wmr_proofs.claims import all_claims
from wmr_proofs.entry import check
from wmr_proofs.methods.spec import Z3, Ball, Ring
from wmr_proofs.regions import POSITIVE, Case
from wmr_proofs.statement import Statement, above, at_least, equal, symbols

pytest.importorskip("z3")

BACKED = {entry.id for entry in load().entries if entry.verdict in (PROVED, LEMMA)}
PROVED_CLAIMS = [claim for claim in all_claims() if claim.statement and claim.id in BACKED]
BOX = Ball(box={"x": (Fraction(-1), Fraction(1)), "y": (Fraction(1), Fraction(2))})
SHIFTED = Ball(box={"x": (Fraction(2), Fraction(3)), "y": (Fraction(0), Fraction(1))})
ALL, BEYOND = Case("all"), Case("x > y > 0", {"a": POSITIVE, "b": POSITIVE},
                                lambda n: {"x": n["a"] + n["b"], "y": n["b"]})  # fmt: skip


def claim_of(statement, method, **values):
    """The claim of this statement."""
    claims = Claims(by=method)
    claims("own.cancelled", **values)(statement)
    return claims.listed[0]


def ones(x, y):
    """1 wherever x is not 0; CasADi makes it 1 everywhere."""
    return x * (1 / x) + 0 * y


def differences(x, y):
    return (x - y) / (x - y)


def roots(x, y):
    """1 wherever x is at least y."""
    return 1 + 0 * ca.sqrt(x - y)


def logarithms(x, y):
    return 1 + ca.log(x) - ca.log(x) + 0 * y


def told(term, given=lambda _x, _y: ()):
    """The statement that the term is 1 where x^2 + y^2 is at least 0."""

    def statement(mutation):
        t = symbols("x y")
        hypotheses = given(t["x"], t["y"])
        both = at_least(t["x"] ** 2 + t["y"] ** 2)
        return Statement(t, (equal(term(t["x"], t["y"]), mutation(1, 2)), both), hypotheses)

    return statement


def ahead(x, y):
    return above(x, y), above(y)


ANYWHERE = Z3(), Ring((ALL,)), BOX
HERE = Z3(), Ring((BEYOND,)), SHIFTED


@pytest.mark.parametrize("term", [ones, differences, roots, logarithms])
@pytest.mark.parametrize("method", [*ANYWHERE, *HERE])
def test_what_is_cancelled_is_found(term, method):
    defined = method in HERE[1:]
    claim = claim_of(told(term), method)
    assert method.decide(claim.statement(CLAIMED)).verdict == PROVED

    number, left = undefined(claim)
    assert number == 1
    assert (not left) == defined
    assert undefined(claim_of(told(term, ahead), Z3())) == (1, "")


def test_the_derivative_of_a_power_reads_no_logarithm():
    def slope(mutation):
        t = symbols("x")
        derivative = ca.jtimes(t["x"] ** 2, t["x"], 1)
        return Statement(t, (equal(derivative, mutation(2, 3) * t["x"]),))

    claim = claim_of(slope, Z3())
    assert "log" in {node.op for node in uncancelled(claim).graph.nodes}
    assert undefined(claim) == (0, "")


@dataclass(frozen=True)
class Kept:
    """An object that caches its result."""

    @cached_property
    def symbols(self):
        return symbols("x y")

    @cached_property
    def term(self):
        return ones(*self.symbols.values())


@pytest.mark.parametrize("values", [{"a": Kept()}, {"each": {"one": {"a": Kept()}}}])
def test_what_an_object_has_kept_is_built_anew(values):
    def statement(mutation, a):
        return Statement(a.symbols, (at_least(a.term, mutation(1, 2)),))

    claim = claim_of(statement, Z3(), **values)
    assert Z3().decide(claim.statement(CLAIMED)).verdict == PROVED
    number, left = undefined(claim)
    assert (number, bool(left)) == (1, True)


def test_sums_are_positive_in_every_region():
    assert {"x": 1, "y": -1} in positive_sums((BEYOND,))
    assert {"x": 1, "y": -1} not in positive_sums((BEYOND, ALL))
    turned = Case("y > x > 0", BEYOND.numbers, lambda n: {"y": n["a"] + n["b"], "x": n["b"]})
    assert positive_sums((BEYOND, turned)) == ({"x": 1}, {"y": 1})


@pytest.mark.slow
def test_as_much_is_cancelled_as_was_shown_to_be_defined():
    """The recorded numbers of cancelled operations are found again, for every fifth function.

    A changed graph is examined again for points where it is undefined.
    """
    known, asked = load().by_id(), {}
    for claim in PROVED_CLAIMS:
        inner = getattr(claim.statement, "func", claim.statement)
        asked[getattr(inner, "function", inner)] = claim
    some = sorted(asked.values(), key=lambda claim: claim.id)[::5]
    counts = {claim.id: len(cancelled_operations(claim)[1]) for claim in some}

    assert len(counts) > 50
    assert counts == {key: known[key].cancelled for key in counts}


@pytest.mark.slow
@pytest.mark.parametrize("theme", ["Position errors", "The barrier function"])
def test_what_an_entry_cancels_is_defined(theme):
    asked = [claim for claim in PROVED_CLAIMS if claim.theme == theme]
    found = {claim.id: undefined(claim) for claim in asked}

    assert found
    assert {key: left for key, (_, left) in found.items() if left} == {}
    known = load().by_id()
    assert {key: known[key].cancelled for key in found} == {k: n for k, (n, _) in found.items()}


def test_what_may_be_undefined_is_not_proved():
    assert check(claim_of(told(ones, ahead), Z3())).cancelled == 1
    held_back = check(claim_of(told(ones), Z3()))
    assert (held_back.verdict, held_back.cancelled) == (OPEN, None)
    assert "may be undefined" in held_back.evidence["held back"]
