"""The second-order speed loop, against the exponential of its equation."""

import numpy as np
import pytest
from scipy.linalg import expm

from tests.world.motion import based
from tests.world.test_speed_loops import forced
from wmr_ctrl.world.speed_loop_second_order import SECOND_ORDER


@pytest.mark.parametrize("damping", [0.05, 1.0, 1.0 + 1e-9, 1.5, 2.5])
def test_over_a_step_it_goes_where_its_equation_does(damping):
    w, gain, u, v, a = np.array([8.0, 15.0]), 1.1, [0.5, 1.0], [0.3, -0.2], [0.7, -0.4]
    base = based(loop="second-order", frequency=[*w], damping=[damping] * 2, gain=[gain] * 2)

    force, after = forced(base, [*u, *v], [0.0, 0.0, *a])

    friction, mass = (0.08 * 50.0 * 9.81, 0.0), (50.0, 5.4)
    for i in range(2):
        matrix = [[0.0, 1.0], [-(w[i] ** 2), -2 * damping * w[i]]]
        off, reached = expm(0.001 * np.array(matrix)) @ [v[i] - gain * u[i], a[i]]
        moved = off + gain * u[i] - v[i]
        assert force[i] == pytest.approx(mass[i] * moved / 0.001 + friction[i], rel=1e-9)
        assert after[2 + i] == pytest.approx(reached, rel=1e-9)
    assert SECOND_ORDER.overshoots
