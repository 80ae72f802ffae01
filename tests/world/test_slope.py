"""A plane that rises."""

from tests.world import twins
from tests.world.motion import EFFECTS, GROUND, assert_is_twin
from wmr_ctrl.world.slope import SLOPE

NUMBERS = {**GROUND, "angle": 0.03, "direction": 0.5, "offset": 0.02}


def test_it_is_its_twin():
    assert_is_twin(SLOPE, EFFECTS["slope"], lambda _, row: twins.slope_twin(NUMBERS, row))
