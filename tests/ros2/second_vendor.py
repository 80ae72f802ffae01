"""Cyclone DDS at both ends of the filter, which runs on Fast DDS; run by a Python that has both.

``python second_vendor.py SCENARIO [NODE]`` sends commands as the topic is called on the wire, reads
the answers, and prints the last speeds while it sends and after it has stopped, as JSON.
"""

import os
import sys
import time
from dataclasses import dataclass

URI = """
<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo"/></Interfaces>
<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>
<Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>
"""
os.environ["CYCLONEDDS_URI"] = " ".join(URI.split())

from cyclonedds.core import Policy, Qos  # noqa: E402  # the library reads its settings at once
from cyclonedds.domain import DomainParticipant  # noqa: E402
from cyclonedds.idl import IdlStruct  # noqa: E402
from cyclonedds.idl.types import float64, int32, uint32  # noqa: E402
from cyclonedds.pub import DataWriter  # noqa: E402
from cyclonedds.sub import DataReader  # noqa: E402
from cyclonedds.topic import Topic  # noqa: E402
from cyclonedds.util import duration  # noqa: E402
from outside import PATIENCE, start, tell  # noqa: E402


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time
    frame_id: str


@dataclass
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Twist(IdlStruct, typename="geometry_msgs::msg::dds_::Twist_"):
    linear: Vector3
    angular: Vector3


@dataclass
class TwistStamped(IdlStruct, typename="geometry_msgs::msg::dds_::TwistStamped_"):
    header: Header
    twist: Twist


def command(v, omega):
    """A command of now."""
    now = time.time_ns()
    stamp = Time(now // 1_000_000_000, now % 1_000_000_000)
    twist = Twist(Vector3(v, 0.0, 0.0), Vector3(0.0, 0.0, omega))
    return TwistStamped(Header(stamp, "base_link"), twist)


def main(scenario, node=""):
    participant = DomainParticipant(int(os.environ["ROS_DOMAIN_ID"]))
    sure = Qos(Policy.Reliability.Reliable(duration(seconds=1)))
    writer = DataWriter(participant, Topic(participant, "rt/cmd_vel_in", TwistStamped), qos=sure)
    reader = DataReader(participant, Topic(participant, "rt/cmd_vel", TwistStamped), qos=sure)
    process = start(scenario, node, odometry="none")
    last = []

    def read():
        for sample in reader.take(50):
            last[:] = [sample.twist.linear.x, sample.twist.angular.z]

    def go(seconds, sends, wanted):
        end = time.monotonic() + seconds
        while time.monotonic() < end and last != wanted:
            if sends:
                writer.write(command(0.5, 0.25))
            time.sleep(0.02)
            read()

    try:
        go(PATIENCE, True, [0.5, 0.25])
        driving = list(last)
        go(PATIENCE, False, [0.0, 0.0])
    finally:
        process.kill()
    tell({"driving": driving, "after": last})


if __name__ == "__main__":
    main(*sys.argv[1:])
