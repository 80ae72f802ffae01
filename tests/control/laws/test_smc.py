"""The adaptive sliding mode."""

import math

import numpy as np
import pytest

from tests.control.laws.points import DRIVING, T, at, graph
from wmr_ctrl.control.laws.smc import LAW


def test_estimates_learn_by_the_error_and_the_force_adds_what_is_learnt():
    """Two memories tell what the estimates weigh: the rate of v_c0, and the shape of friction."""
    system = graph(LAW.name)
    slow = {**DRIVING, "v1": 0.008, "omega": 0.005}
    nothing, after = at(system, slow)
    learnt, _ = at(system, slow, {"m_hat": [2.0, 0.0], "F_hat": [0.0, 3.0]})

    shape = np.tanh(np.array([0.008, 0.005]) / 0.01)
    (linear, turning) = learnt - nothing
    assert turning == pytest.approx(3.0 * shape[1])
    s = after[2:] / (T * np.array([1.0, 0.1]) * 50.0 * shape)
    assert nothing == pytest.approx(
        [200.0 * s[0], 20.0 * s[1]] + np.array([5.0, 0.5]) * np.clip(s / 0.1, -1, 1)
    )
    assert after[:2] == pytest.approx([T * 0.5 * s[0] * linear / 2.0, after[1]])
    assert math.copysign(1, after[2]) == math.copysign(1, s[0])
