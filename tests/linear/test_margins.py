"""Margins against closed forms, python-control's own, and runs with a delay."""

import math
from dataclasses import replace

import control as ct
import numpy as np
import pytest

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.theory.linear import largest_stable_period, margins_at, open_loop, with_robot
from wmr_ctrl.theory.linear.margins import crossings
from wmr_ctrl.world.references import Line
from wmr_ctrl.world.scenario import load_scenario


@pytest.fixture(scope="module")
def line(nominal):
    """Nominal scenario on a straight line: thrust and moment are decoupled there."""
    return replace(nominal, reference=Line(speed=0.2))


def test_margins_of_the_thrust_loop_in_closed_form(line):
    """|L| = 1: w^4 = (17.5 w)^2 + 75^2; the phase there is -180 degrees + atan(17.5 w/75)."""
    found = margins_at(line, "mb", 0)
    w = math.sqrt((17.5**2 + math.sqrt(17.5**4 + 4 * 75**2)) / 2)
    phase = math.atan(17.5 * w / 75)

    assert found.gain is None
    assert found.phase == pytest.approx(math.degrees(phase), rel=1e-9)
    assert found.delay == pytest.approx(phase / w, rel=1e-9)


def test_a_crossing_behind_the_critical_point_allows_the_rest_of_the_turn():
    """27/(s + 1)^3 has |L| = 1 at w^2 = 8, at a phase of -3 atan(w), below -180 degrees."""
    found = crossings(ct.ss(ct.tf([27.0], [1.0, 3.0, 3.0, 1.0])), np.geomspace(0.1, 100, 400))
    w, ahead = math.sqrt(8.0), math.pi - 3 * math.atan(math.sqrt(8.0))

    assert ahead < 0
    assert found.phases == pytest.approx([math.degrees(ahead)], rel=1e-9)
    assert found.delays == pytest.approx([(ahead + 2 * math.pi) / w], rel=1e-9)
    assert found.gains == pytest.approx([8.0 / 27.0], rel=1e-9)


@pytest.mark.parametrize("law, axis", [("mb", 0), ("nn", 1)])
def test_continuous_margins_are_python_controls(nominal, law, axis):
    found = margins_at(nominal, law, axis)
    gain, phase, _, _ = ct.margin(open_loop(nominal, law, axis))

    assert found.phase == pytest.approx(phase, rel=1e-6)
    assert (found.gain or found.gain_down or math.inf) == pytest.approx(gain, rel=1e-6)


@pytest.mark.parametrize(
    "law, period", [("mb", None), pytest.param("pid", 0.01, marks=pytest.mark.slow)]
)
def test_disk_margin_is_its_definition(nominal, law, period):
    """a = 1/max |S - 1/2|; the loop tolerates gains up to (2 + a)/(2 - a), phases up to 2
    atan(a/2).
    """
    found = margins_at(nominal, law, 1, period=period)
    loop = open_loop(nominal, law, 1, period=period)
    w = np.geomspace(1e-2, math.pi / period if period else 1e3, 20_000)
    points = np.exp(1j * w * period) if period else 1j * w
    sensitivity = 1 / (1 + np.squeeze(loop(points)))

    assert found.disk == pytest.approx(1 / np.abs(sensitivity - 0.5).max(), rel=1e-4)
    assert found.disk_gain == pytest.approx((2 + found.disk) / (2 - found.disk), rel=1e-3)
    assert found.disk_phase == pytest.approx(2 * math.degrees(math.atan(found.disk / 2)), rel=1e-3)


def test_sampled_gain_margin_is_the_ratio_of_periods_where_both_end_at_minus_one(line):
    """Thrust: a pole is at z = -1 when (rho/2 + k1) T g = 2, whether T or g grows."""
    found = margins_at(line, "mb", 0, period=0.01)

    assert found.gain == pytest.approx(2 / 17.5 / 0.01, rel=1e-9)


def test_a_wrong_mass_moves_the_model_based_loop_as_its_gain_would(line):
    """The law's force is m_hat times a command, so a lighter robot is a higher gain."""
    heavy = largest_stable_period(with_robot(line, I=1.5), "mb")

    assert heavy == pytest.approx(1.5 * largest_stable_period(line, "mb"), rel=2e-4)
    assert with_robot(line, m=0.5).believed.m == line.robot.m


@pytest.mark.parametrize(
    "given, match",
    [
        ({"axis": 2}, "axis = 2 must be 0, the thrust, or 1"),
        ({"axis": -1}, "axis = -1 must be 0"),
        ({"axis": 1.0}, "must be int"),
        ({"axis": 0, "period": 0.0}, r"period = 0\.0 s must be finite and above 0"),
        ({"axis": 0, "period": -0.1}, "must be finite and above 0"),
        ({"axis": 0, "period": math.nan}, "must be finite and above 0"),
    ],
)
def test_an_impossible_axis_or_period_is_refused(given, match):
    with pytest.raises(ArgumentError, match=match):
        open_loop(load_scenario("paper-simulation-nominal"), "pid", **given)


def test_margins_behind_a_delay_are_those_of_the_frequency_response():
    """The loop has 19 states, so margins from python-control's polynomials are wrong."""
    late = load_scenario("paper-simulation-nominal", {"actuator.delay": 0.02})
    for axis in (0, 1):
        loop = open_loop(late, "prox", axis, period=0.01)
        down, phase, *_ = ct.stability_margins(loop, method="frd")
        found = margins_at(late, "prox", axis, period=0.01)
        nearest = {found.gain, found.gain_down}
        assert any(down == pytest.approx(gain, rel=1e-5) for gain in nearest)
        assert found.phase == pytest.approx(phase, rel=1e-4)
