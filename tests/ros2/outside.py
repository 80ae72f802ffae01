"""Faults around the filter node, from outside over DDS; run by a Python that has rclpy.

``python outside.py SCENARIO [NODE]`` starts the node (that in Python, or the program NODE), plays
base and planner, breaks one thing after the other and prints what was seen as JSON: per fault the
largest command, when it began to fall and when it was zero [s after the fault], the longest silence
of the node, and what diagnostics said.  A fault in which this process was late itself is repeated.
"""

import json
import math
import os
import signal
import subprocess
import sys
import time
from itertools import pairwise

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from nav_msgs.msg import Odometry
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

LATEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
SURE = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
KEPT = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
)
RATE = 0.02
SOON = "discovery_time:=0.0"
"""For nodes that need not look for others before they start."""
PUNCTUAL = 0.04
"""Delay of a message of this process [s] that is no fault of its own."""
ATTEMPTS = 40
"""At most so often a fault is made anew in which this process was late."""
BEFORE = math.inf
"""Age of a message that is stamped just before the last one, however long ago that came."""
LASTS = 0.9
"""Time of a fault [s], longer than any time-out and the ramp after it."""
MANY = 7
"""Zeros in a row by which they are known to go on."""
ON_THE_WAY = 0.2
"""Time in which what was sent before a signal has arrived [s]."""
QUIET = 0.5
"""Silence [s] of somebody who is known to be at rest: many of his ticks."""
PATIENCE = 120.0
"""Time [s] in which what must come is there, also on a machine that is very busy."""


class Kept:
    """What came from a node: ``seen``, rows that begin with a time, and ``said``."""

    def told(self, word):
        """Whether diagnostics have a word."""
        return any(word in text for text in self.said)

    def count_after_quiet(self, seconds, **how):
        """Commands that come in a time [s] after those that were on their way have come."""
        self.seen.clear()
        self.go(PATIENCE, until=quiet(self.seen), **how)
        self.seen.clear()
        self.go(seconds, **how)
        return len(self.seen)


class World(Kept):
    """Planner and base of the node: what they send can be changed, what comes back is kept."""

    def __init__(self, process):
        self.process = process
        self.node = rclpy.create_node("outside")
        self.commands = self.node.create_publisher(TwistStamped, "cmd_vel_in", SURE)
        self.odometry = self.node.create_publisher(Odometry, "odom", SURE)
        self.stop = self.node.create_publisher(Bool, "wmr_filter/stop", KEPT)
        self.node.create_subscription(TwistStamped, "cmd_vel", self._sent, SURE)
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._told, 10)
        self.seen = []
        self.said = []
        self.speed = (0.0, 0.0)
        self.pause = 0.0
        """Longest pause between two rounds of messages [s]."""
        self.sent = {"command": 0, "odometry": 0}
        """Stamp of the last message of each kind [ns]."""

    def _sent(self, message):
        self.speed = message.twist.linear.x, message.twist.angular.z
        self.seen.append((time.monotonic(), *self.speed))

    def _told(self, message):
        self.said += [status.message for status in message.status]

    def command(self, v=0.5, omega=0.3, ago=0.0, frame=""):
        message = TwistStamped()
        message.header.stamp = self._stamp_of("command", ago)
        message.header.frame_id = frame
        message.twist.linear.x, message.twist.angular.z = v, omega
        self.commands.publish(message)

    def measure(self, v=None, ago=0.0, frame="base_link", w=1.0):
        message = Odometry(child_frame_id=frame)
        message.header.stamp = self._stamp_of("odometry", ago)
        message.pose.pose.orientation.w = w
        message.twist.twist.linear.x = self.speed[0] if v is None else v
        message.twist.twist.angular.z = self.speed[1]
        self.odometry.publish(message)

    def _stamp_of(self, kind, ago):
        """Stamp of a message of an age."""
        if ago == BEFORE:
            return rclpy.time.Time(nanoseconds=self.sent[kind] - 1_000_000).to_msg()
        stamp = self._stamp(ago)
        self.sent[kind] = rclpy.time.Time.from_msg(stamp).nanoseconds
        return stamp

    def _stamp(self, ago):
        now = self.node.get_clock().now().nanoseconds - round(ago * 1e9)
        return rclpy.time.Time(nanoseconds=now).to_msg()

    def go(self, seconds, command=None, measure=None, until=lambda: False):
        """Send both at their rate; None: as in a sound world, False: nothing."""
        end = time.monotonic() + seconds
        before = time.monotonic()
        while time.monotonic() < end and not until():
            self.pause = max(self.pause, time.monotonic() - before)
            before = time.monotonic()
            if command is not False:
                (command or self.command)()
            if measure is not False:
                (measure or self.measure)()
            spin_for(self.node, RATE)

    def drive(self):
        """A sound world until the base drives."""
        self.go(PATIENCE, until=lambda: abs(self.speed[0] - 0.5) < 1e-6)
        if abs(self.speed[0] - 0.5) > 1e-6:
            raise SystemExit(f"the base never drove: {self.speed}, {self.said[-1:]}")

    def ended(self):
        """The last command and the exit code of a node that was interrupted."""
        self.go(PATIENCE, until=lambda: self.process.poll() is not None)
        self.go(PATIENCE, until=lambda: self.speed == (0.0, 0.0))
        return [list(self.speed), self.process.poll()]

    def zeros(self, count):
        """Zeros among the commands since the first ``count``."""
        return sum(1 for _, v, w in self.seen[count:] if v == w == 0)

    def go_until_said(self, word):
        """A sound world until diagnostics have a word: what they said till then."""
        self.said.clear()
        self.go(PATIENCE, until=lambda: self.told(word))
        return sorted(set(self.said))

    def fault(self, command=None, measure=None, first=None, rests=True, word=""):
        """What follows a fault: other messages, or what ``first`` does (once).

        It lasts until zeros have come for a while, or for LASTS where the base does not rest, and
        until diagnostics have the word: told each second, and at once only where it is news.
        """
        for _ in range(1 if first else ATTEMPTS):
            self.drive()
            start, count, self.pause = time.monotonic(), len(self.seen), 0.0
            self.said.clear()
            if first:
                first()
            lasts = PATIENCE if rests else LASTS
            self.go(lasts, command, measure, until=lambda count=count: self.zeros(count) > MANY)
            if word:
                self.go(PATIENCE, command, measure, until=lambda: self.told(word))
            if self.pause < RATE + PUNCTUAL:
                break
        seen = [(t - start, v, w) for t, v, w in self.seen[count:]]
        falls = [t for t, v, _ in seen if v < 0.499]
        zeros = [t for t, v, w in seen if v == w == 0]
        times = [0.0, *(t for t, _, _ in seen)]
        return {
            "largest": [max((abs(row[k]) for row in seen), default=0.0) for k in (1, 2)],
            "falls": falls[0] if falls else None,
            "zero": zeros[0] if zeros else None,
            "silence": silence(times) or LASTS,
            "zeros": len(zeros),
            "curvature": [w / v for _, v, w in seen if v > 0.1][-1:],
            "said": sorted(set(self.said)),
        }

    def call_reset(self):
        return bool(call(self.node, Trigger, "wmr_filter/reset", Trigger.Request()).success)


def launch(kind, *settings, remaps=(), node="", more=(), **how):
    """Start a node of ours with its parameters, or the program ``node``, which has none."""
    program = [node] if node else [sys.executable, "-m", "wmr_ctrl.ros2", kind]
    words = [part for item in settings for part in ("-p", item)]
    words += [part for item in remaps for part in ("-r", item)]
    return subprocess.Popen([*program, "--ros-args", *words, *more], **how)


def spin_for(node, seconds):
    """Let a node of this process hear for a time [s]."""
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        rclpy.spin_once(node, timeout_sec=left)


def call(node, kind, service, request):
    """Answer of a service."""
    client = node.create_client(kind, service)
    assert client.wait_for_service(PATIENCE), service
    future = client.call_async(request)
    rclpy.spin_until_future_complete(node, future, timeout_sec=PATIENCE)
    assert future.done(), service
    return future.result()


def has_set(node, of, name, value):
    """Whether a parameter of a node could be set."""
    wanted = SetParameters.Request(parameters=[Parameter(name, value=value).to_parameter_msg()])
    return bool(call(node, SetParameters, f"{of}/set_parameters", wanted).results[0].successful)


def has_changed(node, of, transition):
    """Whether a transition of a node's lifecycle succeeded."""
    wanted = ChangeState.Request(transition=Transition(id=transition))
    return bool(call(node, ChangeState, f"{of}/change_state", wanted).success)


def tell(found):
    """Print what was seen as JSON and end, before rclpy takes itself down: that may crash."""
    sys.stdout.write(json.dumps(found))
    sys.stdout.flush()
    os._exit(0)


def after(pause, *messages):
    """Messages one by one, with a pause [s] in which the node reads each."""
    for send in messages:
        send()
        time.sleep(pause)


def quiet(seen):
    """Whether nothing was added for QUIET to a list whose rows begin with a time, or since now."""
    now = time.monotonic()
    return lambda: time.monotonic() - (seen[-1][0] if seen else now) > QUIET


def silence(times):
    """Longest pause [s]; 0 where there is none."""
    return max((b - a for a, b in pairwise(times)), default=0.0)


def since_first_call():
    """A function of the time since its first call [s]: what is sent so long ago has one stamp."""
    calls = []

    def passed():
        calls.append(time.time())
        return calls[-1] - calls[0]

    return passed


def start(scenario, node="", *more, odometry="required", **how):
    """The filter in Python, or the program ``node``, whose settings are compiled in."""
    settings = [] if node else [f"scenario:={scenario}", f"odometry:={odometry}", SOON]
    return launch("filter", *settings, node=node, more=more, **how)


def of_commands(world):
    """Faults of what is sent to the node."""
    ago = since_first_call()
    best = world.node.create_publisher(TwistStamped, "cmd_vel_in", LATEST)
    sure = world.commands
    uncounted = {
        "missing": False,
        "NaN": lambda: world.command(math.nan),
        "infinite": lambda: world.command(math.inf),
        "old": lambda: world.command(ago=1.0),
        "ahead": lambda: world.command(ago=-1.0),
        "repeated": lambda: world.command(ago=ago()),
        "in map": lambda: world.command(frame="map"),
    }
    found = {
        name: world.fault(command=command, word="no-command") for name, command in uncounted.items()
    }
    found["wild"] = world.fault(command=lambda: world.command(5.0, 3.0), rests=False)
    found["out of order"] = world.fault(
        command=lambda: after(0.004, lambda: world.command(0.1, ago=BEFORE), world.command),
        rests=False,
    )
    world.commands = best
    found["best effort"] = world.fault(rests=False)
    world.commands = sure
    world.node.destroy_publisher(best)
    return found


def of_odometry(world):
    """Faults of the base's odometry."""
    ago = since_first_call()
    uncounted = {
        "missing": False,
        "NaN": lambda: world.measure(math.nan),
        "no rotation": lambda: world.measure(w=0.0),
        "of a laser": lambda: world.measure(frame="laser"),
        "old": lambda: world.measure(ago=0.5),
        "repeated": lambda: world.measure(ago=ago()),
    }
    found = {
        name: world.fault(measure=measure, word="no-odometry")
        for name, measure in uncounted.items()
    }
    found["out of order"] = world.fault(
        measure=lambda: after(0.004, lambda: world.measure(1.4, ago=BEFORE), world.measure),
        rests=False,
    )
    found["too fast"] = world.fault(
        first=lambda: None, measure=lambda: world.measure(1.4), word="stopped, too-fast"
    )
    return found


def main(scenario, node=""):
    process = start(scenario, node)
    rclpy.init()
    world, found = World(process), {}
    try:
        found["sound"] = world.fault(rests=False)
        found["command"] = of_commands(world)
        found["odometry"] = of_odometry(world)
        found["latched"] = {"zero": world.speed == (0.0, 0.0)}
        world.go(0.3)
        found["latched"]["stays"] = world.speed == (0.0, 0.0)
        found["latched"]["reset"] = world.call_reset()
        found["stop"] = world.fault(first=lambda: world.stop.publish(Bool(data=True)))
        found["stop"]["reset while it says so"] = world.call_reset()
        world.stop.publish(Bool(data=False))
        world.go(0.3)
        found["stop"]["stays"] = world.speed == (0.0, 0.0)
        world.go(PATIENCE, until=world.call_reset)
        found["stop"]["reset"] = world.call_reset()
        rival = world.node.create_publisher(TwistStamped, "cmd_vel", SURE)
        began = time.monotonic()
        world.seen.clear()
        found["rival"] = world.go_until_said("other publishers")
        found["rival after"] = time.monotonic() - began
        found["rival silence"] = silence([began, *(t for t, *_ in world.seen), time.monotonic()])
        world.node.destroy_publisher(rival)
        world.drive()
        process.send_signal(signal.SIGINT)
        found["interrupt"] = world.ended()
    finally:
        process.kill()
    tell(found)


if __name__ == "__main__":
    main(*sys.argv[1:])
