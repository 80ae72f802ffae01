"""Extra files of an FMU."""

import pytest

from wmr_ctrl.export.fmi.blocks import plant_model
from wmr_ctrl.export.fmi.extra import _seconds
from wmr_ctrl.world.scenario import load_scenario


@pytest.mark.parametrize("duration, seconds", [(0.5, 0.5), (80.0, 2.0)])
def test_a_reference_result_is_no_longer_than_the_run(duration, seconds):
    short = load_scenario("paper-simulation-nominal", {"clock.duration": duration})

    assert _seconds(plant_model(short)) == seconds
