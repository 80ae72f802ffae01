"""Distances from obstacles."""

import math

import numpy as np
import pytest

from wmr_ctrl.results.obstacles import closest, distance

SQUARE = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))


def test_distances_from_a_square_are_those_of_its_sides_and_corners():
    points = np.array([[2.0, 0.5], [2.0, 2.0], [0.5, 0.75], [-3.0, -4.0], [1.0, 0.5]])

    assert distance(SQUARE, points) == pytest.approx([1.0, math.sqrt(2), -0.25, 5.0, 0.0])


def test_distance_is_lipschitz_and_does_not_depend_on_where_the_polygon_begins():
    rng = np.random.default_rng(1)
    a, b = rng.uniform(-2, 3, size=(2, 500, 2))
    turned, backwards = SQUARE[2:] + SQUARE[:2], SQUARE[::-1]

    assert (np.abs(distance(SQUARE, a) - distance(SQUARE, b)) <= np.hypot(*(a - b).T) + 1e-12).all()
    for same in (turned, backwards):
        assert distance(same, a) == pytest.approx(distance(SQUARE, a), abs=1e-12)


def test_the_closest_of_all_is_named_with_its_point():
    points = np.array([[9.0, 9.0], [3.0, 0.5], [4.0, 3.5]])

    assert closest([SQUARE, (5.0, 3.5, 0.25)], points) == (0.75, 1, 2)
    assert closest([SQUARE, (5.0, 3.5, 0.25)], points[:2]) == (2.0, 0, 1)
