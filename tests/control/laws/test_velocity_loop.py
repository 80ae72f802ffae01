"""The velocity loop below laws that command velocities."""

import casadi as ca
import numpy as np
import pytest

from tests.control.laws.points import DRIVING, T, at, graph
from tests.tables import changes
from wmr_ctrl.control.basis import ANY_BASIS
from wmr_ctrl.control.laws.velocity_loop import cut, loop_rule


def test_a_first_command_is_counted_from_the_measured_velocity_and_later_ones_from_the_last():
    base = changes("""
        base.kind = velocity
        base.tau = [0.1, 0.1]
        actuator.tau_max = 20.0
    """)
    system = graph("kanayama", **base)
    given = {**DRIVING, "v1": -0.3, "omega": 0.9, "v_sent_before[1]": 0.1, "v_sent_before[2]": 0.0}

    first, later = (at(system, given, {"started": [k]})[0] for k in (0.0, 1.0))

    most = np.array([2.0, 6.0]) * T
    assert np.abs(first - [-0.3, 0.9]) == pytest.approx(most)
    assert np.abs(later - [0.1, 0.0]) == pytest.approx(most)


def test_values_are_cut_to_their_size_either_way():
    found = ca.evalf(cut(ca.SX([3.0, -3.0]), ca.SX([2.0, 4.0]))).full().ravel()

    assert found == pytest.approx([2.0, -3.0])
    assert loop_rule(ANY_BASIS) == {"rate": ANY_BASIS.rate, "wo": 1.0, "a_max": (1.0, 1.0)}
