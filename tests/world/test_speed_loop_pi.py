"""The PI speed loop."""

import pytest

from tests.world.motion import based
from tests.world.test_speed_loops import forced
from wmr_ctrl.world.scenario import override
from wmr_ctrl.world.speed_loop_pi import PI


@pytest.mark.parametrize(
    "most, antiwindup, rate",
    [(1e6, True, [30.0, 7.5]), (1.0, False, [30.0, 7.5]), (1.0, True, [0.0, 0.0])],
)
def test_the_integral_rests_where_the_wheels_miss_what_it_would_add(most, antiwindup, rate):
    """An error of 0.1 m/s and 0.4 rad/s; the latter's moment has the factor l^2 = 1/16."""
    gains = {"loop": "pi", "kp": 150.0, "ki": 300.0, "antiwindup": antiwindup}
    base = override(based(**gains), {"actuator.tau_max": most})

    force, after = forced(base, [0.1, 0.4, 0.0, 0.0], [0.0, 0.0, 2.0, 0.5])

    if most > 1.0:
        assert force == pytest.approx((15.0 + 2.0, 150 * 0.4 / 16 + 0.5))
    assert (after[2:] - [2.0, 0.5]) / 0.001 == pytest.approx(rate)
    assert PI.overshoots
