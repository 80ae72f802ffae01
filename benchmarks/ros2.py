"""Latency of the ROS 2 nodes here: ``ENV/bin/python -m benchmarks.ros2 [--node PROGRAM]``.

Runs in a Python that has rclpy.  Odometry is sent at 100 Hz, each message when the answer to the
one before has come or PATIENCE is over, and the time from sending to the command's arrival is
taken: through ``wmr_drive`` alone, through it and ``wmr_filter`` in Python, and through it and the
program that ``wmr-ctrl codegen filter --ros2 --param trigger=command`` was compiled to.  Each at
ordinary priority and by SCHED_FIFO, where that is allowed, as the machine is and with busy loops
beside.
"""

from __future__ import annotations

import argparse
import math
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import rclpy
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.qos import QoSProfile, ReliabilityPolicy

PERIOD = 0.01
SAMPLES = 1500
PATIENCE = 0.2
FIFO = 20
BUSY = 4
SURE = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
SCENARIO = f"""
extends = "turtlebot3-burger"
[clock]
control = {PERIOD}
[filter]
kind = "clip"
"""
"""Scenario with the node's limits; compile PROGRAM with the same."""


class Base:
    """Standing base that sends odometry and receives commands."""

    def __init__(self) -> None:
        self.node = rclpy.create_node("base")
        self.odometry = self.node.create_publisher(Odometry, "odom", SURE)
        self.node.create_subscription(TwistStamped, "cmd_vel", self._came, SURE)
        self.arrived = 0.0

    def _came(self, _message: TwistStamped) -> None:
        self.arrived = time.monotonic()

    def latency(self) -> float:
        """Time from sending odometry to the next command [s]; infinite if none comes in time."""
        message = Odometry(child_frame_id="base_link")
        message.header.frame_id, message.pose.pose.orientation.w = "odom", 1.0
        message.header.stamp = self.node.get_clock().now().to_msg()
        sent, self.arrived = time.monotonic(), 0.0
        self.odometry.publish(message)
        while not self.arrived and time.monotonic() - sent < PATIENCE:
            rclpy.spin_once(self.node, timeout_sec=0.002)
        return self.arrived - sent if self.arrived else float("inf")

    def measure(self, count: int) -> np.ndarray:
        """Latencies [s] on a grid of periods."""
        found, following = [], time.monotonic()
        for _ in range(count):
            found.append(self.latency())
            late = time.monotonic() - following
            following += PERIOD * max(1, math.ceil(late / PERIOD))
            while time.monotonic() < following:  # what comes late is no answer to the next
                left = following - time.monotonic()
                rclpy.spin_once(self.node, timeout_sec=max(0.0, left))
        return np.array(found)


@contextmanager
def running(commands: list[list[str]], fifo: bool) -> Iterator[None]:
    """Start processes; with ``fifo`` they and this one run under SCHED_FIFO."""
    first = ["chrt", "-f", str(FIFO)] if fifo else []
    processes = [
        subprocess.Popen([*first, *words], stderr=subprocess.DEVNULL) for words in commands
    ]
    if fifo:  # the threads of DDS, which come with the node, inherit it
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(FIFO + 1))
    try:
        yield
    finally:
        _ordinary()
        for process in processes:
            process.send_signal(signal.SIGINT)
        for process in processes:
            process.wait(60)


def _ordinary() -> None:
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


@contextmanager
def loaded(busy: int) -> Iterator[None]:
    """Start busy loops, never under SCHED_FIFO, which would block the whole machine."""
    loop = [sys.executable, "-c", "while True: pass"]
    loops = [subprocess.Popen(loop, preexec_fn=_ordinary) for _ in range(busy)]
    try:
        yield
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()


def chains(scenario: Path, program: str) -> Iterator[tuple[str, list[list[str]]]]:
    """Names of chains of nodes, and their processes."""
    python = [sys.executable, "-m", "wmr_ctrl.ros2"]
    given = ["--ros-args", "-p", f"scenario:={scenario}"]
    drive = [*python, "drive", *given, "-p", "law:=kanayama", "-p", "odometry_timeout:=0.5"]
    to_filter = ["-r", "cmd_vel:=cmd_vel_in"]
    yield "drive", [drive]
    own = [*python, "filter", *given, "-p", "trigger:=command"]
    yield "drive, filter in Python", [[*drive, *to_filter], own]
    if program:
        yield "drive, filter in C", [[*drive, *to_filter], [program]]


def row(name: str, how: str, found: np.ndarray) -> str:
    """A row of the table [ms]."""
    came = found[np.isfinite(found)] * 1e3
    shown = [*np.percentile(came, [50, 99, 99.9]), came.max()]
    lost = len(found) - len(came)
    return f"| {name} | {how} | {' | '.join(f'{value:.2f}' for value in shown)} | {lost} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--node", default="", metavar="PROGRAM", help="the filter in C, compiled")
    parser.add_argument("--samples", type=int, default=SAMPLES)
    given = parser.parse_args()
    rclpy.init()
    print(f"{os.cpu_count()} processors, load {os.getloadavg()[0]:.1f} before", flush=True)
    print(
        "| chain | how | p50 | p99 | p99.9 | max [ms] | unanswered |\n|---|---|---|---|---|---|---|"
    )
    with tempfile.TemporaryDirectory() as folder:
        scenario = Path(folder) / "base.toml"
        scenario.write_text(SCENARIO, encoding="utf-8")
        for name, commands in chains(scenario, given.node):
            for fifo in (False, True):
                for busy in (0, BUSY):
                    with running(commands, fifo):
                        base = Base()
                        base.measure(300)  # discovery; three messages that agree
                        with loaded(busy):
                            found = base.measure(given.samples)
                        base.node.destroy_node()
                    how = f"{'FIFO' if fifo else 'ordinary'}, load {os.getloadavg()[0]:.0f}"
                    print(
                        row(name, f"{how}, {busy} busy loops" if busy else how, found), flush=True
                    )


if __name__ == "__main__":
    main()
