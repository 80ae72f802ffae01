"""Commands of the pages as they are written there; run by a Python that has rclpy.

``python as_written.py SCENARIO ROWS``: ROWS (JSON) has "files" by name, which are written beside
SCENARIO, and "commands", the words of each after ``-m wmr_ctrl.ros2``.  Per command the first
velocities that came, who is then heard on /cmd_vel_monitored, and the exit code of SIGINT.
"""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import rclpy
from geometry_msgs.msg import TwistStamped
from outside import PATIENCE, SURE, tell

MONITORED = "/cmd_vel_monitored"


def main(scenario, rows):
    given = json.loads(Path(rows).read_text("utf-8"))
    os.chdir(Path(scenario).parent)
    for name, text in given["files"].items():
        Path(name).write_text(text, "utf-8")
    rclpy.init()
    node, seen, found = rclpy.create_node("reader"), [], []

    def came(message):
        seen.append([message.twist.linear.x, message.twist.angular.z])

    for words in given["commands"]:
        process = subprocess.Popen([sys.executable, "-m", "wmr_ctrl.ros2", *words])
        reader = node.create_subscription(TwistStamped, "cmd_vel", came, SURE)
        seen.clear()
        end = time.monotonic() + PATIENCE
        while len(seen) < 3 and time.monotonic() < end and process.poll() is None:
            rclpy.spin_once(node, timeout_sec=0.1)
        heard = node.count_subscribers(MONITORED)
        process.send_signal(signal.SIGINT)
        found.append([seen[:3], heard, process.wait(PATIENCE)])
        node.destroy_subscription(reader)  # a late zero is not the next node's
    tell(found)


if __name__ == "__main__":
    main(*sys.argv[1:])
