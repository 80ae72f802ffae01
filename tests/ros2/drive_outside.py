"""The drive node in a loop over DDS, from outside; run by a Python that has rclpy.

``python drive_outside.py SCENARIO LAW MESSAGES`` starts the node on simulated time, sends it the
odometry that MESSAGES (JSON: rows of x, y, orientation, v, omega, stamp in ns) holds, each after
the answer to the one before, and prints the answers as JSON.
"""

import json
import signal
import sys
import time
from pathlib import Path

import rclpy
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from outside import PATIENCE, SOON, SURE, launch, tell
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64MultiArray

SPACE = "/robot1"
"""Namespace of the node; its topics are remapped into /base."""
AGAIN = 2.0
"""Time [s] after which a first message without an answer is sent again."""


class Base:
    """Clock and odometry of a base, and the commands that it is sent."""

    def __init__(self, efforts):
        self.node = rclpy.create_node("base")
        self.clock = self.node.create_publisher(Clock, "/clock", SURE)
        self.odometry = self.node.create_publisher(Odometry, "/base/odom", SURE)
        kind, topic = (Float64MultiArray, "efforts") if efforts else (TwistStamped, "cmd_vel")
        self.node.create_subscription(kind, f"/base/{topic}", self._came, SURE)
        self.answers = []

    def _came(self, message):
        if isinstance(message, TwistStamped):
            self.answers.append([message.twist.linear.x, message.twist.angular.z])
        else:
            self.answers.append(list(message.data))

    def tell_time(self, stamp):
        """The clock's time, as a stamp."""
        self.time = Clock(clock=rclpy.time.Time(nanoseconds=stamp).to_msg())
        self.clock.publish(self.time)
        return self.time.clock

    def sample(self, row):
        """The clock, then odometry of its time."""
        stamp = self.tell_time(int(row[-1]))
        message = Odometry(child_frame_id="base_link")
        message.header.stamp, message.header.frame_id = stamp, "odom"
        pose, twist = message.pose.pose, message.twist.twist
        pose.position.x, pose.position.y = row[0], row[1]
        turn = pose.orientation
        turn.x, turn.y, turn.z, turn.w = row[2:6]
        twist.linear.x, twist.angular.z = row[6:8]
        self.odometry.publish(message)

    def answer(self, seconds):
        """The next command, or None where none comes."""
        end, count = time.monotonic() + seconds, len(self.answers)
        while len(self.answers) == count and time.monotonic() < end:
            rclpy.spin_once(self.node, timeout_sec=0.05)
        return self.answers[-1] if len(self.answers) > count else None

    def first_answer(self, row):
        """The answer to the first row, before which zeros come; None where none comes.

        Who has not met everybody yet may miss time or message: both are sent again.
        """
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            self.sample(row)
            again = time.monotonic() + AGAIN
            while (left := again - time.monotonic()) > 0:
                answer = self.answer(left)
                if answer not in (None, [0.0, 0.0]):
                    return answer
            self.clock.publish(self.time)
        return None

    def meet(self, first):
        """Wait until both sides know each other and the time."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            self.tell_time(first)
            heard = self.answer(0.1) is not None
            if heard and self.odometry.get_subscription_count():
                return
        raise SystemExit("the node was never heard")


def main(scenario, law, messages, kind):
    names = ["cmd_vel:=/base/cmd_vel", "odom:=/base/odom", "effort_commands:=/base/efforts"]
    process = launch(
        "drive", f"scenario:={scenario}", f"law:={law}", "rise:=[1e6, 1e6]", "fall:=[1e6, 1e6]",
        "odometry_timeout:=60.0", "excess:=[1.0, 1.0]", "use_sim_time:=true",
        "wheels:=[right, left]", SOON, remaps=(*names, f"__ns:={SPACE}"),
    )  # fmt: skip
    rclpy.init()
    base, rows = Base(kind == "efforts"), json.loads(Path(messages).read_text("utf-8"))
    try:
        base.meet(int(rows[0][-1]))
        answers, start = [], time.monotonic()
        answers.append(base.first_answer(rows[0]))
        for row in rows[1:]:
            base.sample(row)
            answers.append(base.answer(PATIENCE))
        seconds = time.monotonic() - start
        process.send_signal(signal.SIGINT)
        last = base.answer(PATIENCE)
        code = process.wait(PATIENCE)
        report = {"answers": answers, "last": last, "code": code, "seconds": seconds}
    finally:
        process.kill()
    tell(report)


if __name__ == "__main__":
    main(*sys.argv[1:])
