"""Late and averaged velocities, jitter and lag: the limit holds, and the bounds are tight."""

import math
import re
from dataclasses import replace

import pytest

from tests.control.guard.late_trial import Case, settled, trial
from tests.control.guard.test_delay import ON
from tests.tables import changes
from wmr_ctrl.control.controller import guard as guard_system
from wmr_ctrl.control.guard.lateness import Counting, Times, lateness, since_last
from wmr_ctrl.control.guard.refusals import feasible_guard
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.effect import Bound
from wmr_ctrl.world.scenario import load_scenario

MEAN = Case(window=1, dbar=40.0, nbar=0.05)
JITTER = Case(lo=0.5, hi=1, dbar=40.0)
LAG = Case(lag=1, dbar=40.0, brake=40.0)
ALL = Case(lag=0.5, lo=0.25, hi=1, window=1, age=0.25, dbar=15.0, nbar=0.05)
VARYING = Case(lag=1, fast=0.5, dbar=40.0, brake=40.0)
ALL_VARYING = replace(ALL, fast=0.25, dbar=12.0)
CASES = {
    "mean over a sample": MEAN,
    "old mean": Case(age=1, window=0.5, dbar=30.0),
    "jitter": JITTER,
    "lag and jitter": Case(lag=0.5, hi=1, dbar=20.0),
    "all": ALL,
    "varying lag": VARYING,
    "varying lag, jitter of a sample, sure friction, slow approach": replace(
        ALL_VARYING, lo=0.0, dbar=27.0, f_min=15.0, f_speed=0.1, alpha=0.7, brake=60.0
    ),
    "varying lag and all at 10 ms": replace(ALL_VARYING, T=0.01, dbar=120.0),
}
BROKEN = {
    "window": (MEAN, {"window": 1.125}),
    "latest takeover": (JITTER, {"hi": 1.125}),
    "lag": (LAG, {"lag": 1.05}),
    "smallest lag": (VARYING, {"fast": 0.475}),
}
"""Bounds exceeded by 5 %, or by one part of the period for times that are whole parts."""


@pytest.mark.parametrize("name", CASES)
@pytest.mark.slow_but("all")
def test_hostile_robots_reach_the_limit_and_never_pass_it(name):
    case = CASES[name]
    found = trial(case, 200, 40, 0)
    assert (found.fastest <= 1).all()
    assert (found.fastest > 1 - 1e-6).any()
    assert found.blamed <= 1 + 1e-9
    assert found.apart < 1e-11 * case.M_min / case.T


@pytest.mark.parametrize(
    "case",
    [
        Case(window=2, dbar=30.0, f_min=15.0, f_speed=0.1, alpha=0.7, brake=60.0),
        Case(lag=0.5, fast=0.25, hi=1, lo=0.25, dbar=20.0),
        *(replace(item, dbar=20.0, tau_max=5.0) for item in (LAG, VARYING, JITTER)),
    ],
)
def test_a_few_hostile_robots_get_the_forces_of_the_formula(case):
    """Also with weak wheels: older commands have the weights that they had when sent."""
    found = trial(case, 24, 40, 0)

    assert (found.fastest <= 1).all()
    assert found.apart < 1e-11 * case.M_min / case.T


@pytest.mark.parametrize("name", BROKEN)
def test_an_assumption_that_is_broken_breaks_the_limit(name):
    case, changed = BROKEN[name]
    assert (trial(case, 200, 40, 0, replace(case, **changed), compare=False).fastest > 1).any()


# --- what a command counts for


@pytest.mark.parametrize("age, window", [(0.013, 0.0), (0.004, 0.027)])
@pytest.mark.parametrize("delay, jitter", [(0.024, 0.0), (0.017, 0.008)])
@pytest.mark.parametrize("lag", [0.0, 0.02])
def test_weights_add_up_to_the_time_that_counts(age, window, delay, jitter, lag):
    """The weights sum to ``usual`` for the mean over the window, and to ``most`` after a rest."""
    late = lateness(times_of(age, window, delay, jitter, lag))
    older, share = (late.tail.steady, late.tail.share) if late.tail else (0.0, 0.0)
    mean, rest = (sum(weight for _, weight in pieces) for pieces in (late.mean, late.rest))

    assert mean + share * older + late.jitter == pytest.approx(late.usual)
    assert rest + older + late.jitter == pytest.approx(late.most)
    assert late.most == pytest.approx((age + window + delay + lag) / 0.01)
    assert late.usual == pytest.approx((age + window / 2 + delay + lag) / 0.01)
    assert (late.mixed > 0) == (jitter > 0)


def times_of(age=0.0, window=0.0, delay=0.0, jitter=0.0, lag=0.0, period=0.01):
    return Times(period, 0.001, age, window, (delay - jitter, delay), (lag, lag))


def test_a_constant_delay_counts_as_it_did():
    late = lateness(times_of(delay=0.024))
    pieces = (((1,), 1.0), ((2,), 1.0), ((3,), 0.4))
    assert late == Counting(pieces, pieces, 0.0, 0.0, 0.0, 2.4, 2.4, 0.0, 3)
    assert lateness(times_of()).at_once


def test_a_mean_over_one_sample_counts_the_last_command_half():
    late = lateness(times_of(window=0.1, period=0.1))
    assert (late.mean, late.rest) == ((((1,), 0.5),), (((1,), 1.0),))
    since = since_last(times_of(window=0.1, period=0.1))
    assert since.mean == (((1,), 0.5), ((2,), 0.5))
    assert since_last(times_of(window=0.2, period=0.1)) is None


# --- numbers


@pytest.mark.parametrize("case, said", [
    (Case(window=1, dbar=120.0), r"late = window 0\.1 s.*clock\.control <= .*dbar\[1\] <= "),
    (Case(hi=1.5, lo=0.25), r"varies by 0\.125 s, more than clock\.control.*at most 0\.1"),
    (Case(hi=1, nbar=0.45), r"jitter of 0\.1 s and nbar\[1\] = 0\.45.*guard\.nbar\[1\] <= "),
    (Case(lag=3, dbar=100.0), r"late = lag 0\.3 s"),
    (Case(lag=0.5, fast=0.2, window=1, nbar=0.45), r"a lag between 0\.02 and 0\.05 s and nbar"),
])  # fmt: skip
def test_what_cannot_be_met_is_refused_with_numbers_and_a_remedy(case, said):
    with pytest.raises(ScenarioError) as refused:
        guard_system(settled(case))

    assert re.search(said, str(refused.value)), str(refused.value)


def test_the_age_of_an_axis_is_told_where_that_axis_cannot_be_held():
    pushed = ON | changes("guard.dbar = [60.0, 15.0]")
    with pytest.raises(ScenarioError, match=r"late = age 0\.3 s, is needed on axis 2"):
        feasible_guard(load_scenario("far-start", pushed), Bound(age=(0.0, 0.3)), math.inf)


def test_nothing_late_gives_the_graph_of_before():
    scenario = load_scenario("paper-simulation", ON)
    item = guard_system(settle(scenario, None))
    names = [port.signal.name for port in item.state]
    assert names == ["tau_applied", "guard_v", "guard_started"]
