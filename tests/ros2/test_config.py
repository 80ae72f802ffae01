"""Files of parameters that the package for ROS 2 ships have what nodes take without them."""

from pathlib import Path

import pytest
import yaml

from wmr_ctrl.control.filter.gate import ODOMETRY_USES
from wmr_ctrl.ros2.parameters import DRIVE, FILTER

SHIPPED = Path(__file__).parents[2] / "ros" / "wmr_ctrl_ros" / "config"


@pytest.mark.parametrize(("name", "declared"), [("filter", FILTER), ("drive", DRIVE)])
def test_a_shipped_file_states_each_nodes_own_values(name, declared):
    stated = yaml.safe_load((SHIPPED / f"{name}.yaml").read_text(encoding="utf-8"))
    values = stated["/**"]["ros__parameters"]

    assert values == {key: declared[key].default for key in values}
    assert set(declared) - set(values) <= {"scenario", "law", "autostart"}


def test_uses_of_odometry_are_those_of_the_gate():
    assert tuple(FILTER["odometry"].choices) == ODOMETRY_USES
