"""Motors: steps, dead zone, and less torque the faster a wheel turns."""

from tests.world import twins
from tests.world.motion import EFFECTS, assert_is_twin
from wmr_ctrl.world.motor import MOTOR

NUMBERS = {
    "step": 0.2,
    "dead_zone": 0.1,
    "stall": 20.0,
    "free": 30.0,
    "r": 0.1,
    "l": 0.25,
}


def test_it_is_its_twin():
    assert_is_twin(MOTOR, EFFECTS["motor"], lambda _, row: twins.motor_twin(NUMBERS, row))
