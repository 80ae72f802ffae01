"""Claims as data, their tests, and the rule that turns tests into verdicts."""

import math
import re
import string

import pytest

from wmr_ctrl.core.errors import UnknownNameError
from wmr_ctrl.report.paper_claims import (
    Evidence,
    Measured,
    Quoted,
    TestSpec,
    Verdict,
    judge_all,
    load_claims,
    verdict_of,
)
from wmr_ctrl.results.table import table_of_rows
from wmr_ctrl.simulation.campaign.paper_runs import REPORTED
from wmr_ctrl.simulation.campaign.plan import PlannedCase

WORDS = {
    "a tenth": 0.1, "half": 0.5, "halves": 0.5, "grow by at least a half": 1.5, "twice": 2.0,
    "doubles": 2.0, "a millionth": 1e-6, "a quarter": 0.25, "leaves the limits": 1.0,
}  # fmt: skip
"""Bounds that a threshold's words have for their number."""

CLAIMS = load_claims()


def row(law, seed, **values):
    case = PlannedCase("paper-simulation", law, name="paper-simulation")
    return {**case.labels, "seed": seed, "outcome": "completed", **values}


def evidence(*rows):
    """Rows with the given figures; every other figure is None."""
    empty = dict.fromkeys(REPORTED, None)
    return Evidence(table_of_rows([{**empty, **row} for row in rows]))


def measured(value, **bound):
    return Measured(TestSpec("k", "text", "ise_total", **bound), {0: value})


# -- the data -----------------------------------------------------------------------------


def test_ids_are_unique_and_every_claim_is_told_in_full():
    assert len({claim.id for claim in CLAIMS}) == len(CLAIMS) > 15
    for claim in CLAIMS:
        assert all((claim.section, claim.title, claim.quote, claim.threshold, claim.explanation))
        assert any(test.decides for test in claim.tests), claim.id
        for test in claim.tests:
            assert (test.over or {}).keys() <= {"figure", "scenario", "law"}
            assert test.laws == ("smc",) or "smc" not in test.laws, "it has tests of its own"
        keys = {test.key for test in claim.tests}
        named = {name for _, name, _, _ in string.Formatter().parse(claim.explanation) if name}
        assert len(keys) == len(claim.tests)
        assert named <= keys


# -- the rule -----------------------------------------------------------------------------


def of_smc(value, **bound):
    return Measured(TestSpec("k", "text", "ise_total", laws=("smc",), **bound), {0: value})


GOOD, BAD, NOTED = measured(1.0, at_most=2.0), measured(3.0, at_most=2.0), measured(99.0)
GOOD_SMC, BAD_SMC = of_smc(1.0, at_most=2.0), of_smc(3.0, at_most=2.0)


@pytest.mark.parametrize(
    "tests, verdict",
    [
        ([], Verdict.FAILS),
        ([GOOD, NOTED, GOOD], Verdict.HOLDS),
        ([BAD, GOOD, NOTED], Verdict.IN_PART),
        ([BAD, NOTED], Verdict.FAILS),
        ([GOOD_SMC], Verdict.STAND_IN),
        ([GOOD_SMC, BAD_SMC], Verdict.STAND_IN_PART),
        ([BAD_SMC], Verdict.STAND_IN_FAILS),
        ([GOOD, GOOD_SMC], Verdict.IN_PART),
        ([GOOD, BAD_SMC], Verdict.IN_PART),
        ([BAD, GOOD_SMC], Verdict.FAILS),
    ],
)
def test_a_claim_holds_by_all_some_or_none_and_never_by_the_stand_in(tests, verdict):
    assert verdict_of(tests) == verdict


@pytest.mark.parametrize(
    "tests, verdict", [([GOOD, GOOD], Verdict.UNBROKEN), ([GOOD, BAD], Verdict.FAILS)]
)
def test_what_never_happens_is_refuted_by_one_run_and_shown_by_none(tests, verdict):
    assert verdict_of(tests, never=True) == verdict


@pytest.mark.parametrize(
    "value, bound, passed",
    [
        (2.0, {"at_most": 2.0}, True),
        (math.nextafter(2.0, 3.0), {"at_most": 2.0}, False),
        (2.0, {"at_least": 2.0}, True),
        (math.nextafter(2.0, 1.0), {"at_least": 2.0}, False),
        (None, {"at_most": 2.0}, False),
        (1.0, {}, None),
    ],
)
def test_a_bound_is_kept_or_not(value, bound, passed):
    assert measured(value, **bound).passed is passed


def test_a_test_passes_only_if_every_seed_keeps_its_bound():
    spec = TestSpec("k", "text", "ise_total", at_most=1.0)

    assert Measured(spec, {0: 0.5, 1: 0.9}).passed
    assert not Measured(spec, {0: 0.5, 1: 1.1}).passed
    assert Measured(spec, {0: 0.5, 1: 1.1}).keeping == 1
    assert not Measured(spec, {}).passed


# -- where numbers come from --------------------------------------------------------------


def test_a_ratio_is_taken_seed_by_seed():
    spec = TestSpec("k", "text", "ise_total", laws=("nn",), over={"law": "mb"})
    rows = [row("nn", 0, ise_total=2.0), row("nn", 1, ise_total=9.0), row("nn", 2, ise_total=1.0)]
    others = [row("mb", 0, ise_total=4.0), row("mb", 1, ise_total=3.0)]

    assert evidence(*rows, *others).values(spec) == {0: 0.5, 1: 3.0}


def test_of_several_cases_the_worst_counts():
    rows = [row("nn", 0, ise_total=2.0), row("mb", 0, ise_total=4.0)]
    high = TestSpec("k", "text", "ise_total", laws=("nn", "mb"), at_most=3.0)
    low = TestSpec("k", "text", "ise_total", laws=("nn", "mb"), at_least=3.0)

    assert evidence(*rows).values(high) == {0: 4.0}
    assert evidence(*rows).values(low) == {0: 2.0}
    assert evidence(*rows, row("nn", 1, ise_total=9.0)).values(high) == {0: 4.0}
    assert evidence(rows[0], row("mb", 0)).values(high) == {0: None}


def test_sentences_quote_the_runs_at_hand():
    spec = TestSpec("k", "text", "limit_ratio", laws=("nn",))
    some, none = (Quoted(Measured(spec, values)) for values in ({0: 0.5, 1: 1.2, 2: 1.0}, {}))

    assert f"{some:broken}, {some:range}, {some:%}" == "1 of 3 seeds, 500 to 1200 mm, 100 %"
    assert f"{some}, {some:mm}" == "1.00, 1000 mm"
    assert f"{none:broken}, {none:range}, {none}" == "0 of 0 seeds, –, –"


def test_our_times_count_only_where_they_were_measured(campaign):
    def time_tests(times):
        judged = judge_all(Evidence(campaign.table, times))
        return next(one for one in judged if one.claim.id == "V-time").tests

    assert [test.spec.key for test in time_tests({})] == ["paper"]
    ours = time_tests({"pid": 0.1, "smc": 9.0, "mb": 0.5, "nn": 2.0})[1]
    assert ours.values == {0: pytest.approx(0.02)}


def test_unknown_cases_are_told_instead_of_judged():
    with pytest.raises(UnknownNameError):
        evidence(row("nn", 0)).values(TestSpec("k", "text", "ise_total", laws=("mb",)))


# -- a whole campaign ---------------------------------------------------------------------


def test_every_claim_gets_a_verdict_and_explanations_fit_it(campaign):
    judged = judge_all(Evidence(campaign.table))

    assert [one.claim for one in judged] == list(CLAIMS)
    assert all(bool(one.explanation) == one.as_expected for one in judged)
    assert not all(one.as_expected for one in judged)  # made-up runs are not the paper's


def test_the_threshold_of_a_claim_has_the_numbers_of_its_tests():
    """Thresholds give numbers as they are, in per cent, 1 +- per cent, millimetres, or words."""
    for claim in load_claims():
        found = {float(text) for text in re.findall(r"\d+(?:\.\d+)?", claim.threshold)}
        said = {number for word, number in WORDS.items() if word in claim.threshold}
        for number in found:
            said |= {number, number / 100, 1 + number / 100, 1 - number / 100, number / 1000}
        for test in claim.tests:
            for bound in (test.at_least, test.at_most):
                assert bound is None or any(math.isclose(bound, n) for n in said), claim.id
