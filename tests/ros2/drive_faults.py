"""Faults around the drive, from outside over DDS; run by a Python that has rclpy.

``python drive_faults.py SCENARIO`` plays a base that does at once what it is told, breaks one thing
after the other, and prints what was seen as JSON: per fault when the command began to fall and when
it was zero [s after the fault], what diagnostics said, and whether it drove again.  Then the same
on simulated time that stops, goes back and leaps ahead.
"""

import sys
import time
from itertools import pairwise

import rclpy
from drive_live import KEPT, SURE, Base
from outside import (
    ATTEMPTS,
    LASTS,
    MANY,
    PATIENCE,
    PUNCTUAL,
    SOON,
    after,
    call,
    launch,
    silence,
    tell,
)
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

CRUISE = 0.25
"""Speed [m/s] of a base that follows its circle, nearly."""


AWAITED = 10.0
"""Time [s] in which what follows a leap is there, else it is made again."""


class Broken(Base):
    """A base whose odometry can be spoilt, perhaps on a time of its own."""

    def __init__(self, simulated):
        super().__init__()
        self.clock = self.node.create_publisher(Clock, "/clock", SURE)
        self.stop = self.node.create_publisher(Bool, "/wmr_drive/stop", KEPT)
        self.time, self.rate, self.simulated = 1_000_000_000_000, 1.0, simulated
        self.before = 0.0
        """Speed before a fault [m/s]."""

    def stamp(self):
        if not self.simulated:
            return super().stamp()
        self.time += round(1e9 * self.period * self.rate)
        now = rclpy.time.Time(nanoseconds=self.time).to_msg()
        self.clock.publish(Clock(clock=now))
        return now

    def drives(self):
        return self.speed[0] > CRUISE

    def fell(self):
        """Whether a command below that before the fault has come."""
        return any(v < self.before - 0.02 for _, v in self.seen)

    def rested(self, word="no-odometry"):
        """Whether zeros came for a while, and a word was told."""
        return lambda: self.told(word) and [v for _, v in self.seen[-MANY:]] == [0.0] * MANY

    def goes_on(self, word):
        """Whether the base drives again after it braked, and a word was told."""
        return lambda: self.told(word) and self.fell() and self.drives()

    def drive(self):
        """A sound world until the base has driven for a while, and still does."""
        for _ in range(ATTEMPTS):
            if self.go(PATIENCE, self.drives) and not self.go(0.3) and self.drives():
                return
        raise SystemExit(f"the base never drove: {self.said[-3:]}")

    def fault(self, spoil=None, first=None, until=None, again=False):
        """What follows a fault that lasts for LASTS, or ``until`` something is true.

        It is made again where this process was late, but what is done ``first`` only if ``again``:
        then also where it was not true in time, as of a leap while the node had no odometry.
        """
        for _ in range(1 if first and not again else ATTEMPTS):
            self.drive()
            self.seen.clear()
            self.said.clear()
            self.before, began, self.pause = self.speed[0], time.monotonic(), 0.0
            if first:
                first()
            self.spoil = spoil or self.spoil
            there = self.go(AWAITED if again else PATIENCE, until) if until else self.go(LASTS)
            self.spoil = Base.spoil
            if self.pause < self.period + PUNCTUAL and (there or not again):
                break
        seen = [(t - began, v) for t, v in self.seen]
        times = [0.0, *(t for t, _ in seen)]
        return {
            "silence": max(self.pause, silence(times)),
            "falls": next((t for t, v in seen if v < self.before - 0.02), None),
            "zero": next((t for t, v in seen if v == 0), None),
            "steps": max((a[1] - b[1] for a, b in pairwise(seen)), default=0),
            "said": sorted(set(self.said)),
            "last": seen[-1][1] if seen else None,
            "drives": max((v for _, v in seen[-10:]), default=0.0),
        }

    def out_of_order(self, message):
        """Send one that is older than the message before, so that a slow reader misses this one."""
        stamp = message.header.stamp
        earlier = stamp.sec * 1_000_000_000 + stamp.nanosec - 75_000_000
        message.header.stamp = rclpy.time.Time(nanoseconds=earlier).to_msg()
        after(0.004, lambda: self.odometry.publish(message))
        message.header.stamp = stamp
        return True

    def refused(self):
        """How many messages were refused for their order, as diagnostics tell it."""
        word = "odometry repeated or out of order"
        self.values.clear()
        self.go(PATIENCE, lambda: word in self.values)
        return int(self.values.get(word, 0))

    def reset(self):
        return bool(call(self.node, Trigger, "wmr_drive/reset", Trigger.Request()).success)

    def spoilt(self):
        """Apply each fault of odometry in turn; return what the node did, by fault."""
        found = {"well": self.go(PATIENCE, lambda: self.told("driving"))}
        for name, spoil in {**SPOILT, "repeated": repeated()}.items():
            found[name] = self.fault(spoil, until=self.rested())
        before = self.refused()
        found["out of order"] = self.fault(self.out_of_order)
        found["out of order"]["refused"] = self.refused() - before
        return found | {"pose leaps": self.leaps("pose-jump", lambda: self.leap(1.0))}

    def stopped(self, command):
        """What follows a stop, with what is commanded after it ended and before the reset."""
        stop = Bool(data=True)
        found = {"stop": self.fault(None, lambda: self.stop.publish(stop), self.rested("stopped"))}
        found["reset while stopped"] = self.reset()
        self.stop.publish(Bool(data=False))
        self.go(0.3)
        found["stopped"] = [command(), self.go(PATIENCE, self.reset)]
        return found | {"drives again": self.go(PATIENCE, self.drives)}

    def times(self):
        """What follows when the clock goes back, leaps ahead, and stops."""
        found = {
            "back": self.leaps("time-back", lambda: self.to(-10.0)),
            "ahead": self.leaps("time-forth", lambda: self.to(10.0)),
        }

        def still():
            self.rate = 0.0

        found["stopped"] = self.fault(first=still, until=self.rested())
        self.rate = 1.0
        return found | {"drives again": self.go(PATIENCE, self.drives)}

    def leaps(self, word, leap):
        """What follows a leap, of which a word is told."""
        return self.fault(first=leap, until=self.goes_on(word), again=True)

    def leap(self, meters):
        self.pose[0] += meters

    def to(self, seconds):
        self.time += round(seconds * 1e9)


def start(scenario, *more):
    return launch("drive", f"scenario:={scenario}", "law:=kanayama", SOON, *more)


def in_map(message):
    message.header.frame_id = "map"
    return True


def of_a_laser(message):
    message.child_frame_id = "laser"
    return True


def no_rotation(message):
    message.pose.pose.orientation.w = message.pose.pose.orientation.z = 0.0
    return True


def no_number(message):
    message.twist.twist.linear.x = float("nan")
    return True


def without_stamp(message):
    message.header.stamp.sec = message.header.stamp.nanosec = 0
    return True


def late(message):
    message.header.stamp.sec -= 1
    return True


def repeated():
    """Odometry with the stamp of the first one."""
    first = []

    def again(message):
        first.append(message.header.stamp)
        message.header.stamp = first[0]
        return True

    return again


def too_fast(message):
    message.twist.twist.linear.x = 1.4
    return True


SPOILT = {
    "missing": lambda _: False, "in map": in_map, "of a laser": of_a_laser,
    "no rotation": no_rotation, "NaN": no_number, "without stamp": without_stamp, "old": late,
}  # fmt: skip


def in_real_time(scenario):
    process, found = start(scenario), {}
    base = Broken(simulated=False)
    try:
        found |= base.spoilt()
        found["too fast"] = base.fault(too_fast, lambda: None, base.rested("too-fast"))
        base.go(0.5)
        found["latched"] = [base.speed[0], base.reset()]
        found |= base.stopped(lambda: base.speed[0])
    finally:
        process.kill()
        base.node.destroy_node()
    return found


def simulated(kind, scenario):
    """Run a base of this kind on simulated time that leaps; return what was seen."""
    process, base = start(scenario, "use_sim_time:=true"), kind(simulated=True)
    try:
        found = base.times()
    finally:
        process.kill()
        base.node.destroy_node()
    return found


def main(scenario):
    rclpy.init()
    tell({"real": in_real_time(scenario), "simulated": simulated(Broken, scenario)})


if __name__ == "__main__":
    main(sys.argv[1])
