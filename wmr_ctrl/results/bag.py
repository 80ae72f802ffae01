"""ROS 2 bags by `rosbags` (extra ``logs``): reader, and a run as a bag (MCAP).

A run is written as a base would publish it (Odometry, JointState, TwistStamped). Frames are those
of REP 103 and 105: yaw = theta + pi/2, poses in ``odom``.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from wmr_ctrl.core.errors import ArgumentError, MissingExtraError, ResultFileError, library
from wmr_ctrl.core.fields.files import note_input
from wmr_ctrl.core.fields.orientation import outward

from . import drive
from .run import Floats, Run

if TYPE_CHECKING:
    from rosbags.interfaces import Connection
    from rosbags.typesys.store import Msg, Typestore

    Messages: TypeAlias = Callable[[Sequence[Connection]], Iterable[tuple[Connection, int, bytes]]]
    Opened: TypeAlias = tuple[Sequence[Connection], Messages]

ROW = "std_msgs/msg/Float64MultiArray"
ODOMETRY, JOINTS = "nav_msgs/msg/Odometry", "sensor_msgs/msg/JointState"
TWIST, STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"
SECOND = 1_000_000_000
SUFFIXES = (".mcap", ".db3", ".bag")


@cache
def message_types() -> Typestore:
    """Store of message types; those that are read here are equal in all distributions of ROS 2."""
    typesys = library("rosbags.typesys", "logs")
    store: Typestore = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    return store


def is_bag(path: str | Path) -> bool:
    """True if a path looks like a bag: a folder with metadata.yaml, or a file of one."""
    place = Path(path)
    return place.suffix.lower() in SUFFIXES or os.path.isfile(place / "metadata.yaml")


@contextmanager
def _opened(path: Path) -> Iterator[Opened]:
    """Connections of a bag (folder or one of its files), and its messages in recorded order."""
    ros1 = path.suffix.lower() == ".bag"
    if os.path.isdir(path):
        reader = library("rosbags.rosbag2", "logs").Reader(path)
    elif ros1:
        reader = library("rosbags.rosbag1", "logs").Reader(path)
    elif path.suffix.lower() == ".mcap":
        reader = library("rosbags.rosbag2.storage_mcap", "logs").McapReader(path)
    else:
        reader = library("rosbags.rosbag2.storage_sqlite3", "logs").Sqlite3Reader(path)
    reader.open()
    try:
        yield list(reader.connections), _as_cdr(reader) if ros1 else reader.messages
    finally:
        reader.close()


def _as_cdr(reader: Any) -> Messages:
    """Messages of a ROS 1 bag, converted to ROS 2's serialisation."""

    def messages(items: Sequence[Connection]) -> Iterator[tuple[Connection, int, bytes]]:
        for item, received, raw in reader.messages(items):
            yield item, received, bytes(message_types().ros1_to_cdr(raw, item.msgtype))

    return messages


@contextmanager
def opened_bag(path: str | Path) -> Iterator[Opened]:
    """Open a bag; any error caused by a damaged file becomes a ResultFileError."""
    for file in Path(path).iterdir() if os.path.isdir(path) else (path,):
        note_input(file, "bag")
    try:
        with _opened(Path(path)) as bag:
            yield bag
    except (MissingExtraError, ArgumentError, ResultFileError):
        raise
    except Exception as error:  # foreign bytes can break a decoder in any way
        detail = " ".join(f"{type(error).__name__}: {error}".split())[:300]
        raise ResultFileError(
            f"{str(path)!r} cannot be read as a ROS bag ({detail}). Give the folder that was "
            "recorded, with its metadata.yaml, a .mcap or .db3 file of it, or a ROS 1 .bag; "
            "`ros2 bag reindex` mends a recording that was cut off."
        ) from error


def run_as_mcap(run: Run) -> bytes:
    """Bytes of the bag file, equal for equal runs.  Raises MissingExtraError without rosbags."""
    rosbag2, types = library("rosbags.rosbag2", "logs"), message_types()
    stamps = np.rint(run.time * SECOND).astype(np.int64).tolist()
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder, "run")
        with rosbag2.Writer(place, version=9, storage_plugin=rosbag2.StoragePlugin.MCAP) as writer:
            topics = [
                (writer.add_connection(topic, kind, typestore=types), messages)
                for topic, kind, messages in _as_a_base(run, stamps)
            ]
            for stamp in stamps:
                for connection, messages in topics:
                    data = types.serialize_cdr(next(messages), connection.msgtype)
                    writer.write(connection, stamp, data)
        return (place / "run.mcap").read_bytes()


def _as_a_base(run: Run, stamps: Sequence[int]) -> Iterator[tuple[str, str, Iterator[Msg]]]:
    """Topics, types and messages of odometry, joints and commands, as a base publishes them."""
    types, columns = message_types().types, drive.drive_of(run).columns
    header, time = types["std_msgs/msg/Header"], types["builtin_interfaces/msg/Time"]
    vector, twist = types["geometry_msgs/msg/Vector3"], types[TWIST]

    def stamped(frame: str) -> Iterator[Msg]:
        for stamp in stamps:
            yield header(stamp=time(sec=stamp // SECOND, nanosec=stamp % SECOND), frame_id=frame)

    def twists(names: Sequence[str]) -> Iterator[Msg]:
        for v, w in zip(*(columns[name].tolist() for name in names), strict=True):
            yield twist(linear=vector(x=v, y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=w))

    poses = [columns[name] for name in drive.POSES]
    yield "/odom", ODOMETRY, _odometry(poses, stamped("odom"), twists(drive.SPEEDS))
    yield "/joint_states", JOINTS, _joint_states(columns, stamped(""))
    if all(name in columns for name in drive.COMMANDS):
        both = zip(stamped("base_link"), twists(drive.COMMANDS), strict=True)
        kind = types[STAMPED]
        yield "/cmd_vel", STAMPED, (kind(header=h, twist=t) for h, t in both)


def _odometry(
    pose: Sequence[Floats], headers: Iterator[Msg], twists: Iterator[Msg]
) -> Iterator[Msg]:
    types = message_types().types
    point, turn = types["geometry_msgs/msg/Point"], types["geometry_msgs/msg/Quaternion"]
    place, placed = types["geometry_msgs/msg/Pose"], types["geometry_msgs/msg/PoseWithCovariance"]
    moved, unknown = types["geometry_msgs/msg/TwistWithCovariance"], np.zeros(36)
    x, y, theta = pose
    half = outward(theta, "rep103") / 2
    poses = zip(*(item.tolist() for item in (x, y, np.sin(half), np.cos(half))), strict=True)
    for header, twist, (px, py, sine, cosine) in zip(headers, twists, poses, strict=True):
        at, facing = point(x=px, y=py, z=0.0), turn(x=0.0, y=0.0, z=sine, w=cosine)
        where = placed(pose=place(position=at, orientation=facing), covariance=unknown)
        speed = moved(twist=twist, covariance=unknown)
        yield types[ODOMETRY](header=header, child_frame_id="base_link", pose=where, twist=speed)


def _joint_states(columns: Mapping[str, Floats], headers: Iterator[Msg]) -> Iterator[Msg]:
    """Joint states: commanded torques as efforts; angles and speeds of the wheels, if logged."""
    rows = len(columns[drive.TORQUES[0]])

    def pairs(names: Sequence[str]) -> Floats:
        there = names[0] in columns
        return np.column_stack([columns[k] for k in names]) if there else np.zeros((rows, 0))

    numbers = map(pairs, (drive.WHEEL_ANGLE, drive.WHEEL_SPEEDS, drive.TORQUES))
    for header, angle, speed, effort in zip(headers, *numbers, strict=True):
        yield message_types().types[JOINTS](
            header=header, name=["right_wheel", "left_wheel"],
            position=angle, velocity=speed, effort=effort,
        )  # fmt: skip
