"""The layout for Foxglove (not tried in Foxglove): its form, panels, paths and fields.

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


def of_kind(kind):
    return [panel for name, panel in PANELS.items() if name.startswith(f"{kind}!")]


STEP = re.compile(r"\.(?P<field>\w+)|\[(?P<slice>:)\]|\{(?P<key>\w+)==\"(?P<value>[^\"]*)\"\}")


def inner(described):
    """Name of a type, or the element and length of a sequence."""
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


def test_plots_and_states_show_fields_of_messages_or_lines_at_limits():
    """A state is one value a message, and of one node: two nodes would alternate."""
    (states,) = of_kind("StateTransitions")
    plots = [path for panel in of_kind("Plot") for path in panel["paths"]]
    assert len(plots) == 10
    for path in plots + states["paths"]:
        assert path["timestampMethod"] in {"receiveTime", "headerStamp"}
        if not path["value"].startswith("/"):
            assert "limits" in path["label"]
            float(path["value"])
            continue
        kind, single = read(path["value"])
        assert kind not in FIELDS
        assert kind != "string" if path in plots else single
    assert all(any(node in path["value"] for path in states["paths"]) for node in NODES)
    (summary,) = of_kind("DiagnosticSummary")
    assert KINDS[summary["topicToRender"]] == "diagnostic_msgs/msg/DiagnosticArray"
