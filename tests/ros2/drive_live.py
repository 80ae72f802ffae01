"""Life of the drive node in real time, from outside over DDS; run by a Python that has rclpy.

``python drive_live.py SCENARIO`` plays a base that does at once what it is told, takes the node
through its states, gives it a path, freezes it, kills it and starts it again, and prints what was
seen as JSON.
"""

import math
import signal
import subprocess
import sys
import time

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, TwistStamped
from lifecycle_msgs.msg import Transition
from nav_msgs.msg import Odometry, Path
from outside import (
    KEPT,
    PATIENCE,
    RATE,
    SURE,
    Kept,
    has_changed,
    has_set,
    launch,
    spin_for,
    tell,
)

TWIN = """
import time, rclpy
from geometry_msgs.msg import TwistStamped
rclpy.init()
node = rclpy.create_node("wmr_drive")
publisher = node.create_publisher(TwistStamped, "cmd_vel", 1)
print("there", flush=True)
time.sleep(600)
"""
"""Somebody who publishes under the name of the node."""
PATH = [(0.0, 0.0), (0.5, 0.0), (1.0, 0.1), (1.5, 0.1)]


class Base(Kept):
    """Odometry each ``period`` [s], of a base that moves as it is told."""

    period = RATE

    def __init__(self):
        self.node = rclpy.create_node("base")
        self.odometry = self.node.create_publisher(Odometry, "odom", SURE)
        self.path = self.node.create_publisher(Path, "path", KEPT)
        self.node.create_subscription(TwistStamped, "cmd_vel", self._came, SURE)
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._told, 10)
        self.pose, self.speed = [0.0, 0.0, 0.0], (0.0, 0.0)
        self.seen = []
        self.pause = 0.0
        """Longest pause between two messages [s]."""
        self.said = []
        self.since = 0
        """Stamp [ns] before which what diagnostics say does not count."""
        self.values = {}
        self.flags = []
        """All that the node last told, where ``said`` has the gravest: a busy machine is late."""

    def _came(self, message):
        self.speed = message.twist.linear.x, message.twist.angular.z
        self.seen.append((time.monotonic(), self.speed[0]))

    def _told(self, message):
        stamp = message.header.stamp
        if rclpy.time.Time.from_msg(stamp).nanoseconds < self.since:
            return
        self.said += [status.message for status in message.status]
        for status in message.status:
            self.values = {value.key: value.value for value in status.values}
            self.flags = self.values["flags"].split(", ")

    def stamp(self):
        """Time of the odometry that is sent next."""
        return self.node.get_clock().now().to_msg()

    @staticmethod
    def spoil(_message):
        """Change odometry before it is sent; whether it is sent."""
        return True

    def move(self):
        """Take the speed that a period leads to: what was commanded is there at once."""

    def go(self, seconds, until=lambda: False):
        """Move and send odometry; True where ``until`` came true."""
        end = time.monotonic() + seconds
        before = time.monotonic()
        while time.monotonic() < end and not until():
            self.pause = max(self.pause, time.monotonic() - before)
            before = time.monotonic()
            self.move()
            x, y, yaw = self.pose
            way, turn = self.period * self.speed[0], yaw + self.period * self.speed[1]
            self.pose = [x + way * math.cos(yaw), y + way * math.sin(yaw), turn]
            message = Odometry(child_frame_id="base_link")
            message.header.stamp = self.stamp()
            message.header.frame_id = "odom"
            message.pose.pose.position.x, message.pose.pose.position.y = self.pose[:2]
            message.pose.pose.orientation.z = math.sin(turn / 2)
            message.pose.pose.orientation.w = math.cos(turn / 2)
            message.twist.twist.linear.x, message.twist.twist.angular.z = self.speed
            if self.spoil(message):
                self.odometry.publish(message)
            spin_for(self.node, self.period)
        return until()

    def ended(self, process):
        """The last command and the exit code of a node that was interrupted."""
        self.go(PATIENCE, lambda: process.poll() is not None)
        self.go(PATIENCE, lambda: bool(self.seen) and self.seen[-1][1] == 0.0)
        return [self.seen[-1][1], process.poll()]

    def forget(self):
        """What was told, and what was told but not yet read."""
        self.said.clear()
        self.since = self.node.get_clock().now().nanoseconds

    def follow(self, points, frame="odom"):
        """Send a path."""
        message = Path()
        message.header.frame_id = frame
        for x, y in points:
            pose = PoseStamped()
            pose.pose.position.x, pose.pose.position.y = x, y
            message.poses.append(pose)
        self.path.publish(message)


def start(scenario, *more, looks=0.0):
    given = [f"scenario:={scenario}", "law:=kanayama", "reference:=path", *more]
    return launch("drive", *given, f"discovery_time:={looks}")


def main(scenario):
    process = start(scenario, "autostart:=false")
    rclpy.init()
    base, found = Base(), {}
    second = third = process
    try:
        steps = [
            Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE,
            Transition.TRANSITION_DEACTIVATE, Transition.TRANSITION_CLEANUP,
            Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE,
        ]  # fmt: skip
        found["transitions"] = [has_changed(base.node, "wmr_drive", step) for step in steps]
        found["set"] = {
            name: has_set(base.node, "wmr_drive", name, value)
            for name, value in (("law", "pid"), ("rise", [9.0, 9.0]))
        }
        base.go(PATIENCE, lambda: bool(base.said) and base.said[-1] == "no-path")
        found["before a path"] = base.said[-1]
        base.follow(PATH, "map")
        base.go(0.5)
        found["path in map"] = base.said[-1]
        base.follow(PATH)
        found["arrived"] = base.go(PATIENCE, lambda: "arrived" in base.flags)
        found["off"] = math.dist(base.pose[:2], PATH[-1])
        back = [(x + 1.5, y + 0.1) for x, y in PATH]
        base.follow(back)
        base.go(PATIENCE, lambda: base.speed[0] > 0.15)
        process.send_signal(signal.SIGSTOP)
        found["while frozen"] = base.count_after_quiet(0.6)
        process.send_signal(signal.SIGCONT)
        base.go(PATIENCE, lambda: len(base.seen) >= 3)
        found["thawed"] = [v for _, v in base.seen][:3]
        found["goes on"] = base.go(PATIENCE, lambda: base.speed[0] > 0.15)
        process.kill()
        process.wait()
        found["after the kill"] = base.count_after_quiet(0.5)
        base.speed = 0.0, 0.0  # a base's own time-out
        base.follow([])  # nor does a path wait for the next life
        process = start(scenario)
        base.go(PATIENCE, lambda: len(base.seen) > 20)
        found["next life"] = max(abs(v) for _, v in base.seen)
        third = start(scenario, looks=60.0)
        base.go(PATIENCE, lambda: third.poll() is not None)
        found["refused"] = third.poll()
        base.forget()
        base.go(PATIENCE, lambda: bool(base.said) and "own name" not in base.said[-1])
        second = subprocess.Popen([sys.executable, "-c", TWIN], stdout=subprocess.PIPE)
        second.stdout.readline()
        base.forget()
        found["twin"] = base.go(PATIENCE, lambda: any("own name" in text for text in base.said))
        second.kill()
        second.wait()
        base.forget()
        base.go(PATIENCE, lambda: len(base.said) > 1)
        found["ghost"] = base.said
        process.send_signal(signal.SIGINT)
        found["interrupt"] = base.ended(process)
    finally:
        for started in (process, second, third):
            started.kill()
    tell(found)


if __name__ == "__main__":
    main(sys.argv[1])
