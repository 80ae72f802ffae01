"""Other nodes that make the filter useless, each in a namespace; run by a Python that has rclpy.

``python useless.py SCENARIO [NODE]`` starts the filter (in Python, or the program NODE) in the
namespace of each, waits long enough for discovery, and prints its exit code and output, as JSON.
"""

import subprocess
import sys

import rclpy
from geometry_msgs.msg import Twist, TwistStamped
from outside import LATEST, PATIENCE, SURE, start, tell
from std_msgs.msg import Bool

OTHERS = {
    "type": (Twist, "cmd_vel_in", SURE),
    "rival": (TwistStamped, "cmd_vel", SURE),
    "stop": (Bool, "wmr_filter/stop", LATEST),
    "odometry": (Twist, "odom", SURE),
}
"""Type, topic and QoS of each."""
LOOK = ["-p", "discovery_time:=60.0"]


def main(scenario, node=""):
    rclpy.init()
    other = rclpy.create_node("other")
    kept = [other.create_publisher(kind, f"/{space}/{topic}", qos)
            for space, (kind, topic, qos) in OTHERS.items()]  # fmt: skip
    found = {}
    for space in OTHERS:
        more = ["-r", f"__ns:=/{space}", *([] if node else LOOK)]
        process = start(scenario, node, *more, stderr=subprocess.PIPE)
        try:
            _, cried = process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            _, cried = process.communicate()
        found[space] = [process.returncode, cried.decode()]
    assert len(kept) == len(OTHERS)
    tell(found)


if __name__ == "__main__":
    main(*sys.argv[1:])
