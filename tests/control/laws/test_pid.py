"""The PID law."""

import numpy as np
import pytest

from tests.control.laws.points import DRIVING, T, at, graph
from wmr_ctrl.control.basis import ANY_BASIS
from wmr_ctrl.control.laws.pid import LAW, rule


def test_pid_begins_without_a_difference():
    system = graph(LAW.name)
    old = np.array([0.3, -0.2])
    first, later = (at(system, DRIVING, {"started": [k], "z_previous": old})[0] for k in (0.0, 1.0))
    _, after = at(system, DRIVING)
    z = after[:2]

    assert first == pytest.approx(-np.array([210.0, 1.1]) * z)
    assert later == pytest.approx(first - np.array([0.64, 0.08]) * (z - old) / T)


def test_gains_that_follow_damp_and_differentiate_nothing():
    assert rule(ANY_BASIS) == {"Kp": ANY_BASIS.damping, "Kd": (0.0, 0.0)}
