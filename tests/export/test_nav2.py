"""Parameters of nav2 from an identified base."""

from types import SimpleNamespace

import pytest

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.export.nav2 import nav2_of
from wmr_ctrl.identification.bounds import DETERMINED


def base(section="filter", **values):
    found = {
        name: SimpleNamespace(value=value, verdict=DETERMINED) for name, value in values.items()
    }
    return SimpleNamespace(name="drive", bounds=SimpleNamespace(section=section), parameters=found)


def test_limits_are_those_of_the_base_and_what_is_not_known_is_a_comment():
    text = nav2_of(base(accel1=1.0, accel2=2.0, decel2=1.5, delay1=0.1, delay2=0.20001))

    assert "      model_delay: 0.2\n" in text
    assert "      ax_max: 1.0\n" in text
    assert "      ax_min: -1.0\n" in text
    assert "      az_max: 1.5\n" in text
    assert "    max_accel: [1.0, 0.0, 2.0]\n" in text
    assert "    max_decel: [-1.0, -0.0, -1.5]\n" in text or "[-1.0, 0.0, -1.5]" in text
    assert "      # model_delay: the log shows none" in nav2_of(base())
    assert "deadband_velocity: [0.1, 0.0, 0.0]" in nav2_of(base(dead1=0.1, gain1=0.9, gain2=1.1))


def test_a_base_that_takes_torques_is_refused():
    with pytest.raises(ArgumentError, match="nav2 sends velocities, and this base takes torques"):
        nav2_of(base("robot"))
