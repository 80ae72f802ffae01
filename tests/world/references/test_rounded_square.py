"""Squares with smoothed corners."""

import numpy as np
import pytest

from wmr_ctrl.world.references.rounded_square import RoundedSquare, square_path, square_points


@pytest.mark.parametrize("corner", [0.2, 1.5])
def test_it_is_a_square_that_looks_alike_from_every_side(corner):
    points = square_points(3.0, corner) - [0.0, 1.5]

    assert np.abs(points).max(axis=0) == pytest.approx([1.5, 1.5], abs=1e-12)
    quarter = len(points) // 4
    turned = points[:quarter] @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    assert points[quarter : 2 * quarter] == pytest.approx(turned, abs=1e-12)
    assert points[0] == pytest.approx([0.0, -1.5], abs=1e-12)
    below = points[points[:, 1] < -1.5 + 1e-9, 0]
    assert np.count_nonzero(below > 0) == np.count_nonzero(below < 0)


def test_points_are_dense_on_both_sides_of_a_corner():
    points = square_points(3.0, 0.2)
    lower = points[points[:, 1] < 1e-9, 0]
    right = points[points[:, 0] > 1.5 - 1e-9, 1]

    before, behind = np.sort(lower[lower > 0]), np.sort(right[right < 1.5])
    assert np.diff(before)[-1] == pytest.approx(np.diff(behind)[0])
    assert np.diff(behind)[0] < 0.2 * np.diff(behind)[-1]


def test_a_lap_takes_as_long_as_its_way_at_its_speed():
    square = RoundedSquare(side=3.0, corner=0.8, speed=0.25)
    sides = 4 * (3.0 - 2 * 0.8)

    assert square.cycle == square_path(square).duration
    assert sides + 4 * 0.8 * np.sqrt(2) < 0.25 * square.cycle < 12.0
