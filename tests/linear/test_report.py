"""The report: keys, plain data, text and figures, for every law."""

import re
from dataclasses import replace
from functools import cache

import pytest

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.theory.checks.stable_ranges import MASSES
from wmr_ctrl.theory.linear import report_linear
from wmr_ctrl.theory.linear.state_space import constant_speed
from wmr_ctrl.world.references import Lemniscate
from wmr_ctrl.world.scenario import load_scenario, override

KEYS = {
    "kinematic_poles", "poles", "max_sample_time", "max_sample_time_kink",
    "max_sample_time_adaptive", "one_step_safe_time", "gain_margin", "phase_margin", "disk_margin",
}  # fmt: skip


@pytest.fixture(scope="module")
def report_of(nominal):
    """The report of a law on the nominal circle, made once."""
    return cache(lambda law: report_linear(nominal, law))


@pytest.mark.slow
def test_json_holds_the_figures_of_the_audit(report_of):
    found = report_of("mb").to_json()

    assert set(found) >= KEYS
    assert [pair[0] for pair in found["kinematic_poles"]] == pytest.approx(
        (-9.99900, -3.94934, -0.05166), abs=5e-6
    )
    assert found["max_sample_time"] == pytest.approx(0.0609, rel=2e-3)
    assert found["max_sample_time_kink"] == pytest.approx(0.03472, rel=1e-3)
    assert found["max_sample_time_adaptive"] is None
    assert found["gain_margin"] is None
    assert found["adaptive_stable"] is None


def test_a_reference_that_changes_speed_and_a_guard_that_is_left_out_are_reported(nominal):
    steady = report_linear(override(nominal, {"guard.enabled": True}), "mb")
    eight = replace(nominal, reference=Lemniscate(size=2.0, rate=0.1))
    changing = replace(steady, time_invariant=constant_speed(eight))

    assert (steady.time_invariant, changing.time_invariant) == (True, False)
    assert [("time-varying" in page.table()) for page in (steady, changing)] == [False, True]
    assert steady.to_json()["guard"] == "left out"
    assert "guard is left out" in steady.table()


@pytest.mark.parametrize("span, said", [
    ((1 / MASSES, MASSES), "all that were tried"), ((1 / MASSES, 3.0), f"{1 / MASSES:.3g} to 3"),
])  # fmt: skip
def test_masses_that_are_stable_are_named_unless_all_are(report_of, span, said):
    page = replace(report_of("pid"), mass_range=span).table()

    assert re.search(rf"true over believed mass at \S+ s +{said}$", page, re.MULTILINE)


def test_a_time_is_one_of_the_run(nominal):
    with pytest.raises(ArgumentError, match="from 0 to 80 s"):
        report_linear(nominal, "mb", at=90.0)


@pytest.mark.slow
def test_with_the_guard_the_figures_are_the_same_where_it_is_inactive(nominal, report_of):
    page = report_linear(nominal, "mb", guard=True)

    assert page.to_json()["guard"] == "inactive"
    assert report_of("mb").to_json()["guard"] is None
    assert "inactive there" in page.table()
    assert page.to_json() | {"guard": None} == report_of("mb").to_json()


def test_where_the_guard_acts_there_is_nothing_to_linearise():
    """The reference is faster than the guard allows, so the guard holds the thrust back."""
    beyond = {"reference.radius": 9.9, "guard.dbar": [50.0, 1.0]}
    fast = load_scenario("paper-simulation-nominal", beyond)

    with pytest.raises(ArgumentError, match="the guard holds back"):
        report_linear(fast, "mb", guard=True)
