"""The spline behind rounded squares and waypoints."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from wmr_ctrl.world.references.spline import fit

WAVE = np.array([[0.0, 0.0], [1.0, 1.0], [2.0, -0.5], [3.0, 0.5], [5.0, 0.0]])
ENDS = np.array([0.0, 1.0])


@pytest.mark.parametrize("closed", [True, False])
def test_four_derivatives_are_continuous_at_the_knots(closed):
    path = fit(WAVE, 0.5, closed)
    for order in range(5):
        at = path.derivatives(order, ENDS)
        nexts = np.roll(at[:, 0], -1, axis=0)
        joints = slice(None) if closed and order > 0 else slice(-1)

        np.testing.assert_allclose(at[joints, 1], nexts[joints], atol=1e-9)


def test_ends_of_an_open_path_are_straight():
    path = fit(WAVE, 0.5, False)
    for order in (2, 3):
        at = path.derivatives(order, ENDS)

        np.testing.assert_allclose([at[0, 0], at[-1, 1]], 0, atol=1e-12)


@pytest.mark.parametrize("closed", [True, False])
def test_mean_speed_is_the_wanted_one(closed):
    path = fit(WAVE, 0.5, closed)

    def speed(s, i):
        return math.hypot(*path.derivatives(1, np.array([s]))[i, 0])

    lengths = [quad(speed, 0, 1, (i,))[0] * step for i, step in enumerate(np.diff(path.knots))]
    assert sum(lengths) == pytest.approx(0.5 * path.duration, rel=1e-3)
    assert (np.diff(path.knots) > 0).all()


def test_speed_is_even_where_points_are_close():
    angle = np.linspace(0, 1.5, 20)
    points = np.column_stack([np.sinh(angle), np.sin(3 * angle)])
    velocity = fit(points, 0.5, False).derivatives(1, np.linspace(0, 1, 50))

    np.testing.assert_allclose(np.hypot(velocity[..., 0], velocity[..., 1]), 0.5, rtol=0.06)


def test_points_on_a_circle_give_nearly_that_circle():
    angle = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    path = fit(np.column_stack([2 * np.sin(angle), 2 - 2 * np.cos(angle)]), 0.2, True)
    place = path.derivatives(0, np.linspace(0, 1, 50))

    np.testing.assert_allclose(np.hypot(place[..., 0], place[..., 1] - 2), 2, atol=1e-4)
    assert path.duration == pytest.approx(4 * math.pi / 0.2, rel=1e-5)
    assert path.turn == pytest.approx(2 * math.pi)
