"""Life of the drive node in real time, from outside over DDS; run by a Python that has rclpy.

``python drive_live.py SCENARIO`` simulates a base that follows its commands without delay, takes
the node through its states, gives it a path, freezes it, kills it and starts it again, and prints
the reactions as JSON.
"""

import math
import subprocess
import sys
from functools import partial

import rclpy
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from outside import (
    ACTIVATE,
    CLEAN_UP,
    CONFIGURE,
    DEACTIVATE,
    KEPT,
    PATIENCE,
    Base,
    has_changed,
    has_set,
    start_drive,
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


class Follower(Base):
    """A base with a planner, which may forget past diagnostics."""

    cruise = 0.15

    def __init__(self, process):
        super().__init__(process)
        self.path = self.node.create_publisher(Path, "path", KEPT)
        self.since = 0
        """Stamp [ns] before which what diagnostics say does not count."""

    def _told(self, message):
        if rclpy.time.Time.from_msg(message.header.stamp).nanoseconds >= self.since:
            super()._told(message)

    def forget(self):
        """Drop past diagnostics, also those sent but not yet read."""
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


def lives(base, start):
    """Behaviour of a node that is configured, given a path, frozen, killed and started."""
    changed = partial(has_changed, base.node, "wmr_drive")
    set_to = partial(has_set, base.node, "wmr_drive")
    found = {"transitions": [*map(changed, (CONFIGURE, ACTIVATE, DEACTIVATE, CLEAN_UP))]}
    found["set after cleanup"] = [set_to("rise", [9.0, 9.0]), set_to("rise", [1.0, 2.0])]
    found["transitions"] += map(changed, (CONFIGURE, ACTIVATE))
    found["set"] = [set_to("law", "pid"), set_to("rise", [9.0, 9.0])]
    base.go(PATIENCE, lambda: base.said[-1:] == ["no-path"])
    found["before a path"] = base.said[-1]
    base.follow(PATH, "map")
    base.go(0.5)
    found["path in map"] = base.said[-1]
    base.follow(PATH)
    # a busy machine is late, which is graver and told alone
    found["arrived"] = base.go(PATIENCE, lambda: "arrived" in base.details[-1]["flags"])
    found["off"] = math.dist(base.pose[:2], PATH[-1])
    base.follow([(x + 1.5, y + 0.1) for x, y in PATH])
    base.go(PATIENCE, base.drives)
    found["while frozen"] = base.frozen()
    base.go(PATIENCE, lambda: len(base.seen) >= 3)
    found["thawed"] = [row[1] for row in base.seen][:3]
    found["goes on"] = base.go(PATIENCE, base.drives)
    base.follow([])  # nor does a path wait for the next life
    return found | base.killed(start)


def others(base, start):
    """Behaviour beside a second node, which is refused, and beside a twin that dies."""
    third = start(looks=60.0)
    base.go(PATIENCE, lambda: third.poll() is not None)
    found = {"refused": third.poll()}
    third.kill()
    base.forget()
    base.go(PATIENCE, lambda: bool(base.said) and "own name" not in base.said[-1])
    with subprocess.Popen([sys.executable, "-c", TWIN], stdout=subprocess.PIPE) as twin:
        twin.stdout.readline()
        base.forget()
        found["twin"] = base.go(PATIENCE, lambda: base.told("own name"))
        twin.kill()
    base.forget()
    base.go(PATIENCE, lambda: len(base.said) > 1)
    return found | {"ghost": base.said}


def main(scenario):
    start = partial(start_drive, scenario, "reference:=path")
    process = start("autostart:=false")
    rclpy.init()
    base = Follower(process)
    try:
        found = lives(base, start) | others(base, start)
        found["interrupt"] = base.interrupted()
    finally:
        base.process.kill()
    tell(found)


if __name__ == "__main__":
    main(sys.argv[1])
