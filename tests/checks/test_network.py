"""When learning is unstable."""

import numpy as np
import pytest

from wmr_ctrl.theory.checks.network import largest_square, learning_limit, square_bound
from wmr_ctrl.theory.checks.radius import radius

ETA = "gains.nn.eta"


@pytest.mark.parametrize("eta2, square", [(1, 0.0070), (2, 0.319), (4, 2.79), (10, 15.0)])
def test_regressor_size_by_width(loop, eta2, square):
    assert largest_square(loop("nn"), eta2**0.5) == pytest.approx(square, rel=1e-2)


def test_bound_on_the_regressor(loop):
    assert square_bound(loop("nn"), 1) == pytest.approx(0.054)
    assert square_bound(loop("nn"), 0) == float("inf")


@pytest.mark.parametrize(
    "eta2, node, warned",
    [(1.37, 1, False), (1.376, 1, True), (0.512, 0.5, False), (0.515, 0.5, True)],
)
def test_warns_from_the_audited_width_on(told, eta2, node, warned):
    network = {ETA: eta2**0.5, "gains.nn.node": node}

    assert bool(told("nn", network, key=ETA)) is warned


@pytest.mark.parametrize(
    "size, linear, angular",
    [(1, 0.0362, 0.0140), (4, 0.0095, 0.0035), (16, 0.0024, 0.00087), (64, 0.00060, 0.00022)],
)
def test_longest_period_for_the_steps_of_the_weights(loop, size, linear, angular):
    limits = [learning_limit(loop("nn"), axis, size) for axis in (0, 1)]

    assert limits == pytest.approx([linear, angular], rel=2e-2)


@pytest.mark.parametrize("axis", [0, 1])
def test_the_learning_limit_is_where_the_law_s_graph_becomes_unstable(loop, axis):
    """Velocity and weights of one axis, by the gradient of the law with its weights moving."""
    at, setup = loop("nn"), loop("nn").setup
    point = at.on_reference((0.2, 0.1))
    size, mass = largest_square(at, setup.gains.eta), (at.scenario.robot.m, at.scenario.robot.I)
    limit, column = learning_limit(at, axis, size), 3 + axis

    def largest(period):
        law = at.linear(point, period, learning=True)
        speed = 1 + period / mass[axis] * law.d[axis, column]
        pull = period / mass[axis] * law.c[axis]
        return radius(np.block([[speed, pull], [law.b[:, [column]], law.a]]))

    assert largest(0.97 * limit) < 1 < largest(1.03 * limit)
