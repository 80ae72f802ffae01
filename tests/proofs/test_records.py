"""Contents of a record, and the parts that `prove` reuses."""

from dataclasses import replace
from fractions import Fraction
from functools import partial

import pytest

from tests.proofs import record
from wmr_ctrl.results.ledger import LEMMA, OPEN, PROVED, REFUTED, Entry, Ledger, load
from wmr_proofs import noticed
from wmr_proofs.claim import Claims
from wmr_proofs.claims import all_claims
from wmr_proofs.entry import check, graph_hash
from wmr_proofs.methods.spec import Z3, Ball, Ring
from wmr_proofs.regions import NONNEGATIVE, POSITIVE, Case
from wmr_proofs.runner import provenance
from wmr_proofs.statement import Statement, above, at_least, symbols

CLAIMED = {claim.id: claim for claim in all_claims()}


def written(mutation, strict=False):
    """x^2 + 1 >= 1 where x >= 0: no function of the product is called."""
    t = symbols("x")
    relation = above if strict else at_least
    return Statement(t, (at_least(t["x"] ** 2 + mutation(1, -1), 1),), (relation(t["x"]),))


PLAIN = Z3()
ENTRY = Entry("own", (), "claim", "ours", PROVED)


def claim_of(statement, method=PLAIN):
    """The claim of this statement."""
    claims = Claims(by=method)
    claims("own.square")(statement)
    return claims.listed[0]


def turned(mutation):
    """Return the written statement with its hypothesis moved to the goals."""
    statement = written(mutation)
    return replace(statement, goals=(statement.goals, statement.given), given=())


@pytest.mark.parametrize("other", [turned, partial(written, strict=True)])
def test_the_hash_holds_relations_hypotheses_and_the_altered_claim(other):
    assert graph_hash(claim_of(written)) == graph_hash(claim_of(written))
    assert graph_hash(claim_of(other)) != graph_hash(claim_of(written))


BOX = Ball(box={"x": (Fraction(0), Fraction(1))})
CHART = Case("all", {"n": POSITIVE}, lambda n: {"x": n["n"]})


@pytest.mark.parametrize(
    "one, other",
    [
        (Z3(), Ring()),
        (BOX, replace(BOX, box={"x": (Fraction(0), Fraction(2))})),
        (Ring((CHART,)), Ring((CHART, CHART))),
        (Ring((CHART,)), Ring((replace(CHART, numbers={"n": NONNEGATIVE}),))),
        (Ring((CHART,)), Ring((replace(CHART, values=lambda n: {"x": 2 * n["n"]}),))),
        (Ring((CHART,)), Ring((CHART,), log_lemma=True)),
    ],
)
def test_the_hash_holds_the_method_its_boxes_and_regions(one, other):
    assert graph_hash(claim_of(written, one)) == graph_hash(claim_of(written, replace(one)))
    assert graph_hash(claim_of(written, one)) != graph_hash(claim_of(written, other))


def test_which_engine_is_asked_first_does_not_matter():
    assert graph_hash(claim_of(written, Z3(first=("cases",)))) == graph_hash(claim_of(written))


def test_what_calls_no_function_is_a_lemma_whatever_the_record_says():
    claim = claim_of(written)
    found = check(claim)
    forged = replace(found, verdict=PROVED, altered={"wmr_ctrl.control.guard.guard:floor": REFUTED})

    assert found.verdict == LEMMA
    assert check(claim, forged).verdict == LEMMA
    assert check(claim, forged).altered == {}


KNOWN = {"wmr_ctrl.control.guard.delay:in_flight": REFUTED}


@pytest.fixture(scope="module")
def known():
    """A present entry with the words that a record would contain."""
    found = check(CLAIMED["guard.delay.rounding.scaled"])
    return replace(found, altered=KNOWN, confirmed_by=("cvc5",), cancelled=7)


@pytest.mark.parametrize(
    "change, confirmed, altered",
    [
        ({}, ("cvc5",), KNOWN),
        ({"graph_hash": "00"}, (), dict.fromkeys(KNOWN, "")),
        ({"versions": {"z3": "0.0", "flint": "0.0"}}, (), dict.fromkeys(KNOWN, "")),
        ({"altered": {}}, ("cvc5",), dict.fromkeys(KNOWN, "")),
    ],
)
def test_only_of_the_same_claim_something_is_taken(known, change, confirmed, altered):
    found = check(CLAIMED["guard.delay.rounding.scaled"], replace(known, **change))

    assert (found.confirmed_by, found.altered) == (confirmed, altered)
    assert found.cancelled == (7 if confirmed else 0)
    assert found.functions == (tuple(KNOWN) if altered == KNOWN else ())
    assert found.verdict == PROVED


def test_what_z3_showed_defined_is_asked_again_of_another_z3():
    """The claim's own method is the ring, which does not depend on z3."""
    known = load().by_id()["eq04.plant"]
    forged = replace(known, cancelled=7)
    older = replace(forged, versions={**known.versions, "z3": "0.0"})

    assert check(CLAIMED["eq04.plant"], forged).cancelled == 7
    found = check(CLAIMED["eq04.plant"], older)
    assert (found.cancelled, found.versions) == (known.cancelled, known.versions)
    assert found.confirmed_by == known.confirmed_by


def test_what_was_taken_is_said():
    entry = replace(check(claim_of(written)), altered=KNOWN, confirmed_by=("cvc5",))
    given, none = load().by_id()["lemma.integration"], Ledger(())
    now = Ledger((entry, given))

    said = provenance(now, now, examine=False)
    assert said.startswith("1 checked now")
    assert "1 given" in said
    assert "the alterations of 1 of them, the second solvers' answers for 1 and" in said
    assert "what CasADi cancels is defined for 1, where" in said
    assert "what CasADi cancels is defined for 0, where" in provenance(now, none, examine=False)
    assert "the alterations of 0 of them" in provenance(now, now, examine=True)
    assert "0 have certificates" in said


def test_entries_of_another_claim_are_not_kept():
    old = load().by_id()["prediction.order"]
    assert record.merged(Ledger(()), Ledger((old,))).entries == (old,)

    with pytest.raises(SystemExit, match=r"prediction\.order"):
        record.merged(Ledger(()), Ledger((replace(old, graph_hash="00"),)))


@pytest.mark.parametrize(
    "answers, closes, verdict",
    [
        ([OPEN, REFUTED], False, REFUTED),
        ([PROVED, OPEN, PROVED, PROVED, PROVED, OPEN], True, OPEN),
        ([PROVED, OPEN, PROVED, PROVED, PROVED, OPEN], False, ""),
        ([PROVED, OPEN, PROVED, PROVED, PROVED, PROVED], True, PROVED),
        ([PROVED, OPEN, PROVED, PROVED, PROVED, REFUTED], True, REFUTED),
        ([PROVED] * 5, True, PROVED),
    ],
)
def test_what_is_left_open_within_a_longer_budget_is_not_caught(
    monkeypatch, answers, closes, verdict
):
    claim, said = CLAIMED["guard.anchor"], iter(answers)
    monkeypatch.setattr(noticed, "verdict_of", lambda *_: next(said))
    monkeypatch.setattr(noticed, "proves_quickly", lambda _: closes)

    assert noticed.after_alteration(claim, "wmr_ctrl.control.guard.guard:clipped") == verdict


def test_a_function_is_named_where_its_alteration_is_noticed(monkeypatch):
    said = iter((REFUTED, OPEN, PROVED, ""))
    monkeypatch.setattr(noticed, "after_alteration", lambda *_: next(said))
    altered = noticed.tried(CLAIMED["guard.anchor"], "abcde", {"e": REFUTED})
    entry = replace(ENTRY, altered=altered)

    assert entry.functions == ("a", "b", "e")
    assert entry.alterations == {"tried": 4, "caught": 2, "open": 1}
    spent = noticed.tried(CLAIMED["guard.anchor"], "ab", {}, patience=0)
    assert replace(ENTRY, altered=spent).alterations is None
