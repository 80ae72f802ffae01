"""The gyro's graph against its formula."""

import pytest

from wmr_ctrl.world.gyro import GYRO
from wmr_ctrl.world.scenario import load_scenario

NUMBERS = {"gyro.enabled": True, "gyro.bias": 0.02, "gyro.noise": 0.3}


@pytest.mark.parametrize("omega, drawn", [(0.7, 0.0), (-0.4, 1.0), (0.0, -0.25)])
def test_it_shows_omega_and_its_bias_and_its_noise(omega, drawn):
    system = GYRO.build(load_scenario("paper-simulation", NUMBERS))
    shown = system.function("shown", [system.y])([omega], [], system.p0, [drawn, 0.0])

    assert float(shown) == pytest.approx(omega + 0.02 + 0.3 * drawn, abs=1e-15)
