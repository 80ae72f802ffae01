"""Kinds of messages and of odometry around the filter, over DDS; run by a Python that has rclpy.

``python filter_kinds.py SCENARIO KIND [NODE]``: KIND "twist" sends commands without stamps from a
separate process, which is killed; "governor" shows the filter's reports with odometry and without.
The results are printed as JSON.
"""

import subprocess
import sys
import time

import rclpy
from geometry_msgs.msg import Twist
from outside import PATIENCE, SURE, World, missing, silence, start, tell

SENDER = """
import time, rclpy
from geometry_msgs.msg import Twist
rclpy.init()
node = rclpy.create_node("controller")
publisher = node.create_publisher(Twist, "cmd_vel_in", 1)
message = Twist()
message.linear.x, message.angular.z = 0.5, 0.3
while True:
    publisher.publish(message)
    time.sleep(0.02)
"""


def unstamped(process):
    """Twist in and out, and a controller that is killed."""
    node, seen = rclpy.create_node("base"), []

    def came(message):
        seen.append((time.monotonic(), message.linear.x, message.angular.z))

    node.create_subscription(Twist, "cmd_vel", came, SURE)

    def go(seconds, wanted):
        end = time.monotonic() + seconds
        while time.monotonic() < end and not (seen and seen[-1][1] == wanted):
            rclpy.spin_once(node, timeout_sec=0.02)
        return bool(seen and seen[-1][1] == wanted)

    with subprocess.Popen([sys.executable, "-c", SENDER]) as sender:
        drives, driven = go(PATIENCE, 0.5), seen[-1][1:]
        sender.kill()
        killed = time.monotonic()
        seen.clear()
        rests = go(PATIENCE, 0.0)
    stood = silence([killed, *(t for t, _, _ in seen)])
    zero = seen[-1][0] - killed
    return {"driven": driven, "drives": drives, "rests": rests, "zero": zero, "silence": stood}


def governed(process):
    """Flags of four messages or more while the base drives with odometry and without.

    With odometry it drives until the odometry was used, since on a busy machine it is sometimes too
    old.
    """
    world, found = World(process), {}
    for name, spoil in (("with", None), ("without", missing)):
        world.go(PATIENCE, lambda: world.speed[0] > 0.49, spoil=spoil)
        world.details.clear()
        world.go(PATIENCE, lambda: len(world.details) >= 2, spoil=spoil)
        world.details.clear()  # what is told from now on is of this odometry

        def enough(used=name == "with"):
            told = any("unused" not in item["flags"] for item in world.details)
            return len(world.details) >= 4 and (told or not used)

        world.go(PATIENCE, enough, spoil=spoil)
        found[name] = [item["flags"].split(", ") for item in world.details]
    drives = world.go(PATIENCE, lambda: world.speed[0] > 0.49, spoil=missing)
    return found | {"drives": drives}


KINDS = {"twist": unstamped, "governor": governed}
SETTINGS = {
    "twist": ["stamped:=false", "odometry:=none"],
    "governor": ["odometry:=watched"],
}


def main(scenario, kind, node=""):
    given = [] if node else [part for item in SETTINGS[kind] for part in ("-p", item)]
    process = start(scenario, node, *given)
    rclpy.init()
    try:
        found = KINDS[kind](process)
    finally:
        process.kill()
    tell(found)


if __name__ == "__main__":
    main(*sys.argv[1:])
