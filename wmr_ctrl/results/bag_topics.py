"""Columns of a robot's drive from a ROS 2 bag, with our names, units and angles."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from wmr_ctrl.core.errors import ArgumentError, ResultFileError
from wmr_ctrl.core.fields.arguments import checks_arguments
from wmr_ctrl.core.fields.orientation import theta_of

from . import bag, drive
from .bag_clocks import Topic, clocks_of
from .formats import load_run
from .run import Floats, Run

if TYPE_CHECKING:
    from rosbags.interfaces import Connection

    from .bag import Messages

Source: TypeAlias = Run | drive.RecordedDrive
ROLES: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "odom": ("/odom", (bag.ODOMETRY,)),
    "cmd": ("/cmd_vel", (bag.STAMPED, bag.TWIST)),
    "joints": ("/joint_states", (bag.JOINTS,)),
    "effort": ("", (bag.ROW,)),
}
"""Roles of topics in a drive: the usual name, and the types that are read."""
STAMPS, RECORDER = "stamps", "recorder"
"""Whose times count: those of headers, or of receipt."""
NONE = "none"
"""Name of a topic that leaves a role out."""
SIDES = ("right", "left")
UNIT = 1e-2
"""Largest distance from 1 of the norm of a quaternion."""
PARTS = {"linear.y": "m/s", "linear.z": "m/s", "angular.x": "rad/s", "angular.y": "rad/s"}
"""Parts of a twist that are not read, with their units."""
MOST_NAMED = 12
"""Joints that a remark names."""
MAP = "map"
"""Frame of poses that jump (REP 105), and so are none of the robot's motion."""


@checks_arguments
def load_drive(path: str | Path, topics: Mapping[str, str] | None = None) -> drive.RecordedDrive:
    """Read a robot's drive from a bag, or convert a saved run to a recorded drive.

    ``topics`` names a bag's topics by role ("odom", "cmd", "joints", "effort") and the wheels'
    joints ("right", "left"); without it the usual names are looked up, in any namespace.  Raises
    ResultFileError, ArgumentError, MissingExtraError without rosbags.
    """
    loaded = load_source(path, topics)
    return drive.drive_of(loaded, Path(path).name) if isinstance(loaded, Run) else loaded


def load_source(path: str | Path, topics: Mapping[str, str] | None = None) -> Source:
    """A saved run, or the drive in a bag.

    Raises ResultFileError, ArgumentError, MissingExtraError.
    """
    if bag.is_bag(path):
        return read_topics(path, topics)
    if topics:
        raise ArgumentError(
            f"topics can only be given for a bag, and {str(path)!r} is not one. Leave them out."
        )
    return load_run(path)


def read_topics(path: str | Path, topics: Mapping[str, str] | None = None) -> drive.RecordedDrive:
    """Columns of a drive, with our names, SI units and angles, on one clock.

    ``topics`` names topics by role ("odom", "cmd", "joints", "effort") and the wheels' joints
    ("right", "left"). Without it the usual names are looked for, in any namespace. Stamps are those
    of headers. Times of receipt of a topic without stamps are converted to the stamps' clock if the
    recorder's differs. Raises ResultFileError, ArgumentError, MissingExtraError.
    """
    asked = dict(topics or {})
    source = asked.pop("clock", STAMPS)
    if source not in (STAMPS, RECORDER):
        raise ArgumentError(f"topics: clock = {source!r} must be {STAMPS} or {RECORDER}.")
    if unknown := sorted(set(asked) - set(ROLES) - set(SIDES)):
        raise ArgumentError(
            f"topics: unknown role {', '.join(unknown)}. Name topics as {', '.join(ROLES)}, and "
            f"the wheels' joints as {' and '.join(SIDES)}."
        )
    remarks: list[str] = []
    numbers = {"odom": _of_odometry, "cmd": _of_twist, "joints": _of_joints}
    with bag.opened_bag(path) as (connections, messages):
        chosen = _chosen(Path(path).name, connections, asked)
        parts = {
            role: _gathered(items, messages, numbers.get(role, _of_array))
            for role, items in chosen.items()
            if any(item.msgcount for item in items)
        }
    if "joints" in parts:
        parts |= _of_wheels(parts.pop("joints"), asked, remarks, needed=len(parts) == 0)
    if not parts:
        raise ResultFileError(f"{str(path)!r}: its topics for {', '.join(chosen)} are empty.")
    if source == RECORDER:
        parts = {k: part._replace(stamps=0 * part.stamps) for k, part in parts.items()}
    clocks = clocks_of(parts, remarks)
    first = min(clock.min() for clock in clocks.values())
    times, columns = {}, {}
    for role, part in parts.items():
        order = np.argsort(clocks[role], kind="stable")
        clock = clocks[role][order]
        keep = np.concatenate(([True], np.diff(clock) != 0))
        if not keep.all():
            remarks.append(f"{part.name}: {np.sum(~keep)} messages repeat a stamp; left out.")
        rows = part._replace(values=part.values[order[keep]])
        for name, values in _columns(role, rows, "effort" not in parts, remarks).items():
            times[name], columns[name] = (clock[keep] - first) / bag.SECOND, values
    if not columns:
        raise ResultFileError(
            f"{str(path)!r}: the messages of {', '.join(chosen)} have no numbers."
        )
    return drive.RecordedDrive(Path(path).name, times, columns, tuple(remarks))


def _chosen(
    name: str, connections: Sequence[Connection], asked: Mapping[str, str]
) -> dict[str, list[Connection]]:
    """Connections by role: the requested topic, else the usual one in any namespace."""
    chosen = {}
    there = ", ".join(sorted({f"{item.topic} ({item.msgtype})" for item in connections}))
    for role, (usual, kinds) in ROLES.items():
        fit = [item for item in connections if item.msgtype in kinds]
        topic = asked.get(role, "")
        if topic == NONE:
            continue
        if not topic and usual:
            named = {item.topic for item in fit if item.topic.endswith(usual)}
            named = named or {item.topic for item in fit}
            topic = usual if usual in named or len(named) != 1 else named.pop()
            if len(named) > 1 and usual not in named:
                raise ResultFileError(
                    f"{name}: {', '.join(sorted(named))} would all fit. Name one: --topics "
                    f"{role}={min(named)}."
                )
        items = [item for item in fit if item.topic == topic]
        if items:
            chosen[role] = items
        elif role in asked:
            raise ResultFileError(
                f"{name}: no topic {topic} of the type {' or '.join(kinds)}. It has {there}."
            )
    if not chosen:
        raise ResultFileError(
            f"{name}: it has none of {', '.join(usual for usual, _ in ROLES.values() if usual)}. "
            f"It has {there or 'no topic'}. Name them, as in --topics odom=/base/odometry."
        )
    return chosen


def _gathered(
    items: Sequence[Connection], messages: Messages, numbers: Callable[[Any], Any]
) -> Topic:
    """All messages of a topic, in recorded order."""
    types, stamps, receipt, values, frame = bag.message_types(), [], [], [], ""
    for connection, received, raw in messages(items):
        message: Any = types.deserialize_cdr(raw, connection.msgtype)
        header = None if connection.msgtype in (bag.TWIST, bag.ROW) else message.header
        stamps.append(header.stamp.sec * bag.SECOND + header.stamp.nanosec if header else 0)
        frame = header.frame_id if header else ""
        receipt.append(received)
        values.append(numbers(message))
    sent, received_at = (np.array(item, dtype=np.int64) for item in (stamps, receipt))
    joints = np.array(values, dtype=object if isinstance(values[0], dict) else np.float64)
    return Topic(items[0].topic, sent, received_at, joints, frame)


def _of_odometry(message: Any) -> tuple[float, ...]:
    pose = message.pose.pose
    place, turn = pose.position, pose.orientation
    return (*_speeds(message.twist.twist), place.x, place.y, turn.x, turn.y, turn.z, turn.w)


def _of_twist(message: Any) -> tuple[float, ...]:
    return _speeds(message.twist if message.__msgtype__ == bag.STAMPED else message)


def _speeds(twist: Any) -> tuple[float, ...]:
    """v, omega, and `PARTS`."""
    linear, angular = twist.linear, twist.angular
    return linear.x, angular.z, linear.y, linear.z, angular.x, angular.y


def _of_array(message: Any) -> tuple[float, float]:
    right, left = message.data
    return right, left


def _of_joints(message: Any) -> dict[str, tuple[float, ...]]:
    """Angle, speed and effort of each joint; NaN where a message has none."""
    columns = (message.position, message.velocity, message.effort)
    return {
        name: tuple(float(column[k]) if len(column) > k else math.nan for column in columns)
        for k, name in enumerate(message.name)
    }


def _of_wheels(
    topic: Topic, asked: Mapping[str, str], remarks: list[str], needed: bool
) -> dict[str, Topic]:
    """Means over the joints of each side, from messages with all of them.

    If names do not identify the wheels, this is an error if they are needed or requested, else a
    remark.
    """
    rows: list[Mapping[str, tuple[float, ...]]] = list(topic.values)
    names = sorted({name for row in rows for name in row})
    sides = [_wheels(side, asked.get(side, ""), names) for side in SIDES]
    if not all(sides) or len(sides[0]) != len(sides[1]):
        could = "; ".join(
            f"{side}: {', '.join(own) or 'none'}" for side, own in zip(SIDES, sides, strict=True)
        )
        said = (
            f"{topic.name}: which of its joints are the wheels' is not clear ({could}). Name them: "
            "--topics right=NAME,left=NAME."
        )
        if needed or {*SIDES, "joints"} & {*asked}:
            raise ResultFileError(said)
        remarks.append(f"{said} They are not read.")
        return {}
    wheels = {*sides[0], *sides[1]}
    if rest := [name for name in names if name not in wheels]:
        remarks.append(f"{topic.name}: not read: {', '.join(rest[:MOST_NAMED])}.")
    if len(wheels) > 2:
        remarks.append(f"{topic.name}: a side's angle, speed and effort are means of its wheels'.")
    has = np.array([wheels <= {*row} for row in rows])
    if not has.any():
        raise ResultFileError(
            f"{topic.name}: no message has {', '.join(sorted(wheels))} together. Name two joints "
            "of one publisher: --topics right=NAME,left=NAME."
        )
    values = [
        [float(np.mean([row[name][kind] for name in side])) for kind in range(3) for side in sides]
        for row, whole in zip(rows, has, strict=True)
        if whole
    ]
    own = topic._replace(
        stamps=topic.stamps[has], receipt=topic.receipt[has], values=np.array(values)
    )
    return {"joints": own}


def _wheels(side: str, asked: str, names: Sequence[str]) -> list[str]:
    """Joints of a side: the requested one, else wheel joints whose name contains the side."""
    if asked:
        return [name for name in names if name == asked]
    own = [name for name in names if side in name.lower()]
    return [name for name in own if "wheel" in name.lower()] or own if len(own) > 1 else own


def _odometry(topic: Topic, remarks: list[str]) -> dict[str, Floats]:
    """Velocities, and poses if they are the robot's own; theta = yaw - pi/2."""
    columns = _named(drive.SPEEDS, topic.values[:, :2])
    x, y, *turn = topic.values[:, 6:].T
    reason = ""
    if topic.frame.rpartition("/")[2] == MAP:
        reason = "they are in the frame map, in which poses jump"
    elif np.abs(np.sqrt(sum(part**2 for part in turn)) - 1).max() > UNIT:
        reason = "their quaternions are no rotations"
    elif np.ptp(x) == 0 and np.ptp(y) == 0:
        reason = "they never change"
    if reason:
        remarks.append(f"{topic.name}: poses are left out, since {reason}.")
        return columns
    pose = np.column_stack((x, y, np.unwrap(theta_of(turn, np.arctan2))))
    return columns | _named(drive.POSES, pose)


def _joint_states(topic: Topic, efforts: bool, remarks: list[str]) -> dict[str, Floats]:
    """Angles, speeds and efforts of the joints, as far as every message has them."""
    wanted: list[tuple[Sequence[str], Floats]] = [
        (drive.WHEEL_ANGLE, topic.values[:, :2]),
        (drive.WHEEL_SPEEDS, topic.values[:, 2:4]),
    ]
    if efforts:
        wanted.append((drive.TORQUES, topic.values[:, 4:]))
        if np.isfinite(topic.values[:, 4:]).all():
            remarks.append(
                f"{topic.name}: efforts are taken for the torques as commanded. If the drives "
                "measure them, delay and lag of the drives are not in the log."
            )
    return {
        name: column
        for names, values in wanted
        if np.isfinite(values).all()
        for name, column in zip(names, values.T, strict=True)
    }


def _named(names: Sequence[str], values: Floats) -> dict[str, Floats]:
    return dict(zip(names, values.T, strict=True))


def _columns(role: str, topic: Topic, efforts: bool, remarks: list[str]) -> dict[str, Floats]:
    if role == "joints":
        return _joint_states(topic, efforts, remarks)
    if role == "effort":
        return _named(drive.TORQUES, topic.values)
    rest = np.abs(topic.values[:, 2:6])
    most = rest.max(axis=0, initial=0.0, where=np.isfinite(rest)).tolist()
    told = [
        f"{name} (up to {x:.3g} {unit})"
        for (name, unit), x in zip(PARTS.items(), most, strict=True)
        if x
    ]
    if told:
        remarks.append(f"{topic.name}: not read: {', '.join(told)}.")
    if role == "odom":
        return _odometry(topic, remarks)
    return _named(drive.COMMANDS, topic.values[:, :2])
