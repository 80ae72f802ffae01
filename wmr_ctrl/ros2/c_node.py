"""``wmr_filter`` as a node in C: its sources, what it is built with, what it says of itself."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path

from wmr_ctrl.codegen.package import text_engine
from wmr_ctrl.codegen.resources import c_texts
from wmr_ctrl.control.filter.gate import GATE_FLAGS, GateSettings
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.results import write_all
from wmr_ctrl.world.scenario import Scenario, scenario_hash

from .diagnosis import ERRORS, WARNINGS
from .filter_core import core_files
from .native import HAPPENINGS, in_ns
from .parameters import FILTER, OTHER_PARTS, TRIGGERS, Default

LIBRARIES = ("rcl", "rcl_yaml_param_parser", "rcutils", "rmw", "rosidl_runtime_c")
INTERFACES = (
    "builtin_interfaces", "diagnostic_msgs", "geometry_msgs", "nav_msgs", "rosgraph_msgs",
    "std_msgs", "std_srvs",
)  # fmt: skip
"""ROS packages that the node is compiled against, without and with messages."""
RMW = "rmw_implementation"
"""ROS package of the middleware's own functions; the wheels have Fast DDS's in its place."""
LINKED = (
    *(f"-l{name}" for name in (*LIBRARIES, "rmw_fastrtps_cpp")),
    *(f"-l{name}__rosidl_{kind}_c" for name in INTERFACES for kind in ("generator", "typesupport")),
)
"""Words for a linker, where there is no ament_cmake to find them."""
SOURCES = ("filter_node.h", "filter_node.c", "filter_connect.c", "filter_graph.c")
NAME = "wmr_filter_node"
GIVEN = tuple(name for name in FILTER if name not in ("scenario", "autostart"))
"""Parameters of ``wmr_filter`` that are compiled into the node."""


@dataclass(frozen=True, kw_only=True)
class NodeSettings:
    """Settings compiled into the node: its gate, ``frame`` of base and commands, kind of message.

    Without a ``frame`` it is the scenario's ros.base_frame.

    ``at_once``: a command is answered when it comes, where one is due.  ``discovery``: how long
    others are looked for before it starts [s].
    """

    gate: GateSettings = field(default_factory=GateSettings)
    frame: str = ""
    refuses_parts: bool = False
    stamped: bool = True
    at_once: bool = False
    discovery: float = float(FILTER["discovery_time"].default)  # type: ignore[arg-type]


def node_settings(given: Sequence[str]) -> NodeSettings:
    """Settings from words NAME=VALUE, by the names of the parameters of ``wmr_filter``.

    Raises ArgumentError for a name that is none, or a value that is not of its kind.
    """
    values = dict(_parsed(word) for word in given)
    trigger = _one_of("trigger", str(values.pop("trigger", TRIGGERS[0])))
    settings = NodeSettings(at_once=trigger == "command")
    settings = replace(
        settings,
        frame=str(values.pop("base_frame", settings.frame)),
        stamped=bool(values.pop("stamped", settings.stamped)),
        discovery=float(values.pop("discovery_time", settings.discovery)),  # type: ignore[arg-type]
        refuses_parts=_one_of("other_parts", str(values.pop("other_parts", "count"))) == "refuse",
    )
    pairs = {key: tuple(v) if isinstance(v, list) else v for key, v in values.items()}
    known = {item.name for item in fields(GateSettings)}
    assert known.issuperset(pairs)
    return replace(settings, gate=GateSettings(**pairs))  # type: ignore[arg-type]


CHOICES = {"trigger": TRIGGERS, "other_parts": OTHER_PARTS}


def _one_of(name: str, value: str) -> str:
    if value not in CHOICES[name]:
        raise ArgumentError(f"{name} = {value!r} must be one of {', '.join(CHOICES[name])}.")
    return value


def _parsed(word: str) -> tuple[str, Default]:
    name, _, text = word.partition("=")
    if name not in GIVEN:
        raise ArgumentError(
            f"{name!r} is not a parameter that can be compiled into the node. These can: "
            f"{', '.join(GIVEN)}."
        )
    default = FILTER[name].default
    if isinstance(default, str):
        return name, text
    value = _like(default, text)
    if value is None:
        raise ArgumentError(f"{name} = {text!r} must be like its default: {json.dumps(default)}.")
    low, high = FILTER[name].range or (-math.inf, math.inf)
    if isinstance(value, float) and not low <= value <= high:
        raise ArgumentError(f"{name} = {text} is out of its range: {low:g} to {high:g}.")
    return name, value


def _like(default: Default, text: str) -> Default | None:
    """A value of JSON that has the default's kind; None for another."""
    try:
        value = json.loads(text)
        if isinstance(default, list):
            pair = [float(part) for part in value]
            return pair if len(pair) == len(default) else None
        if isinstance(default, bool) == isinstance(value, bool):
            return type(default)(value)
    except (ValueError, TypeError):
        pass
    return None


def node_files(scenario: Scenario, settings: NodeSettings) -> dict[str, str]:
    """File name to text: sources, CMakeLists.txt, package.xml, README.md.

    Raises ScenarioError where the filter is not set, or cannot be met.
    """
    engine, context = text_engine(Path(__file__).parent / "templates"), {
        "name": NAME, "packages": (*LIBRARIES, RMW, *INTERFACES), "kept": kept(scenario, settings),
        "kind": "TwistStamped" if settings.stamped else "Twist", "libraries": " ".join(LINKED),
    }  # fmt: skip
    written = ("CMakeLists.txt", "package.xml", "README.md")
    return {
        **core_files(scenario, settings.gate),
        **c_texts(*SOURCES, folder="ros2"),
        "node_settings.h": _header(scenario, settings),
        **{name: engine.get_template(f"{name}.j2").render(context) for name in written},
    }


def write_node(
    out: Path, scenario: Scenario, settings: NodeSettings | None = None
) -> tuple[Path, ...]:
    """Write the node into the folder ``out`` (made if need be) and return the files' paths.

    All appear, or none where one of them cannot be written: it raises ResultFileError.
    """
    return tuple(write_all(node_files(scenario, settings or NodeSettings()), out))


def kept(scenario: Scenario, settings: NodeSettings) -> str:
    """The limits that a node keeps, in one line."""
    (v, omega), own, gate = scenario.limits.v_u1, scenario.filter, settings.gate
    return (
        f"{scenario.name}, hash {scenario_hash(scenario)}: filter {own.kind}, limits {v:g} m/s "
        f"and {omega:g} rad/s, period {scenario.clock.control:g} s, command_timeout "
        f"{gate.command_timeout:g} s, odometry {gate.odometry}, "
        f"odometry_timeout {gate.odometry_timeout:g} s"
    )


def _header(scenario: Scenario, settings: NodeSettings) -> str:
    def masked(words: set[str]) -> int:
        return sum(bit for bit, word in GATE_FLAGS.items() if word in words)

    defined: Mapping[str, object] = {
        "WMR_STAMPED": int(settings.stamped),
        "WMR_AT_ONCE": int(settings.at_once),
        "WMR_DISCOVERY": f"INT64_C({in_ns(settings.discovery)})",
        "WMR_BASE_FRAME": _quoted(settings.frame or scenario.ros.base_frame),
        "WMR_REFUSES_PARTS": int(settings.refuses_parts),
        "WMR_KEPT": _quoted(kept(scenario, settings)),
        "WMR_FLAGS": len(GATE_FLAGS),
        "WMR_ERRORS": masked(ERRORS),
        "WMR_WARNINGS": masked(WARNINGS),
    }
    lines = [f"#define {name} {value}" for name, value in defined.items()]
    return "\n".join([
        "/* Generated by wmr_ctrl: what is compiled into the node; do not edit. */",
        *lines,
        "",
        "typedef struct {",
        "    int64_t bit;",
        "    const char *word;",
        "} wmr_word;",
        "",
        _table("wmr_flags", GATE_FLAGS),
        _table("wmr_happenings", {1 << k: word for k, word in enumerate(HAPPENINGS)}),
        "",
    ])  # fmt: skip


def _table(name: str, words: Mapping[int, str]) -> str:
    rows = ", ".join(f"{{{bit}, {_quoted(word)}}}" for bit, word in words.items())
    return f"static const wmr_word {name}[] = {{{rows}}};"


def _quoted(text: str) -> str:
    """A text as C writes it: what is not plain ASCII in octal."""
    plain = "".join(
        chr(byte) if 32 <= byte < 127 and byte not in b'"\\?' else f"\\{byte:03o}"
        for byte in text.encode()
    )
    return f'"{plain}"'
