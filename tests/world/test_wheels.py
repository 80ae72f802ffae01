"""Wheels of another size than believed."""

import casadi as ca
import numpy as np

from tests.world import twins
from tests.world.motion import EFFECTS, WHEELED, fed, rows, scenario
from wmr_ctrl.world.model.dynamics import wheel_to_force
from wmr_ctrl.world.wheels import WHEELS


def test_wheels_turn_torque_into_force_as_their_size_says():
    motion = rows(100, np.random.default_rng(8))
    shown = fed(WHEELS.build(scenario(EFFECTS["wheels"])), motion)
    forces = [wheel_to_force(ca.SX(0.1), ca.SX(0.25), ca.SX(torque)) for torque in shown.tolist()]
    wanted = [twins.wheels_twin(WHEELED, row) for row in motion]

    assert np.allclose([[float(f[0]), float(f[1])] for f in forces], wanted, rtol=1e-13)
