"""A law on a scenario, and the numbers that follow."""

import pytest

from tests.papers_robot import paper
from tests.tables import changes
from wmr_ctrl.control.laws.pid import PidGains
from wmr_ctrl.control.setup import (
    KINEMATICS,
    check_gains,
    check_name,
    following_gains,
    one_period_later,
    settle,
    with_kinematics,
    with_traction_limit,
)
from wmr_ctrl.core.errors import ArgumentError, ScenarioError, UnknownNameError
from wmr_ctrl.world.grip import grip
from wmr_ctrl.world.scenario import override


def test_numbers_are_found_by_key_wherever_they_stand():
    setup = settle(paper(), "pid")

    assert setup.value("gains.pid.Kp") == setup.own(PidGains).Kp
    assert setup.value("robot.m") == (50.0,)
    assert setup.number("gains.kinematics.k")[0].size == 3
    with pytest.raises(KeyError):
        setup.number("gains.mb.rho")
    with pytest.raises(ArgumentError, match="mb has ModelBasedGains, not PidGains"):
        settle(paper(), "mb").own(PidGains)


def test_the_smaller_torque_limit_counts():
    assert settle(paper(), "prox").tau_max == 20.0
    assert settle(override(paper(), {"actuator.tau_max": 5.0}), "prox").tau_max == 5.0


def test_gains_of_no_law_are_refused_and_those_that_follow_are_named():
    with pytest.raises(UnknownNameError, match="no section of gains is named 'pdi'"):
        check_gains(override(paper(), {"gains": {"pdi": {"Kp": [1.0, 1.0]}}}))
    assert following_gains(KINEMATICS) == {"k"}
    assert following_gains("mb") == {"rho"}
    with pytest.raises(ArgumentError, match="'mb' is a law"):
        check_name("mb")


def test_own_gains_of_eq_7_take_the_place_of_the_shared_ones():
    own = override(paper(), changes("gains.pid.kinematics = [1.0, 2.0, 3.0]"))

    assert settle(own, "pid").kinematic_key == "gains.pid.kinematics"
    assert settle(own, "mb").kinematic_key == "gains.kinematics.k"
    changed = with_kinematics(own, settle(own, "pid").control_law)
    assert settle(changed, "mb").kinematics.k == (1.0, 2.0, 3.0)
    assert with_kinematics(own, settle(own, "mb").control_law) is own


def test_tyres_limit_the_torques_where_it_is_asked_for():
    asked = override(paper(), {"actuator.traction": True})

    assert with_traction_limit(asked).actuator.tau_max == pytest.approx(grip(asked).keep)
    assert with_traction_limit(paper()) is paper() or with_traction_limit(paper()) == paper()
    with pytest.raises(ScenarioError, match="that is nothing"):
        with_traction_limit(override(asked, changes("limits.v_u1 = [30.0, 30.0]")))


def test_drives_may_be_a_period_later():
    setup = settle(override(paper(), {"actuator.delay": 0.02}), "pid")

    assert one_period_later(setup).scenario.actuator.delay == pytest.approx(0.03)
