"""Laws that predict to the time when their command acts, and the benefit behind a delay."""

import casadi as ca
import numpy as np
import pytest

from tests.checks.asking import closed
from tests.control.laws.points import assert_twin
from tests.tables import changes
from wmr_ctrl.control.controller import controller
from wmr_ctrl.control.laws.prediction import slowed
from wmr_ctrl.control.laws.prox import guide
from wmr_ctrl.control.numbers import structure_of
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.signals import tau_sent
from wmr_ctrl.theory.checks.loop import Loop
from wmr_ctrl.theory.linear import closed_loop as linear_loop
from wmr_ctrl.world.scenario import load_scenario

T = 0.1
LAWS = ("prox", "kanayama")
predicting = pytest.mark.parametrize("law", LAWS)


def late(law, share, stated=None, **changed):
    """100 ms with a delay of ``share`` periods, the guide's gains for no delay, and a
    prediction.
    """
    gains, delay = guide(T, 0.0, 0.2), round(share * T, 3)
    text = f"""
        clock.control = {T}
        actuator.delay = {delay}
        guard.enabled = false
        changes = []
        clock.duration = 20.0
        gains.prox.kinematics = {[*gains.k]}
        gains.prox.rho = {[*gains.rho]}
        gains.prox.wo = {0.45 / (T + delay)}
        gains.{law}.delay = {delay if stated is None else stated}
    """
    return load_scenario("safe-simulation", changes(text) | changed)


def radius(scenario, law):
    matrix = closed(Loop(settle(scenario, law)), np.array((0.2, 0.1)), T)
    return float(np.abs(np.linalg.eigvals(matrix)).max())


def test_commands_that_a_law_predicts_with_are_remembered_where_drives_are_quicker():
    setup = settle(late("prox", 0.5, stated=0.25), "prox")
    kept = {item.signal for item in controller(setup).state}

    assert setup.predicted == 3
    assert {tau_sent(age) for age in (1, 2, 3)} <= kept


@predicting
def test_it_counts_on_the_observers_force_and_on_a_reference_that_gathers_speed(law):
    """There are two commands in transit, over 1.5 periods."""
    other = changes("model.m = 60.0; model.I = 4.0; model.mu = 0.1; actuator.delay = 0.015")
    assert_twin(law, **other, **{f"gains.{law}.delay": 0.015})


@predicting
@pytest.mark.parametrize("share", [0.5, 1.0, 1.5])
@pytest.mark.slow_but("1.0-kanayama", "1.5-prox")
def test_gains_that_know_no_delay_stand_it_if_it_is_predicted(law, share):
    """Prediction keeps the spectral radius within 0.02 of the loop without delay.

    Without prediction, a delay of 0.15 s makes the radius exceed 1.
    """
    at_once = radius(late(law, 0.0), law)

    assert radius(late(law, share), law) == pytest.approx(at_once, abs=2e-2)
    assert radius(late(law, share, 0.0, **{"actuator.delay": 0.15}), law) > 1


@predicting
def test_checks_and_linear_package_build_the_same_loop(law):
    scenario = late(law, 1.5)

    assert np.abs(linear_loop(scenario, law, period=T).poles()).max() == pytest.approx(
        radius(scenario, law), rel=1e-9
    )


def test_the_number_of_commands_is_part_of_the_form_and_their_times_are_not():
    forms = [structure_of(settle(late("prox", share), "prox")) for share in (0.6, 0.7, 1.2)]

    assert forms[0][-3][1] == forms[1][-3][1] == 1
    assert forms[0] != forms[2]


def test_friction_stops_and_never_turns_round():
    for free, taken, left in ((0.1, 0.5, 0.0), (-0.1, -0.5, 0.0), (1.0, 0.25, 0.75), (-1, -2, 0)):
        assert float(ca.evalf(slowed(ca.SX(free), ca.SX(taken)))) == left
