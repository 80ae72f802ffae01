"""The torque that really acted, behind delay and lag."""

import casadi as ca
import numpy as np
import pytest

from wmr_ctrl.control.applied import followed, is_partial


@pytest.mark.parametrize("part", [0, 3, 9])
@pytest.mark.parametrize("decay", [0.0, 0.9])
def test_a_torque_that_is_followed_is_that_of_every_step(part, decay):
    """Commands of two ages act one after the other, the older one first, behind a lag."""
    commands, steps, acting = (
        [np.array(pair) for pair in ((3.0, -1.0), (1.0, 2.0), (-4.0, 0.5))],
        10,
        np.zeros(2),
    )
    mean, end = followed(commands, (1, part, steps), acting, decay)
    total = np.zeros(2)
    for k in range(steps):
        wanted = commands[2] if k < part else commands[1]
        acting = wanted + decay * (acting - wanted)
        total += acting

    assert np.asarray(mean) == pytest.approx(total / steps)
    assert np.asarray(end) == pytest.approx(acting)


def test_a_symbol_stands_for_some_steps():
    assert [is_partial(part) for part in (0, 3, ca.SX.sym("part"))] == [False, True, True]
