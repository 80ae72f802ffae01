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
NUMBERS = {
    "float32",
    "float64",
    "bool",
    *(f"{u}int{n}" for u in ("", "u") for n in (8, 16, 32, 64)),
}
STATES = NUMBERS - {"float32", "float64"} | {"string", "byte"}
"""What is a state: whatever has no fraction; a byte of ROS 2 is an unsigned one."""
SHAPES = {
    "Plot": {
        "title": str, "paths": list, "showXAxisLabels": bool, "showYAxisLabels": bool,
        "showLegend": bool, "legendDisplay": str, "isSynced": bool, "xAxisVal": str,
        "followingViewWidth": (int, float),
    },
    "StateTransitions": {"isSynced": bool, "paths": list},
    "DiagnosticSummary": {
        "minLevel": int, "pinnedIds": list, "topicToRender": str, "hardwareIdFilter": str,
        "sortByLevel": bool,
    },
    "3D": {
        "cameraState": dict, "followMode": str, "followTf": str, "scene": dict, "transforms": dict,
        "topics": dict, "layers": dict,
    },
}  # fmt: skip
"""Keys of a panel's settings that are used here, and the type of each."""
DRAWN = {"nav_msgs/msg/Odometry", "nav_msgs/msg/Path"}
"""Types of messages that the panel 3D draws; it has more."""


def kind_of(panel):
    return panel.partition("!")[0]


def of_kind(kind):
    return [settings for name, settings in PANELS.items() if kind_of(name) == kind]


def leaves(node):
    """Panels of a tree of pairs, whose form is checked."""
    if isinstance(node, str):
        return [node]
    assert {"direction", "first", "second"} <= set(node)
    assert set(node) <= {"direction", "first", "second", "splitPercentage"}
    assert node["direction"] in ("row", "column")
    assert 0 < node.get("splitPercentage", 50) < 100
    return [*leaves(node["first"]), *leaves(node["second"])]


def test_it_has_the_form_of_a_layout_and_shows_each_panel_once():
    assert set(LAYOUT) == {"configById", "globalVariables", "userNodes", "playbackConfig", "layout"}
    assert sorted(leaves(LAYOUT["layout"])) == sorted(PANELS)
    assert len({kind_of(name) for name in PANELS}) == len(SHAPES)


@pytest.mark.parametrize("panel", PANELS)
def test_a_panels_settings_are_those_that_it_has(panel):
    shape = SHAPES[kind_of(panel)]

    assert set(PANELS[panel]) == set(shape)
    for name, value in PANELS[panel].items():
        assert isinstance(value, shape[name]), name


STEP = re.compile(r"\.(?P<field>\w+)|\[(?P<slice>:)\]|\{(?P<key>\w+)==\"(?P<value>[^\"]*)\"\}")


def inner(described):
    """Name of a type; of a sequence, what it holds and its length."""
    sort, what = described
    return what[0] if sort == typesys.base.Nodetype.BASE else what


def read(path):
    """Type at the end of a message path, and whether it is one value a message."""
    topic = re.match(r"/\w+", path)[0]
    kind, single, rest = KINDS[topic], True, path[len(topic) :]
    while rest:
        step = STEP.match(rest)
        assert step, rest
        rest = rest[step.end() :]
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
    assert {
        node for node in NODES if any(node in path["value"] for path in panel["paths"])
    } == NODES


def test_the_plane_shows_what_can_be_drawn_in_the_frame_of_odometry():
    (panel,) = of_kind("3D")
    assert panel["followMode"] in ("follow-pose", "follow-position", "follow-none")
    assert panel["followTf"] == "odom"
    assert {KINDS[topic] for topic in panel["topics"]} == DRAWN
    assert [layer["layerId"] for layer in panel["layers"].values()] == ["foxglove.Grid"]


def test_diagnostics_are_those_of_the_nodes():
    (panel,) = of_kind("DiagnosticSummary")
    assert KINDS[panel["topicToRender"]] == "diagnostic_msgs/msg/DiagnosticArray"
