"""Bags: a robot's topics arrive under our names, in our angles, on one clock."""

import math
from dataclasses import replace

import numpy as np
import pytest

from wmr_ctrl.core.errors import ArgumentError, ResultFileError

pytest.importorskip("rosbags", reason="NOT RUN: rosbags is not there")

from rosbags.rosbag2 import StoragePlugin, Writer

from wmr_ctrl.results.bag import JOINTS, ODOMETRY, ROW, SECOND, TWIST, message_types
from wmr_ctrl.results.bag_topics import read_topics

TYPES = message_types().types
EPOCH = 1_700_000_000
WHEELS = ("base_right_wheel", "base_left_wheel")


def header(t, frame="odom"):
    ns = round(t * SECOND)
    time = TYPES["builtin_interfaces/msg/Time"](sec=ns // SECOND, nanosec=ns % SECOND)
    return TYPES["std_msgs/msg/Header"](stamp=time, frame_id=frame)


def twist(v, w, sideways=0.0):
    vector = TYPES["geometry_msgs/msg/Vector3"]
    return TYPES[TWIST](linear=vector(x=v, y=sideways, z=0.0), angular=vector(x=0.0, y=0.0, z=w))


def odometry(t, v=0.5, w=0.0, pose=(0.0, 0.0, 0.0), frame="odom", norm=1.0, sideways=0.0):
    x, y, yaw = pose
    turn = TYPES["geometry_msgs/msg/Quaternion"](
        x=0.0, y=0.0, z=norm * math.sin(yaw / 2), w=norm * math.cos(yaw / 2)
    )
    point = TYPES["geometry_msgs/msg/Point"](x=x, y=y, z=0.0)
    nothing = np.zeros(36)
    return TYPES[ODOMETRY](
        header=header(t, frame),
        child_frame_id="base_link",
        pose=TYPES["geometry_msgs/msg/PoseWithCovariance"](
            pose=TYPES["geometry_msgs/msg/Pose"](position=point, orientation=turn),
            covariance=nothing,
        ),
        twist=TYPES["geometry_msgs/msg/TwistWithCovariance"](
            twist=twist(v, w, sideways), covariance=nothing
        ),
    )


def joints(t, angle=(), speed=(), effort=(), names=WHEELS):
    return TYPES[JOINTS](
        header=header(t, ""), name=list(names), position=np.array(angle, float),
        velocity=np.array(speed, float), effort=np.array(effort, float),
    )  # fmt: skip


def array(*values):
    layout = TYPES["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0)
    return TYPES[ROW](layout=layout, data=np.array(values))


def bag(folder, messages, plugin=StoragePlugin.MCAP):
    """A bag of (topic, type, time of receipt [s], message)."""
    place = folder / "drive"
    with Writer(place, version=9, storage_plugin=plugin) as writer:
        connections = {
            (topic, kind): writer.add_connection(topic, kind, typestore=message_types())
            for topic, kind in dict.fromkeys((topic, kind) for topic, kind, _, _ in messages)
        }
        for topic, kind, t, message in messages:
            data = message_types().serialize_cdr(message, kind)
            writer.write(connections[topic, kind], round(t * SECOND), data)
    return place


def odom_at(stamps, name="/odom", **about):
    return [(name, ODOMETRY, t, odometry(t, **about)) for t in stamps]


def joints_at(stamps, *values, **names):
    """Messages whose values are functions of the time since the first."""
    return [
        (
            "/joint_states",
            JOINTS,
            t,
            joints(t, *(value(t - stamps[0]) for value in values), **names),
        )
        for t in stamps
    ]


@pytest.mark.parametrize("plugin", StoragePlugin)
def test_a_drive_around_a_circle_arrives_in_our_frame(tmp_path, plugin):
    """In REP 103, 0 is along +X, where theta is -pi/2; theta is not wrapped, and speeds are
    equal.
    """
    t = np.arange(0, 10, 0.1)
    yaw = 1.3 * t
    x, y = 0.3 * np.sin(yaw), 0.3 * (1 - np.cos(yaw))
    messages = [
        ("/robot/odom", ODOMETRY, EPOCH + s, odometry(EPOCH + s, 0.4, 1.3, pose))
        for s, *pose in zip(t, x, y, yaw, strict=True)
    ]

    place = bag(tmp_path, messages, plugin)
    whole = read_topics(place)

    assert whole.times["theta_measured"] == pytest.approx(t, abs=1e-6)
    assert whole.columns["theta_measured"] == pytest.approx(yaw - math.pi / 2, abs=1e-9)
    assert np.array_equal(whole.columns["x_measured"], x)
    assert np.array_equal(whole.columns["y_measured"], y)
    assert set(whole.columns["v1_measured"]) == {0.4}
    assert set(whole.columns["omega_measured"]) == {1.3}

    file = next(path for path in place.iterdir() if path.suffix in (".mcap", ".db3"))
    alone = read_topics(file)
    assert all(np.array_equal(alone.columns[key], whole.columns[key]) for key in whole.columns)


def test_messages_out_of_order_are_sorted_and_repeated_ones_left_out(tmp_path):
    t = EPOCH + np.arange(0, 6, 0.1)
    stamps = t.copy()
    stamps[[20, 21]] = stamps[[21, 20]]
    stamps[40] = stamps[39]
    messages = [
        ("/odom", ODOMETRY, r, odometry(s, v=s - EPOCH)) for r, s in zip(t, stamps, strict=True)
    ]

    told = read_topics(bag(tmp_path, messages))

    assert told.times["v1_measured"] == pytest.approx(np.delete(t, 40) - EPOCH, abs=1e-6)
    assert told.columns["v1_measured"] == pytest.approx(told.times["v1_measured"], abs=1e-6)
    assert any("out of order" in text for text in told.remarks)
    assert any("repeat a stamp" in text for text in told.remarks)


def test_a_sideways_velocity_is_reported_as_not_read(tmp_path):
    """Once a topic, with the largest speed; not if it is 0 or NaN."""
    t = EPOCH + np.arange(0, 10, 0.1)
    sent = [("/cmd_vel", TWIST, s, twist(0.5, 0.1, math.nan)) for s in t]
    odom = odom_at(t[:50]) + odom_at(t[50:], sideways=-0.3)

    drive = read_topics(bag(tmp_path, odom + sent))

    told = [text for text in drive.remarks if "not read" in text]
    assert told == ["/odom: not read: linear.y (up to 0.3 m/s)."]
    assert set(drive.columns["v1_measured"]) == {0.5}


@pytest.mark.parametrize(
    "about, word",
    [
        ({"frame": "map"}, "frame map"),
        ({"frame": "robot/map"}, "frame map"),
        ({"norm": 0.0}, "no rotations"),
        ({"norm": 1.02}, "no rotations"),
        ({}, "never change"),
    ],
)
def test_unusable_poses_are_left_out(tmp_path, about, word):
    """One quaternion that is not a rotation makes all poses unusable."""
    t = EPOCH + np.arange(0, 6, 0.1)
    messages = odom_at(t[:-1]) + odom_at(t[-1:], pose=(len(about), 0, 0), **about)

    told = read_topics(bag(tmp_path, messages))

    assert set(told.columns) == {"v1_measured", "omega_measured"}
    assert any(word in text for text in told.remarks)


def test_joints_are_found_by_side_and_by_name(tmp_path):
    names = ("caster", "base_left_wheel", "base_right_wheel")
    values = lambda s: (0.0, s, 2 * s), lambda s: (math.nan,) * 3, lambda s: (9.0, 1.0, 2.0)
    place = bag(tmp_path, joints_at(EPOCH + np.arange(0, 6, 0.1), *values, names=names))

    told = read_topics(place)
    other = read_topics(place, {"right": "base_left_wheel", "left": "caster"})

    assert told.columns["wheel_angle[1]"] == pytest.approx(2 * told.columns["wheel_angle[2]"])
    assert set(told.columns["tau_right"]) == {2.0}
    assert "wheel_speed[1]" not in told.columns
    assert set(other.columns["tau_left"]) == {9.0}
    with pytest.raises(ResultFileError, match="right: none"):
        read_topics(place, {"right": "nobody"})


def test_four_wheels_are_averaged_and_other_joints_and_publishers_are_not_mixed_in(tmp_path):
    wheels = ("front_left_wheel", "front_right_wheel", "rear_left_wheel", "rear_right_wheel")
    t = EPOCH + np.arange(0, 3, 0.1)
    messages = joints_at(t, *[lambda s: (s, 2 * s, 3 * s, 4 * s)] * 3, names=wheels)
    messages += joints_at(t + 0.03, *[lambda s: (7.0, 7.0)] * 3, names=("arm_left", "arm_right"))
    messages.sort(key=lambda message: message[2])

    told = read_topics(bag(tmp_path, messages))

    assert told.columns["wheel_angle[1]"] == pytest.approx(3 * np.arange(0, 3, 0.1))
    assert told.columns["wheel_angle[2]"] == pytest.approx(2 * np.arange(0, 3, 0.1))
    assert any("not read: arm_left, arm_right" in text for text in told.remarks)


def test_joints_that_could_be_two_pairs_are_a_remark_where_other_topics_suffice(tmp_path):
    names = ("a_left", "b_left", "a_right")
    t = EPOCH + np.arange(0, 3, 0.1)
    messages = odom_at(t) + joints_at(t, *[lambda s: (s, s, s)] * 3, names=names)
    place = bag(tmp_path, sorted(messages, key=lambda message: message[2]))

    told = read_topics(place)
    left_out = read_topics(place, {"joints": "none"})

    assert "wheel_angle[1]" not in told.columns
    assert any("left: a_left, b_left" in text for text in told.remarks)
    assert not any("a_left" in text for text in left_out.remarks)
    with pytest.raises(ResultFileError, match="is not clear"):
        read_topics(place, {"joints": "/joint_states"})


def test_bags_of_ros_1_are_read(tmp_path):
    from rosbags.rosbag1 import Writer as OldWriter
    from rosbags.typesys import Stores, get_typestore

    types = get_typestore(Stores.ROS1_NOETIC)
    zero = types.types["geometry_msgs/msg/Vector3"](x=0.0, y=0.0, z=0.0)
    with OldWriter(tmp_path / "old.bag") as writer:
        there = writer.add_connection("/cmd_vel", TWIST, typestore=types)
        for k in range(20):
            message = types.types[TWIST](linear=replace(zero, x=0.1 * k), angular=zero)
            writer.write(there, (EPOCH + k) * SECOND, types.serialize_ros1(message, TWIST))

    told = read_topics(tmp_path / "old.bag")

    assert told.columns["v_command"] == pytest.approx(0.1 * np.arange(20))


def test_a_topic_of_efforts_overrides_efforts_of_joints(tmp_path):
    t = EPOCH + np.arange(0, 6, 0.1)
    messages = joints_at(t, lambda s: (s, s), lambda s: (), lambda s: (1.0, 1.0))
    messages += [("/effort/commands", ROW, s, array(3.0, 4.0)) for s in t]

    told = read_topics(bag(tmp_path, messages), {"effort": "/effort/commands"})

    assert set(told.columns["tau_right"]) == {3.0}
    assert set(told.columns["tau_left"]) == {4.0}


def test_topics_are_asked_for_by_role_and_what_is_not_there_is_named(tmp_path):
    t = EPOCH + np.arange(0, 6, 0.1)
    messages = odom_at(t, name="/a/odom", v=1.0) + odom_at(t, name="/b/odom", v=2.0)
    place = bag(tmp_path, messages)

    assert set(read_topics(place, {"odom": "/b/odom"}).columns["v1_measured"]) == {2.0}
    with pytest.raises(ResultFileError, match="would all fit"):
        read_topics(place)
    with pytest.raises(ResultFileError, match=r"/a/odom \(nav_msgs/msg/Odometry\)"):
        read_topics(place, {"odom": "/b/odom", "cmd": "/cmd_vel"})
    with pytest.raises(ArgumentError, match="unknown role"):
        read_topics(place, {"speed": "/odom"})


def test_a_file_that_is_no_bag_is_refused_in_one_paragraph(tmp_path):
    (tmp_path / "noise.mcap").write_bytes(b"no bag")
    (tmp_path / "noise.db3").write_bytes(b"no bag")

    for name in ("noise.mcap", "noise.db3", "none.mcap"):
        with pytest.raises(ResultFileError, match="cannot be read") as told:
            read_topics(tmp_path / name)
        assert "\n" not in str(told.value)
