"""The differential drive of Gazebo: the plug-in of gz-sim, and that of Gazebo classic.

Source: gz-sim DiffDrive.hh, gazebo_plugins gazebo_ros_diff_drive.hpp (ROS 2, and ROS 1).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

from . import found as our
from .found import NAMED, Found, Rank, Table, read_table

if TYPE_CHECKING:
    from lxml.etree import _Element as Element

DIAMETER = "wheel_diameter"
TABLE: Table = NAMED["gazebo"]


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
