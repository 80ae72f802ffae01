"""The filter in a loop over DDS, from outside; run by a Python that has rclpy.

``python filter_lockstep.py SCENARIO ROWS LAW [NODE]`` starts the filter (that in Python, or the
program NODE) on simulated time, in a namespace, answering commands when they come.  Without a LAW
("-") the rows of ROWS (JSON: v, omega, v measured, omega measured, stamp in ns) are the commands;
with one they are odometry, and the drive node with that law stands between.  The filter watches
odometry, and hears it before anybody hears of a command of that time, from the same rows.  Each row
is sent after the answer to the one before; the answers are printed as JSON.
"""

import json
import signal
import sys
import time
from pathlib import Path

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from drive_outside import SPACE, Base
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from outside import PATIENCE, SOON, SURE, launch, tell

WIDE = ["rise:=[1e6, 1e6]", "fall:=[1e6, 1e6]", "excess:=[1.0, 1.0]"]
BEFORE = 400_000_000
"""The clock stands this much [ns] before the first row when both sides know each other."""


class Sender(Base):
    """Clock, commands or odometry, and what the filter says of how many it took."""

    def __init__(self, drives):
        super().__init__(efforts=False)
        if not drives:
            self.commands = self.node.create_publisher(TwistStamped, "/base/raw", SURE)
        self.seen = self.node.create_publisher(Odometry, "/base/seen", SURE)
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._told, 10)
        self.taken, self.timeless = 0, False

    def tell_time(self, stamp):
        """The clock's time, as a stamp; ``timeless``: no timer is to know it before a message."""
        if self.timeless:
            return rclpy.time.Time(nanoseconds=stamp).to_msg()
        return super().tell_time(stamp)

    def _told(self, message):
        for status in message.status:
            values = {item.key: item.value for item in status.values}
            self.taken = max(self.taken, int(values.get("commands taken", 0)))

    def sample(self, row):
        """The clock, then odometry of its time: first for the filter, then for the drive."""
        self.tell_time(int(row[-1]))
        self.measure(row[6:8], int(row[-1]))
        super().sample(row)

    def measure(self, velocity, stamp):
        """Odometry for the filter."""
        message = Odometry(child_frame_id="base_link")
        message.header.stamp = rclpy.time.Time(nanoseconds=stamp).to_msg()
        message.pose.pose.orientation.w = 1.0
        message.twist.twist.linear.x, message.twist.twist.angular.z = velocity
        self.seen.publish(message)

    def command(self, row):
        """The clock, then odometry and a command of its time."""
        message = TwistStamped()
        message.header.stamp = self.tell_time(int(row[-1]))
        self.measure(row[2:4], int(row[-1]))
        message.twist.linear.x, message.twist.angular.z = row[:2]
        self.commands.publish(message)

    def meet_all(self, first, step, drives):
        """Let time pass until the filter takes commands, from here or from the drive."""
        rest = [0.0] * 4
        for k in range(1500, 5, -1):
            stamp = first - BEFORE - k * step
            self.tell_time(stamp) if drives else self.command([*rest, stamp])
            end = time.monotonic() + PATIENCE / 1500
            while (left := end - time.monotonic()) > 0:
                self.answer(left)
            odometry = not drives or self.odometry.get_subscription_count()
            odometry = odometry and self.seen.get_subscription_count()
            if self.taken and self.answers and odometry:
                break
        else:
            raise SystemExit("the nodes were never heard")
        for k in range(5, 0, -1):  # the last of these is answered at once, and not by the timer
            stamp = first - BEFORE - k * step
            self.tell_time(stamp) if drives else self.command([*rest, stamp])
            self.answer(0.5)
        end = time.monotonic() + 0.5
        while time.monotonic() < end:
            self.answer(0.1)  # what is under way; the timer is silent until the time-out


def start(scenario, law, node, *more):
    """The filter with ``more`` parameters, and the drive before it where a law is named."""
    given = [f"scenario:={scenario}", *WIDE, "odometry_timeout:=60.0", SOON]
    ours = ["odometry:=watched", "trigger:=command", "command_timeout:=60.0", *more]
    remaps = ["cmd_vel_in:=/base/raw", "cmd_vel:=/base/cmd_vel", "odom:=/base/seen"]
    space, simulated = f"__ns:={SPACE}", "use_sim_time:=true"
    settings = [] if node else [*given, *ours]
    nodes = [launch("filter", *settings, simulated, remaps=[*remaps, space], node=node)]
    if law:
        remaps = ["cmd_vel:=/base/raw", "odom:=/base/odom", space]
        nodes.append(launch("drive", *given, f"law:={law}", simulated, remaps=remaps))
    return nodes


def main(scenario, rows_file, name, node=""):
    law = name.strip("-")
    nodes = start(scenario, law, node)
    rclpy.init()
    rows = json.loads(Path(rows_file).read_text("utf-8"))
    sender, answers = Sender(bool(law)), []
    try:
        sender.meet_all(int(rows[0][-1]), int(rows[1][-1] - rows[0][-1]), bool(law))
        began = time.monotonic()
        for row in rows:
            if law and not answers:
                sender.timeless = True
                answer = sender.first_answer(row)
                sender.timeless = False
            else:
                sender.sample(row) if law else sender.command(row)
                answer = sender.answer(PATIENCE)
            if answer is None:
                raise SystemExit(f"no answer to row {len(answers)}")
            answers.append(answer)
        seconds = time.monotonic() - began
        for process in nodes:
            process.send_signal(signal.SIGINT)
        codes = [process.wait(PATIENCE) for process in nodes]
    finally:
        for process in nodes:
            process.kill()
    tell({"answers": answers, "seconds": seconds, "codes": codes})


if __name__ == "__main__":
    main(*sys.argv[1:])
