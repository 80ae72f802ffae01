"""Comparison of runs: size and place of differences, on shared samples and columns."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.results.conftest import build
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.results import Monitor
from wmr_ctrl.results.compare import compare

STOPPED = Monitor((2.0, 1000.0), 3, (0.3, 1), (0.6, 2), "diverged")
WEIGHTS = (Signal("W_norm", "1", "norm of the weights", 2),)


def column(comparison, name):
    return next(found for found in comparison.columns if found.name == name)


def spiked(row, height):
    """A ramp from 0 to 99 with one row moved."""
    ramp = np.arange(100.0)
    ramp[row] += height
    return ramp


def test_a_run_equals_itself_even_where_it_is_not_finite():
    odd = np.array([math.nan, math.inf, -math.inf, 1.0] * 25)
    comparison = compare(build(x=odd), build(x=odd), tolerance=0.0)

    assert comparison.verdict == "equal"
    assert {found.largest for found in comparison.columns} == {0.0}
    assert (comparison.facts, comparison.notes, comparison.rows) == ((), (), 100)
    assert [found.name for found in comparison.columns] == [
        signal.name for signal in build().elements
    ]


@given(row=st.integers(0, 99), height=st.floats(1e-3, 1e3), sign=st.sampled_from([-1, 1]))
def test_one_moved_value_is_found_with_its_time_and_size(row, height, sign):
    plain, moved = build(x=spiked(row, 0.0)), build(x=spiked(row, sign * height))
    there, back = (column(compare(*pair), "x") for pair in ((plain, moved), (moved, plain)))
    values = np.concatenate([plain["x"], moved["x"]])

    assert there == back
    found = (there.largest, there.time, there.relative)
    assert there.unit == "m"
    assert found == pytest.approx((height, row * 0.01, height / np.ptp(values)))
    assert compare(plain, moved).verdict == "differ"


@pytest.mark.parametrize(
    "height, tolerance, verdict",
    [
        (1e-10, 1e-9, "agree"),
        (5e-8, 1e-9, "agree"),  # 99 m of range: a relative difference of 5e-10
        (2e-7, 1e-9, "differ"),
        (2e-7, 1e-6, "agree"),
        (1e-10, 0.0, "differ"),
        (0.0, 0.0, "equal"),
    ],
)
def test_the_tolerance_decides(height, tolerance, verdict):
    found = compare(build(x=spiked(50, 0)), build(x=spiked(50, height)), tolerance=tolerance)

    assert found.verdict == verdict
    assert str(found).splitlines()[-1].startswith(verdict.upper())


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("other", [0.0, math.nan, math.inf, -math.inf])
def test_a_value_that_is_finite_in_one_run_only_is_infinitely_far(value, other):
    a, b = spiked(50, 0.0), spiked(50, 0.0)
    a[7], b[7] = value, other
    found = column(compare(build(x=a), build(x=b)), "x")
    same = value == other or (math.isnan(value) and math.isnan(other))

    assert (found.largest, found.relative) == ((0.0, 0.0) if same else (math.inf, math.inf))
    assert found.time == (0.0 if same else pytest.approx(0.07))


def test_huge_values_do_not_pass_as_near():
    wide = spiked(0, 1.5e308) - spiked(1, 1.5e308)
    moved = np.where(np.arange(100) == 50, 1.0, wide)

    assert compare(build(x=spiked(0, 1.5e308)), build(x=-1.5e308)).verdict == "differ"
    assert compare(build(x=wide), build(x=moved)).verdict == "differ"


def test_rounding_in_a_column_that_rests_is_within_the_tolerance():
    late = 0.01 * np.arange(100) + 5e-9  # jitter does not part the samples
    comparison = compare(build(), build(x=1e-12))

    assert (comparison.verdict, compare(build(), build(t=late)).rows) == ("agree", 100)
    assert column(comparison, "x").relative == 1.0


@pytest.mark.parametrize("tolerance", [-1e-9, math.nan])
def test_an_impossible_tolerance_is_refused(tolerance):
    with pytest.raises(ArgumentError, match="tolerance"):
        compare(build(), build(), tolerance)


def test_runs_of_different_length_are_compared_on_the_shared_samples():
    late = np.where(np.arange(100) < 60, 0.0, 1.0)
    comparison = compare(build(x=late), build(rows=60, monitor=STOPPED))

    assert (comparison.verdict, comparison.rows) == ("equal", 60)
    assert comparison.notes == (
        "The first run has 100 samples and the second 60; they share 60, and only these are "
        "compared.",
    )
    assert {"outcome", "monitor.stopped", "monitor.max_abs_v"} <= {
        fact.name for fact in comparison.facts
    }


def test_runs_of_different_clocks_are_compared_where_their_samples_meet():
    fine = build(x=np.arange(100) * 0.01)
    coarse = build(control=0.03, duration=0.9, x=np.arange(30) * 0.03)
    comparison = compare(fine, coarse)

    assert (comparison.rows, comparison.verdict) == (30, "agree")
    assert "settings.control" in {fact.name for fact in comparison.facts}
    assert column(compare(coarse, build()), "x").time == pytest.approx(0.87)
    assert column(compare(build(), coarse), "x").time == pytest.approx(0.87)


def test_differing_settings_and_provenance_are_listed():
    run_a = build(provenance={"version": "1", "compiler": "cc"}, split=0.2)
    run_b = build(
        provenance={"version": "2", "system": "os"}, split=0.3, labels={"seed": 7, "guard": True}
    )
    facts = {fact.name: (fact.in_a, fact.in_b) for fact in compare(run_a, run_b).facts}

    assert facts == {
        "seed": ("0", "7"),
        "guard": ("False", "True"),
        "settings.split": ("0.2", "0.3"),
        "provenance.version": ("1", "2"),
        "provenance.compiler": ("cc", "(absent)"),
        "provenance.system": ("(absent)", "os"),
    }


def test_runs_that_end_differently_differ_however_close_they_are():
    broken = build(monitor=Monitor((1.0001, 0.5), 1, (0.305, 1)))

    assert compare(build(), broken).verdict == "differ"
    assert "DIFFER in their outcome" in str(compare(build(), broken))


def test_runs_without_a_shared_sample_are_neither_equal_nor_different():
    at_once = Monitor((0.0, 1000.0), 1, (0.0, 2), (0.0, 2), "diverged")
    comparison = compare(build(), build(rows=0, monitor=at_once))

    assert (comparison.verdict, comparison.columns) == ("nothing shared", ())
    assert str(comparison).splitlines()[-1].startswith("NOTHING SHARED")


def test_the_text_shows_what_differs_and_ends_with_the_verdict():
    long = "scenario = 1\n" * 50
    run_a = build(provenance={"scenario_toml": long}, x=spiked(50, 0.0))
    run_b = build(extra=WEIGHTS, x=spiked(50, 0.25), provenance={"scenario_toml": "b"})
    lines = str(compare(run_a, run_b)).splitlines()

    assert any(line.split()[:4] == ["x", "m", "0.25", "0.5"] for line in lines)
    assert any(line.startswith("No difference in t, y, theta") for line in lines)
    assert any(line.startswith("provenance.scenario_toml") for line in lines)
    assert "Only the second run logs W_norm[1], W_norm[2]." in lines
    assert lines[-1].startswith("DIFFER by more than 1e-09: 100 shared samples")
    assert max(map(len, lines)) <= 100
