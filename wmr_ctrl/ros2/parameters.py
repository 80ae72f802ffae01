"""Parameters of the nodes: defaults, descriptions, ranges.

All but `SPEED_SCALE` may change only while a node is not configured.
"""

from dataclasses import dataclass
from typing import TypeAlias

from wmr_ctrl.control.filter.gate import ODOMETRY_USES

Default: TypeAlias = str | float | bool | list[float] | list[str]


@dataclass(frozen=True)
class Declared:
    """A parameter: default, description, constraints in words, range of a number."""

    default: Default
    text: str
    constraints: str = ""
    range: tuple[float, float] | None = None


Table: TypeAlias = dict[str, Declared]
POSITIVE = "two numbers above 0"
SECONDS = (0.001, 60.0)
"""Range of a time-out [s]."""
TRIGGERS = ("timer", "command")
OTHER_PARTS = ("count", "refuse")
REFERENCES = ("scenario", "path")

_SHARED: Table = {
    "odometry_timeout": Declared(0.1, "s; older odometry counts as missing", range=SECONDS),
    "rise": Declared([1.0, 2.0], "m/s2, rad/s2; largest acceleration, away from zero", POSITIVE),
    "fall": Declared([2.0, 4.0], "m/s2, rad/s2; largest deceleration, towards zero", POSITIVE),
    "excess": Declared(
        [0.05, 0.1], "m/s, rad/s beyond the limits at which odometry stops the base", POSITIVE
    ),
    "discovery_time": Declared(
        3.0,
        "s; how long configure looks for nodes that would void the promise",
        range=(0.0, 60.0),
    ),
    "base_frame": Declared(
        "", "child frame of odometry, frame of commands; empty: ros.base_frame of the scenario"
    ),
    "stamped": Declared(True, "TwistStamped commands; false: Twist"),
    "autostart": Declared(True, "configure and activate at once; false: by a lifecycle manager"),
}
FILTER: Table = {
    "scenario": Declared(
        "", "TOML file with [limits] and [filter]: what the promise rests on", "required"
    ),
    "command_timeout": Declared(0.25, "s; an older command counts as missing", range=SECONDS),
    "odometry": Declared(
        "watched", "required: the base stops without it; watched: that is reported",
        f"one of {', '.join(ODOMETRY_USES)}",
    ),
    "trigger": Declared(
        "timer", "when a command is answered: by the timer, or at once where one is due",
        f"one of {', '.join(TRIGGERS)}",
    ),
    "other_parts": Declared(
        "count", "what is done with commands that ask for linear.y, angular.x and so on",
        f"one of {', '.join(OTHER_PARTS)}",
    ),
    **_SHARED,
}  # fmt: skip
"""Those of ``wmr_filter``."""
SPEED_SCALE = "speed_scale"
"""Share of each command that ``wmr_filter`` passes on; may change while it drives."""
SCALE = Declared(1.0, "share of each command that is passed on", range=(0.0, 1.0))
DRIVE: Table = {
    "scenario": Declared(
        "", "TOML file with base, limits, guard or filter, and reference", "required"
    ),
    "law": Declared("", "law that drives the base", "required"),
    "reference": Declared(
        "scenario", "source of the motion to follow", f"one of {', '.join(REFERENCES)}"
    ),
    "odometry_frame": Declared(
        "odom", "frame_id of odometry and of the path; never map, which jumps"
    ),
    "jump": Declared(
        [0.1, 0.2], "m, rad; a pose that jumps farther beyond its motion stops the base", POSITIVE
    ),
    "wheels": Declared(
        ["left", "right"], "order of the wheels in the efforts of a base that takes them",
        "left and right, each once",
    ),
    **_SHARED,
}  # fmt: skip
"""Those of ``wmr_drive``."""
