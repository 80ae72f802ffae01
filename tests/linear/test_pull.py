"""The barrier's pull: the audit's table, and runs on both sides of the threshold."""

import numpy as np
import pytest

from wmr_ctrl.theory.linear import pull_curve


def authority(scenario, law, axis, v_c0):
    """Largest outward force that a barrier resists from v = v_c1, and the speed of that peak."""
    u1, u2 = scenario.limits.v_u1[axis], scenario.limits.v_u2[axis]
    sign = -1.0 if v_c0 < 0 else 1.0
    near = u1 - (u1 - min(abs(v_c0), u2)) * np.linspace(0, 1, 4000)[1:] ** 2
    kink = u2 * np.array((1 - 1e-12, 1, 1 + 1e-12))
    v = sign * np.sort(np.append(near, kink))
    pull = sign * pull_curve(scenario, law, axis, v_c0, v)
    return -pull.min(), v[pull.argmin()]


TABLE = [
    (0.2, 225.0, 0.800, 171.0, 1.300),
    (-0.2, 225.0, -0.800, 171.0, -1.300),
    (2.0, 51.31, 0.9252, 21.97, 1.4258),
    (7.17, 25.74, 0.9501, 11.57, 1.4459),
]


@pytest.mark.parametrize("c, force, v1, moment, omega", TABLE)
def test_authority_of_the_audit(nominal, c, force, v1, moment, omega):
    thrust, turn = (authority(nominal, "mb", axis, c) for axis in (0, 1))

    assert (thrust[0], turn[0]) == pytest.approx((force, moment), rel=4e-3)
    assert (thrust[1], turn[1]) == pytest.approx((v1, omega), abs=2e-4)
