"""Parameters of the nodes: defaults and descriptions.  All are read-only but `SPEED_SCALE`."""

from __future__ import annotations

from typing import TypeAlias

from wmr_ctrl.filter.gate import ODOMETRY_USES

Default: TypeAlias = str | float | bool | list[float] | list[str]
Table: TypeAlias = dict[str, tuple[Default, str]]

_SHARED: Table = {
    "odometry_timeout": (0.1, "s; older odometry is none"),
    "rise": ([1.0, 2.0], "m/s2, rad/s2; largest change of the command away from zero"),
    "fall": ([2.0, 4.0], "m/s2, rad/s2; largest change of the command towards zero"),
    "excess": ([0.05, 0.1], "m/s, rad/s beyond the limits at which odometry stops the base"),
    "base_frame": ("base_link", "child frame of odometry, frame of commands"),
    "stamped": (True, "TwistStamped commands; false: Twist"),
    "autostart": (True, "configure and activate at once; false: by a lifecycle manager"),
}
FILTER: Table = {
    "scenario": ("", "TOML file with [limits] and [filter]: what the promise rests on; required"),
    "command_timeout": (0.25, "s; an older command is none"),
    "odometry": ("watched", f"one of {', '.join(ODOMETRY_USES)}"),
    **_SHARED,
}
"""Those of ``wmr_filter``."""
SPEED_SCALE = "speed_scale"
"""Share of each command that ``wmr_filter`` passes on, in [0, 1]; may change while it drives."""
REFERENCES = ("scenario", "path")
DRIVE: Table = {
    "scenario": ("", "TOML file with base, limits, guard or filter, and reference; required"),
    "law": ("", "law that drives the base; required"),
    "reference": ("scenario", f"one of {', '.join(REFERENCES)}: whose motion is followed"),
    "odometry_frame": ("odom", "frame_id of odometry and of the path; never map, which jumps"),
    "jump": ([0.1, 0.2], "m, rad; a pose that leaps farther beyond its motion stops the base"),
    "wheels": (["left", "right"], "order of the wheels in the efforts of a base that takes them"),
    **_SHARED,
}
"""Those of ``wmr_drive``."""
