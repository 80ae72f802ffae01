"""Rolling resistance and viscous friction."""

from tests.world import twins
from tests.world.motion import EFFECTS, GROUND, assert_is_twin
from wmr_ctrl.world.resistance import RESISTANCE

NUMBERS = {**GROUND, "rolling": (0.01, 0.012), "viscous": (2.0, 0.1)}


def test_it_is_its_twin():
    assert_is_twin(
        RESISTANCE, EFFECTS["resistance"], lambda _, row: twins.resistance_twin(NUMBERS, row)
    )
