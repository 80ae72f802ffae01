"""Exceptions in a node's callbacks, seen over DDS; run by a Python that has rclpy.

``python broken_inside.py SCENARIO drive|filter`` runs the real node beside a base that does at once
what it is told.  One after the other what a callback calls raises, then is whole again; what was
seen is printed as JSON.
"""

import sys
import threading
import time

import rclpy
from drive_live import Base
from geometry_msgs.msg import TwistStamped
from outside import KEPT, ON_THE_WAY, PATIENCE, SOON, SURE, quiet, tell
from rcl_interfaces.msg import Log
from rclpy.executors import SingleThreadedExecutor
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from wmr_ctrl.ros2.drive_node import DriveNode
from wmr_ctrl.ros2.filter_node import FilterNode

CALLED = {
    "drive": ("odometry", "tick", "halt", "reset", "send", "details"),
    "filter": ("command", "measure", "tick", "halt", "reset", "send", "details"),
}
"""What the callbacks call, of the core or else of the node."""


def breaks(*_given, **_named):
    raise RuntimeError("broken inside")


class Beside(Base):
    """Base, planner and reader of the log."""

    def __init__(self, name):
        super().__init__()
        self.name, self.log = name, []
        self.commands = self.node.create_publisher(TwistStamped, "cmd_vel_in", SURE)
        self.stop = self.node.create_publisher(Bool, f"wmr_{name}/stop", KEPT)
        self.reset = self.node.create_client(Trigger, f"wmr_{name}/reset")
        self.node.create_subscription(Log, "/rosout", self._logged, 100)

    def _logged(self, message):
        if message.level == 50 and message.name == f"wmr_{self.name}":
            self.log.append(message.msg)

    def spoil(self, message):
        """Send a command with each odometry."""
        if self.name == "filter":
            command = TwistStamped(header=message.header)
            command.header.frame_id = ""
            command.twist.linear.x = 0.3
            self.commands.publish(command)
        return True

    def fault(self, node, called):
        """What is seen while something raises, and whether the base drives when it does not."""
        if not self.go(PATIENCE, lambda: self.speed[0] > 0.1):
            raise SystemExit(f"the base never drove before {called}: {self.said[-3:]}")
        owner = node.core if hasattr(node.core, called) else node
        setattr(owner, called, breaks)
        if called == "send":  # what was sent before has come
            self.seen.clear()
            self.go(PATIENCE, quiet(self.seen))
        self.go(ON_THE_WAY)
        for kept in (self.seen, self.log, self.said):
            kept.clear()
        self.stop.publish(Bool(data=called == "halt"))
        answer = self.reset.call_async(Trigger.Request()) if called == "reset" else None
        untold = called == "details"  # of which diagnostics are made

        def done():
            zero = called == "send" or any(v == 0.0 for _, v in self.seen)
            return zero and bool(self.log) and (untold or any("broken" in s for s in self.said))

        told = self.go(PATIENCE, done)
        self.go(ON_THE_WAY)
        delattr(owner, called)
        found = {
            "told": told, "log": self.log[:1], "zero": any(v == 0.0 for _, v in self.seen),
            "sent": len(self.seen), "answer": None,
        }  # fmt: skip
        if answer is not None:
            self.go(PATIENCE, answer.done)
            found["answer"] = [answer.result().success, answer.result().message]
        self.stop.publish(Bool(data=False))
        if called == "halt":  # what must stop stays so until a reset
            self.seen.clear()
            self.go(1.0)
            self.go(PATIENCE, lambda: bool(self.seen))
            found["stays"] = all(v == 0.0 for _, v in self.seen)
            self.go(PATIENCE, self.reset.call_async(Trigger.Request()).done)
        self.speed = (0.0, 0.0) if called == "send" else self.speed  # a base's own time-out
        self.seen.clear()
        self.go(ON_THE_WAY)
        return found | {"drives on": self.go(PATIENCE, lambda: self.speed[0] > 0.1)}


def main(scenario, name):
    own = {"drive": "law:=kanayama", "filter": "odometry:=required"}
    given = [part for item in (f"scenario:={scenario}", own[name], SOON) for part in ("-p", item)]
    rclpy.init(args=["--ros-args", *given])
    node = (DriveNode if name == "drive" else FilterNode)()
    node.trigger_configure()
    node.trigger_activate()
    executor, ended = SingleThreadedExecutor(), threading.Event()
    executor.add_node(node)

    def spin():
        while not ended.is_set():
            executor.spin_once(timeout_sec=0.1)

    thread = threading.Thread(target=spin, daemon=True)
    thread.start()
    base = Beside(name)
    found = {called: base.fault(node, called) for called in CALLED[name]}
    found["alive"] = thread.is_alive()
    ended.set()
    thread.join(5.0)
    time.sleep(ON_THE_WAY)
    tell(found)


if __name__ == "__main__":
    main(*sys.argv[1:])
