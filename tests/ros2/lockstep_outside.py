"""Filter and drive in a loop over DDS, from outside; run by a Python that has rclpy.

``python lockstep_outside.py SCENARIO ROWS LAW [NODE]`` starts nodes on simulated time, in a
namespace.  Without a LAW ("-") the filter (in Python, or the program NODE) answers commands when
they come: rows of ROWS (JSON: v, omega, v measured, omega measured, stamp in ns).  With a LAW, rows
are odometry (x, y, orientation, v, omega, stamp) for the drive, in front of the filter NODE, or
alone without a NODE: then it sends efforts.  The filter watches odometry from the same rows, and
receives it before any node receives a command of that time.  Each row is sent after the answer to
the previous one; the answers are printed as JSON.
"""

import json
import signal
import sys
import time
from pathlib import Path

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from outside import PATIENCE, SOON, SURE, command_of, launch, odometry_of, stamp_of, tell
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64MultiArray

BEFORE = 400_000_000
"""The clock stands this much [ns] before the first row when all know each other."""
AGAIN = 2.0
"""Time [s] after which a first message without an answer is sent again."""


class Sender:
    """Sender of clock, commands or odometry; keeps answers and the filter's count of commands."""

    def __init__(self, drives, alone):
        self.node = rclpy.create_node("base")
        publish, hear = self.node.create_publisher, self.node.create_subscription
        self.clock = publish(Clock, "/clock", SURE)
        self.odometry = publish(Odometry, "/base/odom", SURE)
        self.seen = publish(Odometry, "/base/seen", SURE)
        self.commands = None if drives else publish(TwistStamped, "/base/raw", SURE)
        hear(TwistStamped, "/base/cmd_vel", self._came, SURE)
        hear(Float64MultiArray, "/base/efforts", self._pushed, SURE)
        hear(DiagnosticArray, "/diagnostics", self._told, 10)
        self.needed = [self.odometry] * drives + [self.seen] * (not alone)
        self.answers, self.taken, self.timeless, self.drives = [], alone, False, drives

    def _came(self, message):
        self.answers.append([message.twist.linear.x, message.twist.angular.z])

    def _pushed(self, message):
        self.answers.append(list(message.data))

    def _told(self, message):
        for status in message.status:
            values = {item.key: item.value for item in status.values}
            self.taken = self.taken or int(values.get("commands taken", 0)) > 0

    def tell_time(self, stamp):
        """Publish the clock's time and return it as a stamp; ``timeless``: no timer may see it
        before a message.
        """
        if not self.timeless:
            self.time = Clock(clock=stamp_of(stamp))
            self.clock.publish(self.time)
        return stamp_of(stamp)

    def send(self, row):
        """Send the clock, then odometry of its time, first to the filter, and a command if any."""
        stamp = self.tell_time(int(row[-1]))
        at_rest = (0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
        self.seen.publish(odometry_of(stamp, *at_rest, row[-3:-1]))
        if self.drives:
            self.odometry.publish(odometry_of(stamp, row[:2], row[2:6], row[6:8]))
        else:
            self.commands.publish(command_of(stamp, *row[:2]))

    def answer(self, seconds):
        """The next command, or None if none comes."""
        end, count = time.monotonic() + seconds, len(self.answers)
        while len(self.answers) == count and time.monotonic() < end:
            rclpy.spin_once(self.node, timeout_sec=0.05)
        return self.answers[-1] if len(self.answers) > count else None

    def first_answer(self, row):
        """The answer to the drive's first row, after the zeros before it; None if none comes.

        A node that has not yet discovered all others may miss time or message, so both are sent
        again.
        """
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            self.send(row)
            again = time.monotonic() + AGAIN
            while (left := again - time.monotonic()) > 0:
                answer = self.answer(left)
                if answer not in (None, [0.0, 0.0]):
                    return answer
            self.clock.publish(self.time)
        return None

    def pass_time(self, stamp):
        """A moment before the first row."""
        if self.drives:
            self.tell_time(stamp)
        else:
            self.send([0.0] * 4 + [stamp])

    def meet_all(self, first, step):
        """Let time pass until the nodes receive all topics, and the filter accepts commands."""
        for k in range(1500, 5, -1):
            self.pass_time(first - BEFORE - k * step)
            end = time.monotonic() + PATIENCE / 1500
            while (left := end - time.monotonic()) > 0:
                self.answer(left)
            met = all(item.get_subscription_count() for item in self.needed)
            if met and self.taken and self.answers:
                break
        else:
            raise SystemExit("the nodes were never heard")
        for k in range(5, 0, -1):  # the last of these is answered at once, and not by the timer
            self.pass_time(first - BEFORE - k * step)
            self.answer(0.5)
        end = time.monotonic() + 0.5
        while time.monotonic() < end:
            self.answer(0.1)  # what is under way; the timer is silent until the time-out


def start(scenario, law, node):
    """Start the filter, and the drive in front of it, or alone if a law is named."""
    given = [
        f"scenario:={scenario}", "rise:=[1e6, 1e6]", "fall:=[1e6, 1e6]", "excess:=[1.0, 1.0]",
        "odometry_timeout:=60.0", SOON,
    ]  # fmt: skip
    ours = ["odometry:=watched", "trigger:=command", "command_timeout:=60.0"]
    space, simulated, nodes = "__ns:=/robot1", "use_sim_time:=true", []
    if node or not law:
        remaps = ["cmd_vel_in:=/base/raw", "cmd_vel:=/base/cmd_vel", "odom:=/base/seen", space]
        settings = [] if node else [*given, *ours]
        nodes.append(launch("filter", *settings, simulated, remaps=remaps, node=node))
    if law:
        remaps = ["odom:=/base/odom", "effort_commands:=/base/efforts", "cmd_vel:=/base/raw", space]
        wheels = "wheels:=[right, left]"
        nodes.append(launch("drive", *given, f"law:={law}", wheels, simulated, remaps=remaps))
    return nodes


def main(scenario, rows_file, name, node=""):
    law = name.strip("-")
    nodes, rows = start(scenario, law, node), json.loads(Path(rows_file).read_text("utf-8"))
    rclpy.init()
    alone = bool(law and not node)
    sender, answers = Sender(bool(law), alone), []
    try:
        sender.meet_all(int(rows[0][-1]), int(rows[1][-1] - rows[0][-1]))
        for row in rows:
            if law and not answers:
                sender.timeless = not alone
                answer = sender.first_answer(row)
                sender.timeless = False
            else:
                sender.send(row)
                answer = sender.answer(PATIENCE)
            if answer is None:
                raise SystemExit(f"no answer to row {len(answers)}")
            answers.append(answer)
        for process in nodes:
            process.send_signal(signal.SIGINT)
        last, codes = sender.answer(PATIENCE), [process.wait(PATIENCE) for process in nodes]
    finally:
        for process in nodes:
            process.kill()
    tell({"answers": answers, "last": last, "codes": codes})


if __name__ == "__main__":
    main(*sys.argv[1:])
