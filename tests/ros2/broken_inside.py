"""Exceptions in a node's callbacks, seen over DDS; run by a Python that has rclpy.

``python broken_inside.py SCENARIO drive|filter`` runs the real node beside a base that follows its
commands without delay.  One after the other, each function that a callback calls raises, then works
again; the reactions are printed as JSON.
"""

import sys
import threading
import time

import rclpy
from outside import ON_THE_WAY, PATIENCE, SOON, Base, World, quiet, tell
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
"""Functions that callbacks call, of the core or else of the node."""


def breaks(*_given, **_named):
    raise RuntimeError("broken inside")


def log_of(base):
    """Fatal messages of a base's node, in order of arrival."""
    log = []

    def logged(message):
        if message.level == 50 and message.name == base.name:
            log.append(message.msg)

    base.node.create_subscription(Log, "/rosout", logged, 100)
    return log


def fault(base, log, node, called):
    """Behaviour while a function raises, and whether the base drives afterwards."""
    if not base.go(PATIENCE, base.drives):
        raise SystemExit(f"the base never drove before {called}: {base.said[-3:]}")
    reset = base.node.create_client(Trigger, f"{base.name}/reset")
    owner = node.core if hasattr(node.core, called) else node
    setattr(owner, called, breaks)
    if called == "send":  # what was sent before has come
        base.seen.clear()
        base.go(PATIENCE, quiet(base.seen))
    base.go(ON_THE_WAY)
    for kept in (base.seen, log, base.said):
        kept.clear()
    base.stop.publish(Bool(data=called == "halt"))
    answer = reset.call_async(Trigger.Request()) if called == "reset" else None
    untold = called == "details"  # of which diagnostics are made

    def done():
        zero = called == "send" or any(v == 0.0 for _, v, _ in base.seen)
        return zero and bool(log) and (untold or base.told("broken"))

    told = base.go(PATIENCE, done)
    base.go(ON_THE_WAY)
    delattr(owner, called)
    found = {
        "told": told, "log": log[:1], "zero": any(v == 0.0 for _, v, _ in base.seen),
        "sent": len(base.seen), "answer": None,
    }  # fmt: skip
    if answer is not None:
        base.go(PATIENCE, answer.done)
        found["answer"] = [answer.result().success, answer.result().message]
    base.stop.publish(Bool(data=False))
    if called == "halt":  # what must stop stays so until a reset
        base.seen.clear()
        base.go(1.0)
        base.go(PATIENCE, lambda: bool(base.seen))
        found["stays"] = all(v == 0.0 for _, v, _ in base.seen)
        base.go(PATIENCE, reset.call_async(Trigger.Request()).done)
    if called == "send":
        base.rest()
    base.seen.clear()
    base.go(ON_THE_WAY)
    return found | {"drives on": base.go(PATIENCE, base.drives)}


def main(scenario, name):
    own = {"drive": "law:=kanayama", "filter": "odometry:=required"}
    given = [part for item in (f"scenario:={scenario}", own[name], SOON) for part in ("-p", item)]
    rclpy.init(args=["--ros-args", *given])
    node, kind = (DriveNode(), Base) if name == "drive" else (FilterNode(), World)
    node.trigger_configure()
    node.trigger_activate()
    executor, ended = SingleThreadedExecutor(), threading.Event()
    executor.add_node(node)

    def spin():
        while not ended.is_set():
            executor.spin_once(timeout_sec=0.1)

    thread = threading.Thread(target=spin, daemon=True)
    thread.start()
    base = kind()
    log = log_of(base)
    found = {called: fault(base, log, node, called) for called in CALLED[name]}
    found["alive"] = thread.is_alive()
    ended.set()
    thread.join(5.0)
    time.sleep(ON_THE_WAY)
    tell(found)


if __name__ == "__main__":
    main(*sys.argv[1:])
