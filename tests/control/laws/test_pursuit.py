"""Regulated pure pursuit: its arc, its speeds, and how it turns on the spot."""

import math
from itertools import product

import casadi as ca
import numpy as np
import pytest

from wmr_ctrl.control.laws.context import LawContext
from wmr_ctrl.control.laws.pursuit import point_ahead, wanted_velocity
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.model.system import stack
from wmr_ctrl.world.scenario import load_scenario

TOP = 0.95 * np.array((1.0, 1.5))
"""Share of the limits that is commanded at most."""
DESIRED = (0.3, -1.2, 0.4)
"""Desired pose."""


def pursuing(**gains):
    """Function of desired velocity, place in the reference's frame: wanted (2,), point (2,), L."""
    own = {f"gains.pursuit.{name}": value for name, value in gains.items()}
    setup = settle(load_scenario("paper-simulation-nominal", own), "pursuit")
    context = LawContext(setup)
    found = [wanted_velocity(context), *point_ahead(context)]
    p = context.parameters.ports
    u = stack(item.sym for item in context.inputs)
    graph = ca.Function("wanted", [u, stack(item.sym for item in p)], found)
    numbers = [number for item in p for number in item.value]

    def at(v1_d, v2_d, back=0.0, right=0.0, turned=0.0):
        theta = DESIRED[2]
        ahead = np.array((-math.sin(theta), math.cos(theta)))
        left = np.array((-math.cos(theta), -math.sin(theta)))
        place = np.array(DESIRED[:2]) - back * ahead - right * left
        pose = (*place, theta + turned)
        row = (*DESIRED, v1_d, v2_d, 0.0, 0.0, *pose, 0.0, 0.0)
        wanted, point, way = graph(row, numbers)
        return wanted.full().ravel(), point.full().ravel(), float(way)

    return at


def test_the_arc_that_it_drives_ends_at_the_point():
    """Also where it is scaled down to the limits, and where the turn slows it."""
    ways = [pursuing(turn_from=3.15, radius=radius, distance=[0.2, 0.4]) for radius in (0.0, 2.0)]
    speeds = []
    places = product(ways, (0.2, 0.6, 3.0), (-0.3, 0.0, 0.2), (-0.7, 0.0, 0.5))
    for at, back, right, turned in places:
        (v, omega), (ahead, left), _ = at(0.7, 0.1, back, right, turned)
        speeds.append((v, omega))
        bend = omega / v
        angle = 2 * math.atan2(left, ahead)
        reached = (math.sin(angle) / bend, (1 - math.cos(angle)) / bend) if bend else (ahead, 0.0)
        assert reached == pytest.approx((ahead, left), abs=1e-9)
    sizes = np.abs(speeds)
    assert (sizes <= TOP * (1 + 1e-12)).all()
    assert np.isclose(sizes, TOP).any(axis=0).all()


def test_tight_turns_are_slower_but_not_slower_than_its_slowest():
    wide, tight = pursuing(radius=0.0), pursuing(radius=5.0, slowest=0.1)
    for v2_d, share in ((0.2, 0.5), (0.0, 1.0), (0.5, 0.2)):
        free, held = wide(0.5, v2_d)[0], tight(0.5, v2_d)[0]
        assert held == pytest.approx(share * free, rel=1e-12)
    assert pursuing(radius=50.0, slowest=0.1)(0.5, 0.5)[0][0] == pytest.approx(0.1)
    assert tight(0.05, 0.05)[0][0] == pytest.approx(0.05)


@pytest.mark.parametrize("side", [-1, 1])
def test_far_from_where_it_looks_it_turns_on_the_spot_and_slower_than_the_limit(side):
    at = pursuing(turn=1.2, turn_from=0.5)

    assert at(0.2, 0.1, back=2.0, turned=-0.7 * side)[0] == pytest.approx((0.0, 1.2 * side))
    assert at(0.2, 0.1, back=2.0, turned=-0.3 * side)[0][0] > 0.2
    assert pursuing(turn=9.0)(0.2, 0.0, back=2.0, turned=-1.2 * side)[0][1] == side * TOP[1]


def test_ahead_of_the_reference_it_waits():
    (v, omega), *_ = pursuing(k=1.0)(0.2, 0.0, back=-0.25)

    assert (v, omega) == (0.0, 0.0)


def test_bounds_of_the_way_ahead_the_wrong_way_round_are_refused():
    with pytest.raises(ScenarioError, match=r"gains\.pursuit\.distance.*wrong way round"):
        pursuing(distance=[0.9, 0.3])


def test_pursuit_looks_no_farther_round_than_its_widest_angle():
    at = pursuing()
    for v1_d, v2_d, half in (
        (0.1, 2.0, 0.75),
        (0.1, -9.0, -0.75),
        (0.1, 1.0, 0.75),
        (0.4, 0.2, 0.15),
    ):
        _, seen, far = at(v1_d, v2_d)
        length = min(max(1.5 * v1_d, 0.3), 0.9)
        chord = length * math.sin(half) / half
        assert far == pytest.approx(length)
        assert seen == pytest.approx([chord * math.cos(half), chord * math.sin(half)])
