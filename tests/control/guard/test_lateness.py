"""Late and averaged velocities, jitter and lag: the limit holds, and the bounds are tight."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from tests.control.guard.late_trial import Case, composed, trial
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
FIRM = Case(window=2, dbar=30.0, f_min=15.0, f_speed=0.1, alpha=0.7, brake=60.0)
VARYING_JITTER = Case(lag=0.5, fast=0.25, hi=1, lo=0.25, dbar=20.0)
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
    "error": (MEAN, {"nbar": 0.0525}),
    "mass": (MEAN, {"M_min": 45 / 1.05}),
    "latest takeover": (JITTER, {"hi": 1.125}),
    "earliest takeover": (JITTER, {"lo": 0.375}),
    "lag": (LAG, {"lag": 1.05}),
    "smallest lag": (VARYING, {"fast": 0.475}),
    "push among all and a varying lag": (ALL_VARYING, {"dbar": 12.6}),
}
"""By 5 %, or by one part of the period where times are whole parts."""


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
    "case", [FIRM, VARYING_JITTER], ids=["mean, sure friction", "lag and jitter vary"]
)
def test_a_few_hostile_robots_get_the_forces_of_the_formula(case):
    found = trial(case, 24, 16, 0)

    assert (found.fastest <= 1).all()
    assert found.apart < 1e-11 * case.M_min / case.T


def passed(name, lanes, samples):
    case, changed = BROKEN[name]
    return bool((trial(case, lanes, samples, 0, replace(case, **changed), False).fastest > 1).any())


@pytest.mark.parametrize("name", ["window", "latest takeover", "lag", "smallest lag"])
@pytest.mark.slow_but("window", "lag")
def test_an_assumption_that_is_broken_breaks_the_limit(name):
    assert passed(name, 200, 40)


def test_a_guard_does_the_same_in_either_direction():
    system, step = composed(ALL_VARYING)
    draw, x, back, changed = np.random.default_rng(3), system.x0, system.x0, 0
    for _ in range(100):
        u = np.concatenate((draw.normal(size=2) * (150, 30), draw.uniform(-1, 1, 2) * (0.8, 1.2)))
        (x, torque, seen), (back, other, _) = step(u, x, system.p0), step(-u, back, system.p0)
        assert other.full() == pytest.approx(-torque.full(), rel=1e-12, abs=1e-12)
        changed += bool(seen.full()[:2].any())

    assert changed > 10


@pytest.mark.parametrize(
    "late", [{"lag": 1.0}, {"lag": 1.0, "fast": 0.5}, {"lag": 0.5, "lo": 0.5, "hi": 0.5}], ids=str
)
def test_older_commands_count_as_weak_wheels_were_given_them(late):
    """Wheels that cannot reach a safe force get a smaller one, and that is what acts later."""
    case = Case(**late, dbar=20.0, tau_max=5.0)
    formulas = [case.formula(axis) for axis in (0, 1)]
    system, step = composed(case)
    draw, x, robot = np.random.default_rng(1), system.x0, case.setup.scenario.robot
    tails = [[item.first_tail] * 2 for item in formulas]
    first, sent, weak = np.ravel(tails), np.zeros((formulas[0].n, 2)), 0
    for _ in range(50):
        u = np.concatenate((draw.uniform(-1, 1, 2) * (400, 60), draw.uniform(-1, 1, 2) * 0.3))
        x, torque = (item.full().ravel() for item in step(u, x, system.p0)[:2])
        force = np.array([torque.sum(), robot.l * (torque[0] - torque[1])]) / robot.r
        commands = np.vstack([force, sent])
        for axis, item in enumerate(formulas):
            tails[axis] = [
                item.next_tail(tail, commands[:, axis], way)
                for tail, way in zip(tails[axis], (1.0, -1.0), strict=True)
            ]
        assert x[-4:] == pytest.approx(np.ravel(tails) - first, rel=1e-9, abs=1e-9)
        sent, weak = commands[:-1], weak + bool((np.abs(torque) > 4.99).any())

    assert weak > 10


# --- what a command counts for


def rows():
    draw, steps = np.random.default_rng(1), 0.001
    table = []
    for _ in range(40):
        age, window, delay = steps * draw.integers(0, 30, 3) * draw.integers(0, 2, 3)
        jitter = min(delay, steps * draw.integers(0, 11) * draw.integers(0, 2))
        table.append((age, window, delay, jitter, draw.choice([0.0, draw.uniform(1e-3, 0.05)])))
    return table


@pytest.mark.parametrize("times", rows())
def test_pieces_count_for_the_integral_of_what_is_left(times):
    """By the mean over ages sigma, in numbers; together all that may count."""
    age, window, delay, jitter, lag = (float(t) / 0.01 for t in times)
    late = lateness(times_of(*(float(t) for t in times)))
    sigma = age + window * (np.arange(2000) + 0.5) / 2000
    for pieces, ages in ((late.mean, sigma), (late.rest, np.array([age + window]))):
        for which, weight in pieces:
            begin, end = ends(which, delay - jitter, delay)
            s = begin + (end - begin) * (np.arange(2000) + 0.5) / 2000
            beyond = np.maximum(s[:, None] - ages[None, :: max(1, len(ages) // 200)], 0.0)
            left = np.exp(-beyond / lag) if lag else (beyond == 0) * 1.0
            assert weight == pytest.approx(float(left.mean()) * (end - begin), abs=6e-3)
    older = late.tail.steady if late.tail else 0.0
    assert sum(w for _, w in late.rest) + older + late.jitter == pytest.approx(late.most)
    older *= late.tail.share if late.tail else 1.0
    assert sum(w for _, w in late.mean) + older + late.jitter == pytest.approx(late.usual)
    assert late.mixed <= late.usual + 1e-12
    least = dict(late.rest)  # the mean of a command never counts for more than the same from rest
    assert all(weight <= least.get(which, 0.0) + 1e-12 for which, weight in late.mean)
    assert not late.tail or late.tail.share <= 1


def times_of(age=0.0, window=0.0, delay=0.0, jitter=0.0, lag=0.0, period=0.01):
    return Times(period, 0.001, age, window, (delay - jitter, delay), (lag, lag))


def ends(which, lo, hi):
    """Ages between which a piece lies."""
    j = which[0]
    return (j - 1 - lo, j - hi) if len(which) == 1 else (j - 1 - hi, j - 1 - lo)


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
        guard_system(case.setup)

    assert re.search(said, str(refused.value)), str(refused.value)


def test_the_age_of_an_axis_is_told_where_that_axis_cannot_be_held():
    """With the least inertia that would do, which does, and hardly any less does not."""
    pushed = ON | changes("guard.dbar = [60.0, 15.0]; guard.trust = true")
    words = r"late = age 0\.3 s, is needed on axis 2"

    def asked(**more):
        given = pushed | {key.replace("__", "."): value for key, value in more.items()}
        feasible_guard(load_scenario("far-start", given), Bound(age=(0.0, 0.3)), math.inf)

    with pytest.raises(ScenarioError, match=words) as refused:
        asked()
    least = float(re.search(r"of at least (\S+) kg", str(refused.value))[1])
    asked(guard__M_min=[45.0, least], guard__M_max=[1e3, 1e3])
    with pytest.raises(ScenarioError, match=words):
        asked(guard__M_min=[45.0, 0.99 * least], guard__M_max=[1e3, 1e3])


def test_nothing_late_gives_the_graph_of_before():
    scenario = load_scenario("paper-simulation", ON)
    item = guard_system(settle(scenario, None))
    names = [port.signal.name for port in item.state]
    assert names == ["tau_applied", "guard_v", "guard_started"]
