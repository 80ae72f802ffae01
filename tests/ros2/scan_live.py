"""Faults of lasers and of limits around the filter, from outside over DDS.

``python scan_live.py SCENARIO KIND [NODE]`` starts the node (in Python, or the program NODE), which
receives a laser's scans (KIND "scan") or free distances (KIND "free"), causes one fault after the
other and prints the reactions as JSON. The node in Python has a nav2_msgs whose messages are those
of std_msgs, since the real one has no wheel.
"""

import json
import math
import os
import sys
import tempfile
import time
from pathlib import Path

import rclpy
from geometry_msgs.msg import Twist
from outside import KEPT, LATEST, MANY, PATIENCE, SOON, World, launch, tell
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool, Float64, Float64MultiArray

SETTINGS = {
    "scan": [
        'scans:=["scan"]', "radius:=0.25", "limit_timeout:=1.0", "speed_limit:=speed_limit",
        "scan_pose:=[0.0, 0.0, 3.14159265]",
    ],
    "free": [],
}  # fmt: skip
STUB = """
from std_msgs.msg import Float64 as SpeedLimit
SpeedLimit.speed_limit = property(lambda message: abs(message.data))
SpeedLimit.percentage = property(lambda message: message.data < 0)
"""
"""Messages of nav2_msgs: a negative number is a percentage."""
LIMITS = (("speed", 0.3, 0.2, 0.3), ("percent", -15.0, 0.1, 0.15), ("none", 0.0, 0.5, 0.5))
"""Limits of speed that are sent, and the speeds between which the answer is."""
BEAMS = 180
FAR, WALL, NEAR = 10.0, 1.5, 0.27
"""Ranges [m] behind, ahead, and ahead where it is too near."""
LASTS = 12.0
"""Time [s] in which a base that is no longer told a way of less than 2 m has stopped."""


class Seeing(World):
    """World with a laser, or free distances, and limits; a test can change their values."""

    def __init__(self, process, kind):
        super().__init__(process)
        self.kind, self.details = kind, [{}]
        self.sound()
        publish = self.node.create_publisher
        self.scans = publish(LaserScan, "scan", LATEST)
        self.frees = publish(Float64MultiArray, "wmr_filter/free", LATEST)
        self.limits = publish(Twist, "wmr_filter/v_max", KEPT)
        self.enable = publish(Bool, "wmr_filter/enable", KEPT)
        self.speeds = publish(Float64, "speed_limit", KEPT)

    def sound(self):
        self.ahead, self.behind, self.ago, self.sees, self.limit = WALL, FAR, 0.0, True, 1.0

    def scan(self):
        """A wall ahead and one behind; the laser looks backwards."""
        message = LaserScan(angle_min=-math.pi, angle_increment=math.tau / BEAMS)
        message.header.stamp = self.stamp(self.ago)
        message.range_min, message.range_max = 0.1, 12.0
        angles = (-math.pi + k * math.tau / BEAMS for k in range(BEAMS))
        message.ranges = [
            self.ahead if abs(angle) > math.pi / 2 else self.behind for angle in angles
        ]
        self.scans.publish(message)

    def command(self, v=0.5, omega=0.0):
        """Send a scan or free distances, a limit, and a command."""
        if self.sees and self.kind == "scan":
            self.scan()
        elif self.sees:
            ways = self.ahead - 0.25, self.behind - 0.25, math.inf, math.inf
            self.frees.publish(Float64MultiArray(data=ways))
        if self.limit is not None:
            limit = Twist()
            limit.linear.x, limit.angular.z = self.limit, 2.0
            self.limits.publish(limit)
        super().command(v, omega)

    def until_rest(self, word, command=None):
        """Seconds until the base receives zeros; the diagnostics once they contain the word."""
        start = time.monotonic()
        self.said.clear()
        rests = self.go(LASTS, lambda: self.speed == (0.0, 0.0), command=command)
        after = time.monotonic() - start if rests else None
        self.go(PATIENCE, lambda: self.told(word), command=command)
        said = sorted({text for text in self.said if word in text})
        return {"after": after, "said": said, "details": self.details[-1]}

    def again(self):
        """Run without faults until the base drives."""
        self.sound()
        self.drive()

    def reaches(self, low, high, command=None):
        """True if the sent speed comes into a range; late steps may delay it."""
        return self.go(PATIENCE, lambda: low <= self.speed[0] <= high, command=command)

    def enabled(self):
        """A command that is allowed."""
        self.enable.publish(Bool(data=True))
        self.command()


def of_scans(world):
    """Reactions of the filter, by fault of its view."""
    found = {}
    world.drive()
    world.sees = False
    found["stops"] = world.until_rest("no-distance")
    world.again()
    world.ago = 0.6
    found["late"] = world.until_rest("no-distance")
    world.again()
    world.ahead = NEAR
    found["near"] = world.until_rest("near")
    found["back"] = world.reaches(-0.3, -0.3, lambda: world.command(-0.3))
    world.again()
    world.ahead = math.nan
    found["blind"] = world.until_rest("near")
    world.again()
    return found


def of_ways(world):
    """Reactions to invalid free distances, and to a command to turn on the spot before a wall."""
    found = {}
    world.enable.publish(Bool(data=True))
    for name, ahead in (("none", 0.25), ("negative", 0.0), ("infinite", -math.inf)):
        world.again()
        world.ahead = ahead
        found[name] = world.until_rest("near")
    world.again()
    world.ahead = math.inf
    found["open"] = world.fault()["falls"]
    world.again()
    world.ahead = math.nan
    found["no number"] = world.until_rest("near")
    world.ahead = NEAR
    world.seen.clear()
    found["turning"] = world.until_rest("near", lambda: world.command(0.0, 0.1))
    found["turned"] = max(abs(omega) for _, _, omega in world.seen)
    return found


def frozen(world):
    """The largest command after the process was frozen, and whether it drives again."""
    world.reaches(0.5, 0.5, world.enabled)
    world.frozen()
    world.go(PATIENCE, lambda: len(world.seen) > MANY)
    largest = max(v for _, v, _ in world.seen)
    return {"largest": largest, "again": world.reaches(0.5, 0.5, world.enabled)}


def of_limits(world):
    """Limits that fall, end, and come again."""
    found = {}
    world.again()
    world.limit = 0.2
    found["lower"] = world.reaches(0.1, 0.2)
    world.ahead = 0.35
    found["both"] = world.reaches(0.0, 0.15)
    world.ahead, world.limit = WALL, 1.0
    found["higher"] = world.reaches(0.5, 0.5)
    world.limit = 0.01
    found["below the push"] = world.reaches(0.0, 0.0)
    world.limit = 1.0
    world.enable.publish(Bool(data=False))
    found["disabled"] = world.reaches(0.0, 0.0)
    return found


def of_limits_that_must_go_on(world):
    """Reactions to limits that fall silent, and to those of nav2."""
    found = {"enabled": world.reaches(0.5, 0.5, world.enabled)}
    world.limit = None
    found["silent"] = world.until_rest("limit-refused", world.enabled)
    world.limit = 1.0
    found["again"] = world.reaches(0.5, 0.5, world.enabled)
    for name, said, low, high in LIMITS:

        def limited(said=said):
            world.speeds.publish(Float64(data=said))
            world.enabled()

        found[name] = world.reaches(low, high, limited)
    return found


def main(scenario, kind, node=""):
    folder = Path(tempfile.mkdtemp(), "nav2_msgs")
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "msg.py").write_text(STUB, "utf-8")
    paths = {"PYTHONPATH": os.pathsep.join([str(folder.parent), os.environ.get("PYTHONPATH", "")])}
    settings = [] if node else [f"scenario:={scenario}", "odometry:=none", SOON, *SETTINGS[kind]]
    process = launch("filter", *settings, node=node, env={**os.environ, **paths})
    rclpy.init()
    world = Seeing(process, kind)
    try:
        found = of_scans(world) | of_limits(world)
        found |= {"frozen": frozen(world)} if kind == "scan" else of_ways(world)
        if kind == "scan" and not node:
            found |= of_limits_that_must_go_on(world)
    finally:
        process.kill()
    tell(json.loads(json.dumps(found)))


if __name__ == "__main__":
    main(*sys.argv[1:])
