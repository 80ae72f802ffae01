"""Faults around the drive, from outside over DDS; run by a Python that has rclpy.

``python drive_faults.py SCENARIO`` plays a base that does at once what it is told, breaks one thing
after the other, and prints what was seen as JSON: per fault when the command began to fall and when
it was zero [s after the fault], what diagnostics said, and whether it drove again.  Then the same
on simulated time that stops, goes back and leaps ahead.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from itertools import pairwise

import rclpy
from drive_live import KEPT, SURE, Base
from nav_msgs.msg import Odometry
from outside import AT_ONCE, LASTS, PUNCTUAL, after, tell
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

CRUISE = 0.25
"""Speed [m/s] of a base that follows its circle, nearly."""

TOLD = 1.3
"""Time [s] in which diagnostics tell what passed in a moment: they come each second."""


class Broken(Base):
    """A base whose odometry can be spoilt, perhaps on a time of its own."""

    def __init__(self, simulated: bool) -> None:
        super().__init__()
        self.clock = self.node.create_publisher(Clock, "/clock", SURE)
        self.stop = self.node.create_publisher(Bool, "/wmr_drive/stop", KEPT)
        self.time, self.rate, self.simulated = 100_000_000_000, 1.0, simulated

    def stamp(self):
        if not self.simulated:
            return super().stamp()
        self.time += round(1e9 * self.period * self.rate)
        now = rclpy.time.Time(nanoseconds=self.time).to_msg()
        self.clock.publish(Clock(clock=now))
        return now

    def drives(self) -> bool:
        return self.speed[0] > CRUISE

    def fault(
        self,
        spoil: Callable[[Odometry], bool] | None = None,
        first: Callable[[], object] | None = None,
    ) -> dict[str, object]:
        """What follows a fault that lasts for a second; again where this process was late."""
        for _ in range(1 if first else 8):
            if not self.go(30, self.drives):
                raise SystemExit(f"the base never drove: {self.said[-3:]}")
            self.go(0.3)
            self.seen.clear()
            self.said.clear()
            before, began, self.pause = self.speed[0], time.monotonic(), 0.0
            if first:
                first()
            self.spoil = spoil or self.spoil
            self.go(TOLD if first else LASTS)
            self.spoil = Base.spoil
            if self.pause < PUNCTUAL:
                break
        seen = [(t - began, v) for t, v in self.seen]
        times = [0.0, *(t for t, _ in seen)]
        return {
            "silence": max(self.pause, *(b - a for a, b in pairwise(times)), 0.0),
            "falls": next((t for t, v in seen if v < before - 0.02), None),
            "zero": next((t for t, v in seen if v == 0), None),
            "steps": max((a[1] - b[1] for a, b in pairwise(seen)), default=0),
            "said": sorted(set(self.said)),
            "last": seen[-1][1] if seen else None,
            "drives": max((v for _, v in seen[-10:]), default=0.0),
        }

    def out_of_order(self, message: Odometry) -> bool:
        """Send one that is older than the message before, so that a slow reader misses this one."""
        stamp = message.header.stamp
        earlier = stamp.sec * 1_000_000_000 + stamp.nanosec - 75_000_000
        message.header.stamp = rclpy.time.Time(nanoseconds=earlier).to_msg()
        after(0.004, lambda: self.odometry.publish(message))
        message.header.stamp = stamp
        return True

    def refused(self) -> int:
        """How many messages were refused for their order, as diagnostics tell it."""
        word = "odometry repeated or out of order"
        self.values.clear()
        self.go(5, lambda: word in self.values)
        return int(self.values.get(word, 0))

    def reset(self) -> bool:
        return bool(self.call(Trigger, "reset", Trigger.Request()).success)

    def leap(self, meters: float) -> None:
        self.pose[0] += meters

    def to(self, seconds: float) -> None:
        self.time += round(seconds * 1e9)


def start(scenario: str, *more: str) -> subprocess.Popen[bytes]:
    given = ["-p", f"scenario:={scenario}", "-p", "law:=kanayama", *AT_ONCE, *more]
    return subprocess.Popen([sys.executable, "-m", "wmr_ctrl.ros2", "drive", "--ros-args", *given])


def in_map(message: Odometry) -> bool:
    message.header.frame_id = "map"
    return True


def of_a_laser(message: Odometry) -> bool:
    message.child_frame_id = "laser"
    return True


def no_rotation(message: Odometry) -> bool:
    message.pose.pose.orientation.w = message.pose.pose.orientation.z = 0.0
    return True


def no_number(message: Odometry) -> bool:
    message.twist.twist.linear.x = float("nan")
    return True


def without_stamp(message: Odometry) -> bool:
    message.header.stamp.sec = message.header.stamp.nanosec = 0
    return True


def late(message: Odometry) -> bool:
    message.header.stamp.sec -= 1
    return True


def repeated() -> Callable[[Odometry], bool]:
    """Odometry with the stamp of the first one."""
    first: list[object] = []

    def again(message: Odometry) -> bool:
        first.append(message.header.stamp)
        message.header.stamp = first[0]
        return True

    return again


def too_fast(message: Odometry) -> bool:
    message.twist.twist.linear.x = 1.4
    return True


SPOILT = {
    "missing": lambda _: False, "in map": in_map, "of a laser": of_a_laser,
    "no rotation": no_rotation, "NaN": no_number, "without stamp": without_stamp, "old": late,
}  # fmt: skip


def in_real_time(scenario: str) -> dict[str, object]:
    process, found = start(scenario), {}
    base = Broken(simulated=False)
    try:
        for name, spoil in SPOILT.items():
            found[name] = base.fault(spoil)
        found["repeated"] = base.fault(repeated())
        before = base.refused()
        found["out of order"] = base.fault(base.out_of_order)
        found["out of order"]["refused"] = base.refused() - before
        found["pose leaps"] = base.fault(first=lambda: base.leap(1.0))
        found["too fast"] = base.fault(too_fast, first=lambda: None)
        base.go(0.5)
        found["latched"] = [base.speed[0], base.reset()]
        found["stop"] = base.fault(first=lambda: base.stop.publish(Bool(data=True)))
        found["reset while stopped"] = base.reset()
        base.stop.publish(Bool(data=False))
        base.go(0.3)
        found["stopped"] = [base.speed[0], base.reset()]
        found["drives again"] = base.go(10, base.drives)
    finally:
        process.kill()
        base.node.destroy_node()
    return found


def on_simulated_time(scenario: str) -> dict[str, object]:
    process, found = start(scenario, "-p", "use_sim_time:=true"), {}
    base = Broken(simulated=True)
    try:
        base.go(3.0)
        found["back"] = base.fault(first=lambda: base.to(-10.0))
        found["ahead"] = base.fault(first=lambda: base.to(10.0))

        def still() -> None:
            base.rate = 0.0

        found["stopped"] = base.fault(first=still)
        base.rate = 1.0
        found["drives again"] = base.go(10, base.drives)
    finally:
        process.kill()
        base.node.destroy_node()
    return found


def main(scenario: str) -> None:
    rclpy.init()
    tell({"real": in_real_time(scenario), "simulated": on_simulated_time(scenario)})


if __name__ == "__main__":
    main(sys.argv[1])
