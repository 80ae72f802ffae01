"""Laws that predict to the time when their command acts, and what that is worth behind a delay."""

import casadi as ca
import numpy as np
import pytest

from tests.checks.asking import closed
from wmr_ctrl.control.controller import controller
from wmr_ctrl.control.laws.context import LawContext
from wmr_ctrl.control.laws.prediction import ahead, slowed
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
    """100 ms with a delay of ``share`` periods, the guide's gains for none, and a prediction."""
    gains, delay = guide(T, 0.0, 0.2), round(share * T, 3)
    overrides = {
        "clock.control": T, "actuator.delay": delay, "guard.enabled": False, "changes": [],
        "clock.duration": 20.0, "gains.prox.kinematics": list(gains.k),
        "gains.prox.rho": list(gains.rho), "gains.prox.wo": 0.45 / (T + delay),
        f"gains.{law}.delay": delay if stated is None else stated,
    }  # fmt: skip
    return load_scenario("safe-simulation", overrides | changed)


def radius(scenario, law):
    matrix = closed(Loop(settle(scenario, law)), np.array((0.2, 0.1)), T)
    return float(np.abs(np.linalg.eigvals(matrix)).max())


def test_commands_that_a_law_predicts_with_are_remembered_where_drives_are_quicker():
    setup = settle(late("prox", 0.5, stated=0.25), "prox")
    kept = {item.signal for item in controller(setup).state}

    assert setup.predicted == 3
    assert {tau_sent(age) for age in (1, 2, 3)} <= kept


def test_it_counts_on_the_observers_force_and_on_a_reference_that_gathers_speed():
    """Two commands under way, 1.5 periods: the plain equations of motion in steps of 0.1 ms."""
    believed = {"model.m": 60.0, "model.I": 4.0, "model.mu": 0.1}
    here = LawContext(settle(late("prox", 1.5, **believed), "prox"))
    made_up = ca.SX.sym("made_up", 2)
    then, ports = ahead(here, made_up)
    symbols = [*(item.sym for item in (*here.inputs, *ports)), made_up]
    numbers = here.parameters.ports
    graph = ca.Function(
        "seen",
        [ca.vertcat(*symbols), ca.vertcat(*(item.sym for item in numbers))],
        [then.pose, then.v, then.pose_d, then.v_d],
    )
    desired, rate = (0.3, -0.2, 0.4, 0.5, -0.6), np.array((0.8, 3.0))
    pose, v, force = (0.1, 0.2, -0.7), (0.4, 0.5), np.array((20.0, -5.0))
    newest, oldest = (3.0, 1.0), (-1.0, 2.0)
    values = [value for port in numbers for value in port.value]
    row = (*desired, *rate, *pose, *v, *newest, *oldest, *force)
    found = [item.full().ravel() for item in graph(row, values)]

    def gained(time, v):
        right, left = oldest if time < 0.05 else newest
        pushes = np.array(((right + left) / 0.1, 0.25 * (right - left) / 0.1))
        drag = (0.1 * 60.0 * 9.81 * np.tanh(v[0] / 0.01), 0.0)
        return (pushes - force - drag) / (60.0, 4.0)

    ends = (*moved(pose, v, gained), *moved(desired[:3], desired[3:], lambda _time, _v: rate))
    for i, (told, wanted) in enumerate(zip(found, ends, strict=True)):
        assert told == pytest.approx(wanted, abs=1e-9 if i % 2 else 1e-3)  # velocity, pose


def moved(pose, v, gained):
    """Pose and velocity after 0.15 s of a velocity that gains ``gained`` of time and itself."""
    at, speed, step = np.array(pose), np.array(v), 1e-4
    for i in range(1500):
        more = speed + step * gained((i + 0.5) * step, speed)
        v1, omega = (speed + more) / 2
        theta = at[2] + step * omega / 2
        at = at + step * np.array((-np.sin(theta) * v1, np.cos(theta) * v1, omega))
        speed = more
    return at, speed


@predicting
@pytest.mark.parametrize("share", [0.5, 1.0, 1.5])
@pytest.mark.slow_but("1.0-kanayama", "1.5-prox")
def test_gains_that_know_no_delay_stand_it_if_it_is_predicted(law, share):
    """The slowest pole stays that of no delay, where without prediction it comes near 1."""
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
