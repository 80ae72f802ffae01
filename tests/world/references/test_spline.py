"""The spline behind rounded squares and waypoints."""

import numpy as np
import pytest

from wmr_ctrl.world.references.spline import fit, simplified

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


@pytest.mark.parametrize("closed", [True, False])
def test_of_points_on_the_sides_of_a_polygon_its_corners_are_kept(closed):
    corners = np.array([[0.0, 0.0], [2.0, 0.0], [3.0, 1.0], [0.0, 1.0]])
    sides = zip(corners, np.roll(corners, -1, axis=0), strict=True)
    points = np.concatenate([np.linspace(a, b, 9)[:-1] for a, b in sides])
    ends = corners if closed else np.vstack([corners, points[-1:]])

    np.testing.assert_array_equal(simplified(points, 1e-6, closed), ends)
