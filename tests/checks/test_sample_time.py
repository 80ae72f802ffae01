"""Warnings about the control period: linear limit, kink, first step."""

import pytest

from wmr_ctrl import load_scenario
from wmr_ctrl.theory.checks.sample_time import first_speeds, kink_limits
from wmr_ctrl.theory.checks.stable_ranges import largest_stable_period

PERIOD = "clock.control"


def test_kink_of_the_model_based_law_needs_two_over_rho(loop):
    assert kink_limits(loop("mb")) == pytest.approx([0.13333, 0.03472], rel=1e-4)


def test_kink_of_the_network_law_needs_two_masses_over_rho1(loop):
    assert kink_limits(loop("nn")) == pytest.approx([2 * 50 / 1350, 2 * 5.4 / 21.6])


@pytest.mark.parametrize("period, omega", [(0.1, 5.87), (0.04, 2.35), (0.03, 1.76), (0.025, 1.468)])
def test_first_step_of_the_model_based_law(loop, period, omega):
    held = {PERIOD: period, "clock.duration": 100 * period}

    assert first_speeds(loop("mb", held))[1] == pytest.approx(omega, rel=2e-3)


def test_first_step_begins_with_the_speed_at_the_start(loop):
    """The robot starts backwards and then moves towards the reference."""
    assert first_speeds(loop("mb", {"initial.velocity": [-0.9, 0.0]}))[0] == 0.9


@pytest.mark.parametrize("law, v1", [("mb", 1.155), ("nn", 2.05)])
def test_first_step_without_coulomb_friction(loop, law, v1):
    held = {PERIOD: 0.1, "robot.mu": 0}

    assert first_speeds(loop(law, held))[0] == pytest.approx(v1, rel=2e-3)


@pytest.mark.parametrize("period, told_of", [(0.03, True), (0.025, False)])
def test_warns_of_the_first_step_exactly_where_it_leaves_the_limit(told, period, told_of):
    held = {PERIOD: period, "clock.duration": 100 * period}
    sentences = [warning.sentence for warning in told("mb", held, key=PERIOD)]

    assert any(sentence.startswith("The first torque") for sentence in sentences) is told_of


def test_guarded_first_step_stays_inside(loop, told):
    held = {PERIOD: 0.1, "guard.enabled": True}

    assert (first_speeds(loop("mb", held)) <= (1, 1.5)).all()
    assert [w.sentence.split()[0] for w in told("mb", held, key=PERIOD)] == [PERIOD]


@pytest.mark.slow
def test_a_window_of_one_sample_goes_with_the_period():
    """The limit does not depend on the period at which the search begins."""

    def limit(period, counts=1024):
        stated = {"encoder.counts": counts, "clock.duration": 8.0, "guard.enabled": False}
        scenario = load_scenario("safe-simulation", {**stated, PERIOD: period})
        return largest_stable_period(scenario, "prox")

    one, other = limit(0.01), limit(0.04)
    assert one == pytest.approx(other, rel=1e-4)
    assert one < limit(0.01, None)
