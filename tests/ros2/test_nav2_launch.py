"""Launch file for nav2's whole chain: its names, and our node as it starts it, over DDS."""

import xml.etree.ElementTree as ElementTree

import pytest

from tests.ros2.conftest import OVER_DDS, ROOT, Job
from tests.ros2.test_node import SCENARIO
from wmr_ctrl.ros2.parameters import FILTER

PACKAGE = ROOT / "ros" / "wmr_ctrl_ros"
LAUNCH = PACKAGE / "launch" / "nav2.launch.xml"
CHAIN = ("controller_server", "velocity_smoother", "collision_monitor", "wmr_filter")


def JOBS():
    words = (str(LAUNCH), str(PACKAGE / "config" / "filter.yaml"))
    return {"nav2": Job("stand_ins.py", f'{SCENARIO}\n[ros]\nbase_frame = "base_footprint"', words)}


def test_each_node_reads_what_the_one_before_sends():
    nodes = {item.get("name"): item for item in ElementTree.parse(LAUNCH).iter("node")}
    assert (*nodes,) == (*CHAIN, "lifecycle_manager_navigation")

    def given(name, kind, key, value):
        return {item.get(key): item.get(value) for item in nodes[name].iter(kind)}

    controller = given("controller_server", "remap", "from", "to")
    smoother = given("velocity_smoother", "remap", "from", "to")
    monitor = given("collision_monitor", "param", "name", "value")
    ours = given("wmr_filter", "remap", "from", "to")
    manager = given("lifecycle_manager_navigation", "param", "name", "value")

    assert controller["cmd_vel"] == smoother["cmd_vel"]
    assert monitor["cmd_vel_in_topic"] == "cmd_vel_smoothed"
    assert monitor["cmd_vel_out_topic"] == ours["cmd_vel_in"]
    assert manager["node_names"].strip("[]").split(", ") == list(CHAIN)
    assert manager["bond_timeout"] == "0.0"
    named = set(given("wmr_filter", "param", "name", "value")) - {None, "use_sim_time"}
    assert named <= set(FILTER)


@pytest.mark.slow
@OVER_DDS
def test_commands_of_the_controller_reach_the_base_within_the_filters_limit(report):
    found = report("nav2")

    assert found["commands"] > 20
    assert 0.8 < found["largest"] <= 0.95 / 1.1, "(v_u1 - d)/gain"
