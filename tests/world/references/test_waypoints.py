"""Waypoints: omitted points, and closed paths."""

import numpy as np
import pytest

from tests.papers_robot import paper
from wmr_ctrl.world.references.waypoints import waypoint_path
from wmr_ctrl.world.scenario import override


def way(**changed):
    return override(paper(), {"reference.kind": "waypoints", **changed}).reference


def test_of_many_points_half_of_the_tolerance_is_for_those_left_out():
    """A corner between 250 points on either side is cut by the other half."""
    side = np.linspace(0.0, 2.0, 250)
    points = [*([x, 0.0] for x in side), *([2.0, y] for y in side[1:])]
    few, many = (
        waypoint_path(way(**{"reference.points": own, "reference.tolerance": 0.2}))
        for own in ([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0]], points)
    )

    cut = [
        float(np.hypot(*(path.derivatives(0, np.linspace(0, 1, 401)) - [2.0, 0.0]).T).min())
        for path in (few, many)
    ]
    assert cut == pytest.approx([0.2, 0.1], rel=0.02)


def test_a_closed_path_may_name_its_first_point_once_more():
    square = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]
    closed = {"reference.closed": True, "reference.tolerance": 0.3}
    once, twice = (
        waypoint_path(way(**{"reference.points": own, **closed}))
        for own in (square, [*square, square[0]])
    )

    assert np.array_equal(once.coefficients, twice.coefficients)
