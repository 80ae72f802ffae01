"""Commands in whole steps."""

import numpy as np
import pytest

from tests.world.motion import acting, based
from wmr_ctrl.world.command_quantum import COMMAND_QUANTUM


def test_a_quantum_is_off_by_half_a_step_at_most():
    wanted = np.random.default_rng(0).uniform(-1, 1, (200, 2))
    found = acting(based(quantum=[0.03, 0.0]), wanted)
    assert (found[:, 1] == wanted[:, 1]).all()
    assert np.abs(found[:, 0] - wanted[:, 0]).max() <= 0.015 + 1e-12
    assert found[:, 0] / 0.03 == pytest.approx(np.round(found[:, 0] / 0.03), abs=1e-9)
    assert COMMAND_QUANTUM.bounded(based(quantum=[0.03, 0.0])).command == (0.015, 0.0)
