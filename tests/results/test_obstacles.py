"""Distances from obstacles."""

import math

import casadi as ca
import numpy as np
import pytest

from wmr_ctrl.results.obstacles import closest, distance

SQUARE = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))


def test_distances_from_a_square_are_those_of_its_sides_and_corners():
    points = np.array([[2.0, 0.5], [2.0, 2.0], [0.5, 0.75], [-3.0, -4.0], [1.0, 0.5]])

    assert distance(SQUARE, *points.T) == pytest.approx([1.0, math.sqrt(2), -0.25, 5.0, 0.0])


def test_distance_is_lipschitz_and_does_not_depend_on_where_the_polygon_begins():
    rng = np.random.default_rng(1)
    a, b = rng.uniform(-2, 3, size=(2, 500, 2))
    turned, backwards = SQUARE[2:] + SQUARE[:2], SQUARE[::-1]

    assert (
        np.abs(distance(SQUARE, *a.T) - distance(SQUARE, *b.T)) <= np.hypot(*(a - b).T) + 1e-12
    ).all()
    for same in (turned, backwards):
        assert distance(same, *a.T) == pytest.approx(distance(SQUARE, *a.T), abs=1e-12)


def test_the_closest_of_all_is_named_with_its_point():
    points = np.array([[9.0, 9.0], [3.0, 0.5], [4.0, 3.5]])

    assert closest([SQUARE, (5.0, 3.5, 0.25)], points) == (0.75, 1, 2)
    assert closest([SQUARE, (5.0, 3.5, 0.25)], points[:2]) == (2.0, 0, 1)


def test_distances_of_expressions_are_those_of_numbers():
    rng, place = np.random.default_rng(2), ca.SX.sym("place", 2)
    corner = ((0.0, 3.0), (2.0, 3.0), (2.0, 5.0), (1.0, 4.0), (0.0, 5.0))
    points = np.vstack([rng.uniform(-2, 6, size=(500, 2)), rng.integers(-1, 6, size=(60, 2))])
    for shape in (SQUARE, corner, ((5.0, -2.0), (5.0, 2.0)), (3.0, 1.0, 0.5)):
        graph = ca.Function("away", [place], [distance(shape, place[0], place[1], ca)])
        assert graph(points.T).full()[0] == pytest.approx(distance(shape, *points.T), abs=1e-12)
