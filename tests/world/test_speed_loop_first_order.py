"""The first-order speed loop."""

import math

import pytest

from tests.world.motion import based
from tests.world.test_speed_loops import forced
from wmr_ctrl.world.speed_loop_first_order import reach


def test_it_pulls_as_far_as_a_first_order_goes_in_a_step_and_holds_friction():
    base = based(tau=[0.2, 0.1], gain=[1.1, 0.9])
    (thrust, moment), _ = forced(base, [0.5, 1.0, 0.3, -0.2], [0.0, 0.0])

    s = [0.001 / (1 - math.exp(-0.001 / tau)) for tau in (0.2, 0.1)]
    pull = 50.0 * (1.1 * 0.5 - 0.3) / s[0] + 0.08 * 50.0 * 9.81
    assert thrust == pytest.approx(pull, rel=1e-12)
    assert moment == pytest.approx(5.4 * (0.9 + 0.2) / s[1], rel=1e-12)
    assert float(reach(0.001, 0.2)) == pytest.approx(s[0], rel=1e-12)
