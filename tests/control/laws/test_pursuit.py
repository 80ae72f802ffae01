"""Regulated pure pursuit: its arc, its speeds, and how it turns on the spot."""

import math
from itertools import product

import casadi as ca
import numpy as np
import pytest

from tests.control.laws.points import assert_twin
from tests.papers_robot import paper
from tests.tables import changes
from wmr_ctrl.control.laws.context import LawContext
from wmr_ctrl.control.laws.pursuit import LAW, point_ahead, wanted_velocity
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.model.system import stack, values
from wmr_ctrl.world.scenario import override

TOP = 0.95 * np.array((1.0, 1.5))
"""Share of the limits that is commanded at most."""


def pursuing(gains):
    """Function of a place behind, right of and turned from a reference: wanted (2,), point (2,)."""
    context = LawContext(settle(override(paper(), changes(gains)), "pursuit"))
    found = [wanted_velocity(context), point_ahead(context)[0]]
    ports = context.parameters.ports
    u, p = (stack(item.sym for item in group) for group in (context.inputs, ports))
    graph, numbers = ca.Function("wanted", [u, p], found), values(ports)

    def at(back, right=0.0, turned=0.0, v_d=(0.2, 0.0)):
        row = (0.0, 0.0, 0.0, *v_d, 0.0, 0.0, right, -back, turned, 0.0, 0.0)
        return [item.full().ravel() for item in graph(row, numbers)]

    return at


def test_the_arc_that_it_drives_ends_at_the_point():
    """Also if it is scaled down to the limits, or slowed by the turn."""
    own = "gains.pursuit.turn_from = 3.15; gains.pursuit.distance = [0.2, 0.4]"
    ways = [pursuing(f"{own}; gains.pursuit.radius = {radius}") for radius in (0.0, 2.0)]
    speeds = []
    for at, *place in product(ways, (0.2, 0.6, 3.0), (-0.3, 0.0, 0.2), (-0.7, 0.0, 0.5)):
        (v, omega), (ahead, left) = at(*place, v_d=(0.7, 0.1))
        speeds.append((v, omega))
        bend = omega / v
        angle = 2 * math.atan2(left, ahead)
        reached = (math.sin(angle) / bend, (1 - math.cos(angle)) / bend) if bend else (ahead, 0.0)
        assert reached == pytest.approx((ahead, left), abs=1e-9)
    sizes = np.abs(speeds)
    assert (sizes <= TOP * (1 + 1e-12)).all()
    assert np.isclose(sizes, TOP).any(axis=0).all()


@pytest.mark.parametrize(
    "gains",
    ["", "radius = 5.0; slowest = 0.1; turn_from = 3.15", "turn = 1.2; turn_from = 0.5", "k = 3.0"],
)
def test_speeds_turns_and_the_way_ahead_are_those_of_its_formulas(gains):
    """Tight turns are slower, but not below the floor ``slowest``; the angle ahead has a
    maximum.
    """
    assert_twin(LAW.name, 200, **{f"gains.pursuit.{key}": x for key, x in changes(gains).items()})


@pytest.mark.parametrize("side", [-1, 1])
def test_far_from_where_it_looks_it_turns_on_the_spot_and_slower_than_the_limit(side):
    at = pursuing("gains.pursuit.turn = 1.2; gains.pursuit.turn_from = 0.5")

    assert at(2.0, turned=-0.7 * side)[0] == pytest.approx((0.0, 1.2 * side))
    assert at(2.0, turned=-0.3 * side)[0][0] > 0.2
    assert pursuing("gains.pursuit.turn = 9")(2.0, turned=-1.2 * side)[0][1] == side * TOP[1]


def test_ahead_of_the_reference_it_waits():
    assert pursuing("gains.pursuit.k = 1")(-0.25)[0].tolist() == [0.0, 0.0]


def test_bounds_of_the_way_ahead_the_wrong_way_round_are_refused():
    with pytest.raises(ScenarioError, match=r"gains\.pursuit\.distance.*wrong way round"):
        pursuing("gains.pursuit.distance = [0.9, 0.3]")
