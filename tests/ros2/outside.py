"""Surroundings of a node over DDS, seen from outside; imported by scripts for a Python with rclpy.

A base that follows its commands without delay and reports its motion as odometry, with a planner
for the filter; faults of both, and the node's reactions.
"""

import json
import math
import os
import signal
import subprocess
import sys
import time
from copy import deepcopy
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
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

LATEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
SURE = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
KEPT = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
)
CONFIGURE, CLEAN_UP, ACTIVATE, DEACTIVATE = 1, 2, 3, 4
"""Transitions of a lifecycle."""
RATE = 0.02
SOON = "discovery_time:=0.0"
"""Setting for nodes that need not look for others before they start."""
PUNCTUAL = 0.04
"""Delay of a message of this process [s] that is no fault of its own."""
ATTEMPTS = 40
"""Most repetitions of a fault in which this process was late."""
LASTS = 0.9
"""Time of a fault [s], longer than any time-out and the ramp after it."""
AWAITED = 10.0
"""Time [s] in which what follows a leap is there, else it is made again."""
MANY = 7
"""Zeros in a row by which they are known to go on."""
ON_THE_WAY = 0.2
"""Time in which what was sent before a signal has arrived [s]."""
QUIET = 0.5
"""Silence [s] of somebody who is known to be at rest: many of his ticks."""
PATIENCE = 120.0
"""Time [s] in which what must come is there, also on a machine that is very busy."""
OLDER = 75_000_000
"""Age [ns] of a message that is older than the one before it, so that a slow reader misses that."""


class Base:
    """A base that follows its commands without delay.

    It stores its node's messages: ``seen``, rows of a time and a command; ``said``, the sentences
    of diagnostics; and ``details``, all their values.
    """

    name, period, cruise = "wmr_drive", RATE, 0.25
    """Name of the node; time between messages [s]; speed [m/s] at which it drives."""

    def __init__(self, process=None, simulated=False):
        self.process, self.simulated = process, simulated
        self.node = rclpy.create_node("outside")
        self.odometry = self.node.create_publisher(Odometry, "odom", SURE)
        self.clock = self.node.create_publisher(Clock, "/clock", SURE)
        self.stop = self.node.create_publisher(Bool, f"{self.name}/stop", KEPT)
        self.node.create_subscription(TwistStamped, "cmd_vel", self._came, SURE)
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._told, 10)
        self.pose, self.speed = [0.0, 0.0, 0.0], (0.0, 0.0)
        self.seen, self.said, self.details = [], [], []
        self.time, self.rate = 1_000_000_000_000, 1.0
        self.before = 0.0
        """Speed before a fault [m/s]."""
        self.pause = 0.0
        """Longest pause between two rounds of messages [s]."""

    def _came(self, message):
        self.speed = message.twist.linear.x, message.twist.angular.z
        self.seen.append((time.monotonic(), *self.speed))

    def _told(self, message):
        for status in message.status:
            self.said.append(status.message)
            self.details.append({item.key: item.value for item in status.values})

    def told(self, word):
        """True if diagnostics contain a word."""
        return any(word in text for text in self.said)

    def stamp(self, ago=0.0):
        """Time of a message of an age [s]."""
        now = self.time if self.simulated else self.node.get_clock().now().nanoseconds
        return stamp_of(now - round(ago * 1e9))

    def move(self):
        """Update pose and speed by a period's motion."""
        x, y, yaw = self.pose
        way, turn = (self.period * speed for speed in self.speed)
        self.pose = [x + way * math.cos(yaw), y + way * math.sin(yaw), yaw + turn]

    def round(self, spoil=None):
        """Send the messages of a period; ``spoil`` changes odometry, which is not sent if False."""
        if self.simulated:
            self.time += round(1e9 * self.period * self.rate)
            self.clock.publish(Clock(clock=self.stamp()))
        self.move()
        x, y, yaw = self.pose
        turn = 0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)
        self.publish(self.odometry, odometry_of(self.stamp(), (x, y), turn, self.speed), spoil)

    def publish(self, publisher, message, spoil):
        """Send a message that ``spoil`` has changed, and an older one before it if ``spoil`` says
        so.
        """
        changed = spoil(message) if spoil else None
        if changed is not None and changed is not False:
            publisher.publish(changed)
            time.sleep(0.004)  # in which the node reads it
        if changed is not False:
            publisher.publish(message)

    def go(self, seconds, until=lambda: False, **how):
        """Send rounds; return True if ``until`` became true."""
        end, before = time.monotonic() + seconds, time.monotonic()
        while time.monotonic() < end and not until():
            self.pause = max(self.pause, time.monotonic() - before)
            before = time.monotonic()
            self.round(**how)
            spin_for(self.node, self.period)
        return until()

    def drives(self):
        return self.speed[0] > self.cruise

    def drive(self):
        """Run without faults until the base has driven for a while, and still does."""
        for _ in range(ATTEMPTS):
            if self.go(PATIENCE, self.drives) and not self.go(0.3) and self.drives():
                return
        raise SystemExit(f"the base never drove: {self.speed}, {self.said[-3:]}")

    def until_said(self, word, **how):
        """Run rounds until diagnostics have a word; return the sentences reported until then."""
        self.said.clear()
        self.go(PATIENCE, lambda: self.told(word), **how)
        return sorted(set(self.said))

    def fell(self):
        """True if a command below the one before the fault has come."""
        return any(row[1] < self.before - 0.02 for row in self.seen)

    def rested(self, word):
        """Condition that zeros came for a while and diagnostics reported a word."""
        return lambda: (
            self.told(word) and [any(row[1:]) for row in self.seen[-MANY:]] == ([False] * MANY)
        )

    def fault(self, until=None, first=None, again=False, **how):
        """Reaction to a fault: altered rounds, or an action ``first`` (once).

        It lasts for LASTS, or ``until`` a condition is true.  It is repeated if this process was
        late; a fault with an action ``first`` is repeated only if ``again``, and then also if the
        condition was not true in time, as for a leap while the node had no odometry.
        """
        lasts = LASTS if until is None else AWAITED if again else PATIENCE
        for _ in range(1 if first and not again else ATTEMPTS):
            self.drive()
            self.seen.clear()
            self.said.clear()
            self.before, began, self.pause = self.speed[0], time.monotonic(), 0.0
            if first:
                first()
            there = self.go(lasts, until or (lambda: False), **how)
            if self.pause < self.period + PUNCTUAL and (there or not again):
                break
        seen = [(t - began, *sent) for t, *sent in self.seen]
        speeds = [row[1] for row in seen]
        return {
            "silence": max(self.pause, silence([0.0, *(row[0] for row in seen)])),
            "falls": next((t for t, v, *_ in seen if v < self.before - 0.02), None),
            "zero": next((t for t, *sent in seen if not any(sent)), None),
            "steps": max((a - b for a, b in pairwise(speeds)), default=0),
            "last": seen[-1][1:] if seen else None,
            "drives": max(speeds[-10:], default=0.0),
            "there": there,
            "said": sorted(set(self.said)),
        }

    def reset(self):
        return bool(call(self.node, Trigger, f"{self.name}/reset", Trigger.Request()).success)

    def refused(self):
        """Number of odometry messages refused for their order, as diagnostics report it."""
        self.details.clear()
        self.go(PATIENCE, lambda: bool(self.details))
        counts = self.details[-1].items()
        return sum(
            int(count) for what, count in counts
            if what.startswith("odometry") and what.endswith("out of order")
        )  # fmt: skip

    def out_of_order(self):
        """Reaction to odometry that is out of order, and the number of refused messages."""
        before = self.refused()
        found = self.fault(spoil=out_of_order())
        return found | {"refused": self.refused() - before}

    def latched(self):
        """Reaction to too fast odometry followed by sound odometry, and to a reset."""
        fast = self.fault(self.rested("too-fast"), first=lambda: None, spoil=speed(1.4))
        self.go(0.5)
        return {"too fast": fast, "latched": [self.seen[-1][1:], self.reset()]}

    def stopped(self):
        """Reaction to a stop, with the commands after its end and before the reset."""
        stop = Bool(data=True)
        found = {"stop": self.fault(self.rested("stopped"), lambda: self.stop.publish(stop))}
        found["reset while stopped"] = self.reset()
        self.stop.publish(Bool(data=False))
        self.go(0.3)
        found["stopped"] = [self.seen[-1][1:], self.go(PATIENCE, self.reset)]
        return found | {"drives again": self.go(PATIENCE, self.drives)}

    def count_after_quiet(self, seconds, **how):
        """Number of commands within ``seconds`` [s] after those in transit have arrived."""
        for lasts, until in ((PATIENCE, quiet(self.seen)), (seconds, lambda: False)):
            self.rest()
            self.seen.clear()
            self.go(lasts, until, **how)
        return len(self.seen)

    def rest(self):
        """The base's own time-out."""
        self.speed = 0.0, 0.0

    def frozen(self, **how):
        """Number of commands while the process is frozen, before it continues."""
        self.process.send_signal(signal.SIGSTOP)
        count = self.count_after_quiet(0.6, **how)
        self.process.send_signal(signal.SIGCONT)
        return count

    def killed(self, restart, **how):
        """Number of commands after SIGKILL, and the largest one after a restart."""
        self.process.kill()
        self.process.wait()
        found = {"after the kill": self.count_after_quiet(0.5)}
        self.process = restart()
        self.seen.clear()
        self.go(PATIENCE, lambda: len(self.seen) > 10, **how)
        return found | {"next life": max(abs(row[1]) for row in self.seen)}

    def interrupted(self):
        """The last command and the exit code of the node after SIGINT."""
        self.process.send_signal(signal.SIGINT)
        self.go(PATIENCE, lambda: self.process.poll() is not None)
        self.go(PATIENCE, lambda: bool(self.seen) and not any(self.seen[-1][1:]))
        return [self.seen[-1][1:], self.process.poll()]


class World(Base):
    """Planner and base of the filter."""

    name = "wmr_filter"

    def __init__(self, process=None, simulated=False):
        super().__init__(process, simulated)
        self.commands = self.node.create_publisher(TwistStamped, "cmd_vel_in", SURE)

    def drives(self):
        return abs(self.speed[0] - 0.5) < 1e-6

    def round(self, spoil=None, command=None):
        """Send odometry, and the result of ``command``; no command if it is False."""
        super().round(spoil)
        if command is not False:
            (command or self.command)()

    def command(self, v=0.5, omega=0.3, change=None):
        """Send a command, which ``change`` may alter."""
        self.publish(self.commands, command_of(self.stamp(), v, omega), change)


# -- messages, and what spoils them -----------------------------------------------------------


def stamp_of(nanoseconds):
    return rclpy.time.Time(nanoseconds=nanoseconds).to_msg()


def odometry_of(stamp, place, turn, velocity):
    """Odometry at a place (x, y), with an orientation (x, y, z, w) and a velocity (v, omega)."""
    message = Odometry(child_frame_id="base_link")
    message.header.stamp, message.header.frame_id = stamp, "odom"
    pose, twist = message.pose.pose, message.twist.twist
    pose.position.x, pose.position.y = place
    seen = pose.orientation
    seen.x, seen.y, seen.z, seen.w = turn
    twist.linear.x, twist.angular.z = velocity
    return message


def command_of(stamp, v, omega):
    message = TwistStamped()
    message.header.stamp = stamp
    message.twist.linear.x, message.twist.angular.z = v, omega
    return message


def missing(_message):
    return False


def in_map(message):
    message.header.frame_id = "map"


def of_a_laser(message):
    message.child_frame_id = "laser"


def no_rotation(message):
    message.pose.pose.orientation.w = message.pose.pose.orientation.z = 0.0


def without_stamp(message):
    message.header.stamp = stamp_of(0)


def speed(v):
    """Alteration: another speed [m/s] in a message."""

    def spoil(message):
        getattr(message.twist, "twist", message.twist).linear.x = v

    return spoil


def older(seconds):
    """Alteration: a stamp that is older by some seconds."""

    def spoil(message):
        message.header.stamp.sec -= seconds

    return spoil


def repeated():
    """Alteration: the stamp of the first altered message."""
    first = []

    def spoil(message):
        first.append(message.header.stamp)
        message.header.stamp = first[0]

    return spoil


def out_of_order(v=None):
    """Alteration: a message before this one, older than the last, with another speed [m/s] if one
    is given.
    """

    def spoil(message):
        before, sent = deepcopy(message), rclpy.time.Time.from_msg(message.header.stamp)
        before.header.stamp = stamp_of(sent.nanoseconds - OLDER)
        if v is not None:
            speed(v)(before)
        return before

    return spoil


def faults():
    """Alterations of commands or odometry, by name."""
    return {
        "missing": missing, "in map": in_map, "of a laser": of_a_laser,
        "no rotation": no_rotation, "NaN": speed(math.nan), "infinite": speed(math.inf),
        "without stamp": without_stamp, "old": older(1), "ahead": older(-1),
        "repeated": repeated(),
    }  # fmt: skip


# -- nodes ------------------------------------------------------------------------------------


def launch(kind, *settings, remaps=(), node="", more=(), **how):
    """Start a node of ours with its parameters, or the program ``node``, which has none."""
    program = [node] if node else [sys.executable, "-m", "wmr_ctrl.ros2", kind]
    words = [part for item in settings for part in ("-p", item)]
    words += [part for item in remaps for part in ("-r", item)]
    return subprocess.Popen([*program, "--ros-args", *words, *more], **how)


def start(scenario, node="", *more, odometry="required", **how):
    """Start the filter in Python, or the program ``node``, whose settings are compiled in."""
    settings = [] if node else [f"scenario:={scenario}", f"odometry:={odometry}", SOON]
    return launch("filter", *settings, node=node, more=more, **how)


def start_drive(scenario, *more, looks=0.0):
    """Start the drive with Kanayama's law."""
    given = [f"scenario:={scenario}", "law:=kanayama", *more]
    return launch("drive", *given, f"discovery_time:={looks}")


def spin_for(node, seconds):
    """Let a node of this process receive messages for a time [s]."""
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
    """True if a parameter of a node could be set."""
    wanted = SetParameters.Request(parameters=[Parameter(name, value=value).to_parameter_msg()])
    return bool(call(node, SetParameters, f"{of}/set_parameters", wanted).results[0].successful)


def has_changed(node, of, transition):
    """True if a transition of a node's lifecycle succeeded."""
    wanted = ChangeState.Request(transition=Transition(id=transition))
    return bool(call(node, ChangeState, f"{of}/change_state", wanted).success)


def tell(found):
    """Print the results as JSON and end before rclpy shuts down, which may crash."""
    sys.stdout.write(json.dumps(found))
    sys.stdout.flush()
    os._exit(0)


def quiet(seen):
    """True if nothing was added for QUIET to a list whose rows begin with a time, or since now."""
    now = time.monotonic()
    return lambda: time.monotonic() - (seen[-1][0] if seen else now) > QUIET


def silence(times):
    """Longest pause [s]; 0 if there is none."""
    return max((b - a for a, b in pairwise(times)), default=0.0)
