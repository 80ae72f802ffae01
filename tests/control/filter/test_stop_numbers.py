"""Times and distances for people, against the graph with the same numbers."""

import math

import pytest

from tests.tables import changes
from wmr_ctrl import command_filter, load_scenario
from wmr_ctrl.control.filter.stop_numbers import (
    costs,
    fastest,
    leaves_from,
    leaving,
    pull_away,
    rolls_back,
    smallest_window,
    stopping,
    time_inside,
    times_inside,
)
from wmr_ctrl.world.scenario import override

BASE = changes("""
    base.kind = velocity
    limits.v_u1 = [1.0, 2.0]
    limits.v_u2 = [0.8, 1.6]
    clock.control = 0.05
    filter.kind = governor
    filter.gain = [0.9, 1.1]
    filter.tau = [0.2, 0.3]
    filter.d = [0.05, 0.05]
    filter.odometry = [0.02, 0.02]
    filter.delay = [0.0, 0.03]
    filter.free_error = 0.02
    filter.rest = 1.0
    filter.changing = true
""")
SCENARIO = load_scenario("paper-simulation", BASE)
RAMPS = {**changes("filter.kind = clip; filter.decel = [1.0, 2.0]"), "filter.tau": None}


def test_a_stop_is_made_of_its_parts():
    """The parts of a stop equal a calculation by hand.

    The stop is 0.08 s late; a speed of 0.95 m/s decays and a push of 0.05 m/s acts for 1 s.
    """
    stop = stopping(override(SCENARIO, {"filter.leave": 0}), 1.0)
    brake = 0.95 * 0.3 * (1 - math.exp(-1 / 0.3))
    assert (stop.delay, stop.push, stop.brake, stop.error) == pytest.approx(
        (0.08, 0.05, brake, 0.02)
    )
    assert stop.distance == pytest.approx(0.15 + brake)
    assert stopping(SCENARIO, 1.0).distance == pytest.approx(stop.distance + leaving(SCENARIO).roll)


@pytest.mark.parametrize("changes", [{}, RAMPS])
def test_the_filter_lets_a_base_drive_on_from_that_distance_alone(changes):
    """A steady command passes if the free distance is 2 mm longer than the stop, not if 2 mm
    shorter.
    """
    scenario = override(SCENARIO, changes)
    speed = 0.4
    needed = stopping(scenario, speed).distance
    command = (speed - 0.05) / 1.1
    for more, passes in ((2e-3, True), (-2e-3, False)):
        step = command_filter(scenario).step
        for _ in range(60):
            sent = step((command, 0.0), (speed - 0.02, 0.0), free=(needed + more, 9.0), dt=0.05)
        assert (sent.command[0] == pytest.approx(command, rel=1e-6)) is passes


@pytest.mark.parametrize("changes", [{}, RAMPS])
def test_prices_are_those_of_the_distance(changes):
    scenario = override(SCENARIO, changes)
    price, whole = costs(scenario), stopping(scenario, 1.0).distance
    longer = override(scenario, {"filter.rest": 2.0})
    assert price["rest_second"] == pytest.approx(stopping(longer, 1.0).distance - whole)
    assert price["millisecond"] == pytest.approx(1e-3)
    assert price["per_cent"] > 0


def test_no_time_is_promised_at_the_push_and_more_for_each_lower_limit():
    rows = list(times_inside(SCENARIO, 0, 1.0))
    assert len(rows) == 45
    assert time_inside(SCENARIO, 0, 1.0, 0.05) == math.inf
    assert time_inside(SCENARIO, 0, 1.0, 0.5) == pytest.approx(0.2741643, abs=1e-6)
    for before, after, time in rows:
        lower = time_inside(SCENARIO, 0, before, 0.9 * after)
        assert time <= lower
        assert time > time_inside(SCENARIO, 0, before, before)


def test_how_a_base_leaves():
    own = leaving(SCENARIO)
    assert own.roll == pytest.approx(0.05 * (1 - 0.2 * (1 - math.exp(-5))))
    assert own.least == pytest.approx(0.05 / 0.9)
    slow = override(SCENARIO, changes("limits.v_min = [-0.1, -2]; limits.v_max = [0.3, 2]"))
    assert leaving(slow) is None
    assert pull_away(slow) == pytest.approx(0.9 * 0.05 / 1.1 - 0.05)
    assert pull_away(slow, 1) == pytest.approx(0.9 * 0.25 / 1.1 - 0.05)
    assert fastest(slow) == 0.3
    assert leaving(override(SCENARIO, {"filter.d": [0, 0], "filter.rest": None})) is None


@pytest.mark.parametrize("changes", [{"filter.nearing": 0.2}, RAMPS])
def test_a_base_leaves_at_once_from_that_distance_alone(changes):
    scenario = override(SCENARIO, {"filter.leave": 0, **changes})
    for more in (1e-6, -1e-6):
        told = {"measured": (0.0, 0.0), "free": (leaves_from(scenario) + more, 9.0), "dt": 0.05}
        step = command_filter(scenario).step
        for _ in range(80):
            step((0.0, 0.0), **told)
        assert (step((-0.4, 0.0), **told).command[0] < 0) is (more > 0)


def test_what_a_push_rolls_back_during_a_stop():
    assert rolls_back(SCENARIO) == pytest.approx(0.05 * (0.03 + 0.05 + 1.0))
    assert rolls_back(override(SCENARIO, RAMPS)) == pytest.approx(0.05 * 1.08)


def test_the_window_of_a_stop_is_the_way_of_a_push():
    """d (delay + period + rest) and a release; a hold takes 19 commands, and an old distance."""
    turned, held = smallest_window(SCENARIO)
    assert turned == pytest.approx(0.05 * (0.03 + 0.05 + 1.0) + leaving(SCENARIO).roll)
    assert held == pytest.approx(turned + 0.05 * (19 * 0.05 + 0.2))
    ramps = override(SCENARIO, {**RAMPS, "filter.leave": 0})
    assert smallest_window(ramps)[0] == pytest.approx(0.05 * 1.08)
