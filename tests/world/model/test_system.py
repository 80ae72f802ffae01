"""Systems: their shapes, symbols and draws."""

import casadi as ca
import pytest

from wmr_ctrl.core.signals import MEASURED_VELOCITY, TIME, TORQUE, Signal
from wmr_ctrl.world.model.system import NORMAL, Output, System, draw, port, ports


def test_random_numbers_come_in_pairs():
    wanted = ca.SX(1)

    assert draw(Signal("two", "1", "a pair", 2), NORMAL, wanted).port.signal.size == 2
    for size in (1, 3):
        with pytest.raises(ValueError, match=f"come in pairs, not {size}"):
            draw(Signal("odd", "1", "no pair", size), NORMAL, wanted)
    assert len(ports(MEASURED_VELOCITY)) == 2


def test_a_system_has_as_many_updates_as_states_and_only_its_own_symbols():
    state, free = port(TIME), ca.SX.sym("free")

    with pytest.raises(ValueError, match="toy: 2 rows of update, 1 of state"):
        System("toy", "toy", state=(state,), update=ca.SX(2, 1))
    with pytest.raises(ValueError, match="toy: t has 2 elements"):
        System("toy", "toy", outputs=(Output(TIME, ca.SX(2, 1)),))
    with pytest.raises(ValueError, match="toy: free belongs to no port"):
        System("toy", "toy", inputs=ports(TORQUE), outputs=(Output(TIME, free),))
