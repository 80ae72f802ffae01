"""The largest force and slope of friction agree with the graph used in runs."""

import casadi as ca
import numpy as np
import pytest

from wmr_ctrl.world.model.friction import friction, largest_force, largest_slope

SPEEDS = np.concatenate([[0.0], *(s * np.geomspace(1e-9, 1e3, 40_001) for s in (-1, 1))])
"""Speeds from rest to far beyond any robot's [m/s], in steps of 0.06 %."""
ROBOTS = [(0.1, 40.0, 9.81, 0.01), (0.9, 2.0, 1.62, 0.3), (0.02, 500.0, 9.81, 1e-3)]


def scanned(robot):
    """Force and slope of the graph at all speeds."""
    v = ca.SX.sym("v", 2)
    force = friction(*map(ca.SX, robot), v)
    graph = ca.Function("friction", [v], [force[0], ca.jacobian(force, v)[0, 0]])
    both = graph(np.stack([SPEEDS, np.zeros_like(SPEEDS)]))
    return np.asarray(both[0]).ravel(), np.asarray(both[1]).ravel()


@pytest.mark.parametrize("robot", ROBOTS)
def test_largest_force_and_slope_bound_the_graph_and_are_reached(robot):
    force, slope = scanned(robot)

    assert np.abs(force).max() == pytest.approx(largest_force(*robot[:3]), rel=1e-9)
    assert np.abs(slope).max() == pytest.approx(largest_slope(*robot), rel=1e-9)
