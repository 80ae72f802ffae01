"""The layout for Foxglove, which nobody has seen in Foxglove: its form, panels, paths and fields.

The form is that of Foxglove Studio's own type definitions (version 1, MPL 2.0), stated again here.
"""

import json
import re

import pytest

from tests.ros2.test_colcon import PACKAGE

typesys = pytest.importorskip("rosbags.typesys", reason="NOT RUN: rosbags is not there")

FIELDS = typesys.get_typestore(typesys.Stores.ROS2_JAZZY).fielddefs
LAYOUT = json.loads((PACKAGE / "foxglove" / "wmr_ctrl.json").read_text("utf-8"))
PANELS = LAYOUT["configById"]
NODES = {"/wmr_filter", "/wmr_drive"}
"""Full names of the nodes, which are those of their diagnostics."""
KINDS = {
    "/cmd_vel_in": "geometry_msgs/msg/TwistStamped",
    "/cmd_vel": "geometry_msgs/msg/TwistStamped",
    "/odom": "nav_msgs/msg/Odometry",
    "/path": "nav_msgs/msg/Path",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
}
"""Topics of the nodes, by the page that says so."""
STAMPS = {"receiveTime", "headerStamp"}
INTEGERS = {f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)}
NUMBERS = {"float32", "float64", "bool"} | INTEGERS
STATES = {"bool", "string", "byte"} | INTEGERS
"""What is a state: whatever has no fraction; a byte of ROS 2 is an unsigned one."""


def of_kind(kind):
    return [panel for name, panel in PANELS.items() if name.startswith(f"{kind}!")]


STEP = re.compile(r"\.(?P<field>\w+)|\[(?P<slice>:)\]|\{(?P<key>\w+)==\"(?P<value>[^\"]*)\"\}")


def inner(described):
    """Name of a type; of a sequence, what it holds and its length."""
    sort, what = described
    return what[0] if sort == typesys.base.Nodetype.BASE else what


def read(path):
    """Type at the end of a message path, and whether it is one value a message."""
    topic = re.match(r"/\w+", path)[0]
    steps = [*STEP.finditer(path, len(topic))]
    assert topic + "".join(step[0] for step in steps) == path
    kind, single = KINDS[topic], True
    for step in steps:
        if step["field"]:
            kind = inner(dict(FIELDS[kind][1])[step["field"]])
        elif step["slice"]:
            kind, single = inner(kind[0]), False
        else:  # of several, those that are named so
            assert step["key"] in dict(FIELDS[kind][1])
            assert step["value"] in NODES
            single = True
    return kind, single


def test_plots_show_numbers_of_the_messages_and_lines_at_limits():
    shown = [path for panel in of_kind("Plot") for path in panel["paths"]]
    assert len(shown) == 10
    for path in shown:
        assert set(path) == {"value", "enabled", "label", "timestampMethod"}
        assert path["timestampMethod"] in STAMPS
        if path["value"].startswith("/"):
            assert read(path["value"])[0] in NUMBERS
        else:
            assert "limits" in path["label"]
            float(path["value"])
    assert all(panel["xAxisVal"] == "timestamp" for panel in of_kind("Plot"))


def test_states_are_one_value_a_message_and_of_one_node():
    """A message with none or several values is left out, and two nodes would take turns."""
    (panel,) = of_kind("StateTransitions")
    for path in panel["paths"]:
        assert set(path) == {"value", "label", "timestampMethod"}
        assert path["timestampMethod"] in STAMPS
        kind, single = read(path["value"])
        assert kind in STATES
        assert single
    assert all(any(node in path["value"] for path in panel["paths"]) for node in NODES)


def test_diagnostics_are_those_of_the_nodes():
    (panel,) = of_kind("DiagnosticSummary")
    assert KINDS[panel["topicToRender"]] == "diagnostic_msgs/msg/DiagnosticArray"
