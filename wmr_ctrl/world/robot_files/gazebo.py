"""The differential drive of Gazebo: the plug-in of gz-sim, and that of Gazebo classic.

Source: gz-sim DiffDrive.hh, gazebo_plugins gazebo_ros_diff_drive.hpp (ROS 2, and ROS 1).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

from . import found as our
from .found import Found, Rank, read_table

if TYPE_CHECKING:
    from lxml.etree import _Element as Element

DIAMETER = "wheel_diameter"
TABLE = {
    our.SEPARATION: ("wheel_separation",),
    our.RADIUS: ("wheel_radius", f"half of {DIAMETER}"),
    our.V: ("max_linear_velocity", "min_linear_velocity"),
    our.OMEGA: ("max_angular_velocity", "min_angular_velocity"),
    our.UP: ("max_linear_acceleration",),
    our.TURN_UP: ("max_angular_acceleration",),
    our.DOWN: ("min_linear_acceleration",),
    our.TURN_DOWN: ("min_angular_acceleration",),
    our.PERIOD: ("update_rate", "odom_publish_frequency"),
    our.BASE_FRAME: ("robot_base_frame", "child_frame_id"),
    our.ODOMETRY_FRAME: ("odometry_frame", "frame_id"),
    our.COMMANDS: ("cmd_vel", "topic", "command_topic"),
    our.ODOMETRY: ("odom", "odom_topic", "odometry_topic"),
}
"""Names of elements, or what a remapping names."""


def drives(root: Element) -> list[Element]:
    """Plug-ins that drive two sides of wheels."""
    named = ((item, f"{item.get('filename')} {item.get('name')}") for item in root.iter("plugin"))
    return [
        item
        for item, name in named
        if re.search("diff.?drive", name, re.IGNORECASE) and "wheel_separation" in _flat(item)
    ]


def joints(drive: Element) -> list[str]:
    """Names of the wheel joints."""
    parts = [part for part in drive if _snake(part) in ("left_joint", "right_joint")]
    return [(part.text or "").strip() for part in parts]


def read(drive: Element, file: str) -> Iterator[Found]:
    """Sizes, limits, ramps, period, frames and topics of one plug-in."""
    where = f"{file}: {drive.get('name', 'plugin')}: "
    params = _flat(drive)
    for part in drive.iter("remapping"):
        ours, _, theirs = (part.text or "").strip().partition(":=")
        params[ours] = theirs
    if (diameter := params.pop(DIAMETER, None)) is not None:
        width = our.number(diameter, f"{where}{DIAMETER}")
        params[f"half of {DIAMETER}"] = None if width is None else width / 2
    yield from read_table(params, TABLE, where, Rank.GAZEBO)


def _flat(drive: Element) -> dict[str, object]:
    return {_snake(part): part.text for part in drive}


def _snake(part: Element) -> str:
    """wheelSeparation, of Gazebo in ROS 1, as wheel_separation."""
    return re.sub("(?<=[a-z])(?=[A-Z])", "_", str(part.tag)).lower()
