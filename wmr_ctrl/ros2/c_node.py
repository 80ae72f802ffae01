"""``wmr_filter`` as a node in C: its sources, build files and documentation."""

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from wmr_ctrl.codegen.resources import c_texts
from wmr_ctrl.control.filter.gate import GATE_FLAGS, GateSettings
from wmr_ctrl.core.data import with_tuples
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.units import limits_in_words
from wmr_ctrl.results import write_all
from wmr_ctrl.world.scenario import Scenario, scenario_hash

from .diagnosis import ERRORS, WARNINGS
from .filter_core import core_files, node_templates
from .native import HAPPENINGS
from .parameters import FILTER, SIGHT, Declared
from .sight import SightSettings, remedy

LIBRARIES = ("rcl", "rcl_yaml_param_parser", "rcutils", "rmw", "rosidl_runtime_c")
INTERFACES = (
    "builtin_interfaces", "diagnostic_msgs", "geometry_msgs", "nav_msgs", "rosgraph_msgs",
    "sensor_msgs", "std_msgs", "std_srvs",
)  # fmt: skip
"""ROS packages that the node is compiled against, without and with messages."""
RMW = "rmw_implementation"
"""ROS package of the middleware's own functions; the wheels have Fast DDS's in its place."""
LINKED = (
    *(f"-l{name}" for name in (*LIBRARIES, "rmw_fastrtps_cpp")),
    *(f"-l{name}__rosidl_{kind}_c" for name in INTERFACES for kind in ("generator", "typesupport")),
)
"""Words for a linker, where there is no ament_cmake to find them; nav2_msgs has no wheel."""
SOURCES = ("filter_node.h", "filter_node.c", "filter_connect.c", "filter_graph.c")
NAME = "wmr_filter_node"
GIVEN = tuple(name for name in FILTER if name not in ("scenario", "autostart"))
"""Parameters of ``wmr_filter`` that are compiled into the node."""


@dataclass(frozen=True, kw_only=True)
class NodeSettings:
    """Settings compiled into the node: its gate, lasers, ``frame`` of base and commands, type.

    Without a ``frame`` it is the scenario's ros.base_frame.

    ``at_once``: a command that arrives when one is due is passed on immediately.  ``discovery``:
    how long it searches for other nodes before it starts [s].
    """

    gate: GateSettings = field(default_factory=GateSettings)
    sight: SightSettings = field(default_factory=SightSettings)
    frame: str = ""
    refuses_parts: bool = False
    stamped: bool = True
    at_once: bool = False
    discovery: float = float(FILTER["discovery_time"].default)  # type: ignore[arg-type]


def node_settings(given: Sequence[str]) -> NodeSettings:
    """Settings from words NAME=VALUE, by the names of the parameters of ``wmr_filter``.

    Raises ArgumentError for an unknown name, or a value of the wrong kind.
    """
    values = dict(_parsed(word) for word in given)
    named = {"base_frame": "frame", "discovery_time": "discovery", "stamped": "stamped"}
    own = {ours: values.pop(name) for name, ours in named.items() if name in values}
    own["at_once"] = values.pop("trigger", "") == "command"
    own["refuses_parts"] = values.pop("other_parts", "") == "refuse"
    sight: dict[str, Any] = with_tuples({key: values.pop(key) for key in SIGHT if key in values})
    gate: dict[str, Any] = with_tuples(values)
    return NodeSettings(gate=GateSettings(**gate), sight=SightSettings(**sight), **own)


def _parsed(word: str) -> tuple[str, Any]:
    name, _, text = word.partition("=")
    if name not in GIVEN:
        raise ArgumentError(
            f"{name!r} is not a parameter that can be compiled into the node. These can: "
            f"{', '.join(GIVEN)}."
        )
    stated = FILTER[name]
    if isinstance(stated.default, str):
        return name, stated.chosen(name, text)
    value = _like(stated, text)
    if value is None:
        told = json.dumps(stated.default)
        raise ArgumentError(f"{name} = {text!r} must be like its default: {told}.")
    low, high = stated.range or (-math.inf, math.inf)
    if isinstance(value, float) and not low <= value <= high:
        raise ArgumentError(f"{name} = {text} is out of its range: {low:g} to {high:g}.")
    return name, value


def _like(stated: Declared, text: str) -> Any:
    """Parse a JSON value of the default's type; None for another type."""
    default = stated.default
    try:
        value = json.loads(text)
        if isinstance(default, list):
            parts = [type(default[0])(part) for part in value]
            return parts if stated.many or len(parts) == len(default) else None
        if isinstance(default, bool) == isinstance(value, bool):
            return type(default)(value)
    except (ValueError, TypeError):
        pass
    return None


def node_files(scenario: Scenario, settings: NodeSettings) -> dict[str, str]:
    """File name to text: sources, CMakeLists.txt, package.xml, README.md.

    Raises ScenarioError if no filter is set, or if its limit cannot be kept.
    """

    def masked(words: set[str]) -> int:
        return sum(bit for bit, word in GATE_FLAGS.items() if word in words)

    nav2 = ("nav2_msgs",) if settings.sight.speed_limit else ()
    packages = (*LIBRARIES, RMW, *INTERFACES, *nav2)
    engine, context = node_templates(), {
        "name": NAME, "packages": packages, "kept": kept(scenario, settings),
        "kind": "TwistStamped" if settings.stamped else "Twist", "libraries": " ".join(LINKED),
        "settings": settings, "frame": settings.frame or scenario.ros.base_frame,
        "topics": settings.sight.topics,
        "remedy": remedy(scenario) if scenario.filter.free_error is not None else "",
        "errors": masked(ERRORS), "warnings": masked(WARNINGS), "flags": GATE_FLAGS,
        "happenings": {1 << k: word for k, word in enumerate(HAPPENINGS)},
    }  # fmt: skip
    written = ("CMakeLists.txt", "package.xml", "README.md", "node_settings.h")
    return {
        **core_files(scenario, settings.gate, settings.sight),
        **c_texts(*SOURCES, folder="ros2"),
        **{name: engine.get_template(f"{name}.j2").render(context) for name in written},
    }


def write_node(
    out: Path, scenario: Scenario, settings: NodeSettings | None = None
) -> tuple[Path, ...]:
    """Write the node into the folder ``out`` (made if need be) and return the files' paths.

    All files appear, or none if one of them cannot be written: then it raises ResultFileError.
    """
    return tuple(write_all(node_files(scenario, settings or NodeSettings()), out))


def kept(scenario: Scenario, settings: NodeSettings) -> str:
    """The limits that a node keeps, in one line."""
    own, gate = scenario.filter, settings.gate
    return (
        f"{scenario.name}, hash {scenario_hash(scenario)}: filter {own.kind}, limits "
        f"{limits_in_words(scenario.limits.sides)}, period {scenario.clock.control:g} s, "
        f"command_timeout {gate.command_timeout:g} s, odometry {gate.odometry}, "
        f"odometry_timeout {gate.odometry_timeout:g} s"
    )
