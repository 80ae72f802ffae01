"""The spline behind rounded squares and waypoints."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from wmr_ctrl.scenario.spline import fit
from wmr_ctrl.scenario.square import square_points

WAVE = np.array([[0.0, 0.0], [1.0, 1.0], [2.0, -0.5], [3.0, 0.5], [5.0, 0.0]])
ENDS = np.array([0.0, 1.0])


@pytest.mark.parametrize("closed", [True, False])
def test_four_derivatives_are_continuous_at_the_knots(closed):
    path = fit(WAVE, 0.5, closed)
    for order in range(5):
        at = path.derivatives(order, ENDS)
        nexts = np.roll(at[:, 0], -1, axis=0)
        jumps = np.abs(at[:, 1] - nexts) if closed else np.abs(at[:, 1] - nexts)[:-1]

        assert jumps.max() < 1e-9


def test_ends_of_an_open_path_are_straight():
    path = fit(WAVE, 0.5, False)
    for order in (2, 3):
        at = path.derivatives(order, ENDS)

        np.testing.assert_allclose([at[0, 0], at[-1, 1]], 0, atol=1e-12)


@pytest.mark.parametrize("closed", [True, False])
def test_every_segment_is_driven_at_the_mean_speed(closed):
    path = fit(WAVE, 0.5, closed)
    for i, length in enumerate(np.diff(path.knots)):

        def speed(s, i=i):
            return math.hypot(*path.derivatives(1, np.array([s]))[i, 0])

        assert quad(speed, 0, 1)[0] == pytest.approx(0.5, rel=0.02)
        assert length > 0


def test_points_on_a_circle_give_nearly_that_circle():
    angle = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    path = fit(np.column_stack([2 * np.sin(angle), 2 - 2 * np.cos(angle)]), 0.2, True)
    place = path.derivatives(0, np.linspace(0, 1, 50))

    np.testing.assert_allclose(np.hypot(place[..., 0], place[..., 1] - 2), 2, atol=1e-4)
    assert path.duration == pytest.approx(4 * math.pi / 0.2, rel=1e-5)
    assert path.turn == pytest.approx(2 * math.pi)


def test_square_has_the_symmetry_of_a_square():
    points = square_points(3.0, 0.8)
    quarter = len(points) // 4
    turned = np.column_stack([1.5 - points[:, 1], 1.5 + points[:, 0]])

    np.testing.assert_allclose(turned[:quarter], points[quarter : 2 * quarter], atol=1e-12)
    np.testing.assert_allclose(points[0], [0.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(points[quarter], [1.5, 1.5], atol=1e-12)
