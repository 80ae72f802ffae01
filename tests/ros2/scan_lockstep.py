"""Scans, limits and commands for the filter over DDS, in a loop; run by a Python that has rclpy.

``python scan_lockstep.py SCENARIO ROWS [NODE]`` starts the filter (that in Python, or the program
NODE) on simulated time.  ROWS (JSON): parameters of the node, and steps: stamp [ns], v, omega,
largest v, and a scan's first angle, angle step, least and largest range, ranges (a text is one that
JSON does not have).  A step is sent after the answer to the one before; the answers are printed as
JSON.
"""

import json
import signal
import sys
import time
from pathlib import Path

import rclpy
from filter_lockstep import Sender, start
from geometry_msgs.msg import Twist, TwistStamped
from outside import KEPT, PATIENCE, SURE, tell
from sensor_msgs.msg import LaserScan


class Seeing(Sender):
    """A sender of scans and limits, too."""

    def __init__(self, first):
        super().__init__(drives=False)
        self.scans = self.node.create_publisher(LaserScan, "/base/scan", SURE)
        self.limits = self.node.create_publisher(Twist, "/robot1/wmr_filter/v_max", KEPT)
        self.row, self.limit = first, None

    def command(self, row):
        """The clock, then a scan, a limit where it is another one, and a command of that time."""
        if isinstance(row, dict):
            self.row = row
        else:  # a step before the first one
            row = {**self.row, "v": 0.0, "omega": 0.0, "stamp": int(row[-1])}
        stamp = self.tell_time(row["stamp"])
        scan = LaserScan()
        scan.header.stamp = rclpy.time.Time(nanoseconds=row["stamp"] - row["age"]).to_msg()
        scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max = row["numbers"]
        scan.ranges = [float(item) for item in row["ranges"]]
        self.scans.publish(scan)
        if self.limit != row["limit"]:
            self.limit = row["limit"]
            limit = Twist()
            limit.linear.x, limit.angular.z = self.limit, 9.0
            self.limits.publish(limit)
            time.sleep(0.3)  # on a topic of its own it may be overtaken
        else:
            time.sleep(0.02)
        self.order(row["v"], row["omega"], stamp)

    def order(self, v, omega, stamp):
        """A command."""
        message = TwistStamped()
        message.header.stamp = stamp
        message.twist.linear.x, message.twist.angular.z = v, omega
        self.commands.publish(message)


def main(scenario, rows_file, node=""):
    given = json.loads(Path(rows_file).read_text("utf-8"))
    rows = given["rows"]
    (process,) = start(scenario, "", node, *given["settings"])
    rclpy.init()
    sender, answers = Seeing(rows[0]), []
    try:
        sender.meet_all(rows[0]["stamp"], rows[1]["stamp"] - rows[0]["stamp"], drives=False)
        for row in rows:
            sender.command(row)
            answer = sender.answer(PATIENCE)
            if answer is None:
                raise SystemExit(f"no answer to row {len(answers)}")
            answers.append(answer)
        process.send_signal(signal.SIGINT)
        code = process.wait(PATIENCE)
    finally:
        process.kill()
    tell({"answers": answers, "code": code})


if __name__ == "__main__":
    main(*sys.argv[1:])
