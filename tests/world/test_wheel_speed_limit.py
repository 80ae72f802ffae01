"""The limit of the wheels' speeds."""

import numpy as np
import pytest

from tests.world.motion import acting, based
from wmr_ctrl.world.wheel_speed_limit import WHEEL_SPEED_LIMIT


def test_a_wheel_limit_couples_both_axes_and_lets_neither_grow():
    wanted = np.random.default_rng(1).uniform(-3, 3, (500, 2))
    found = acting(based(w_max=8.0), wanted)
    wheels = np.column_stack([found @ [1.0, 0.25], found @ [1.0, -0.25]])
    free = np.column_stack([wanted @ [1.0, 0.25], wanted @ [1.0, -0.25]])
    assert wheels == pytest.approx(np.clip(free, -0.8, 0.8))
    assert (np.abs(found) <= np.abs(wanted) + 1e-12).all()
    assert (found * wanted >= -1e-12).all()
    assert "clips" in WHEEL_SPEED_LIMIT.bounded(based(w_max=8.0)).hidden
