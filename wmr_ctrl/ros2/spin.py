"""A node's process: start, configure, spin until it is interrupted, send a last zero."""

from __future__ import annotations

import signal
import sys
import time
from collections.abc import Callable
from contextlib import suppress

import rclpy
from rclpy.duration import Duration
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.signals import SignalHandlerOptions

from wmr_ctrl.core.errors import WmrError

from .node import Core, SafeNode

LAST_ZERO = 1.0
"""Time [s] in which whoever hears a node has to take its last zero; no longer is waited."""
TURN = 0.5
"""Longest time [s] that a node waits for something to do, and thus for its end."""
AT_ONCE = 1.0
"""Time [s] in which signals are one: a terminal and a launch both send them."""
SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Ending:
    """Handlers of SIGINT and SIGTERM in a node's process.

    While the node commands a base, signals are only recorded, and obeyed between two callbacks: an
    exception might be raised where Python drops it, in a destructor, and the node would continue.
    Before it commands, and after AT_ONCE, they raise KeyboardInterrupt, which ends long work.
    """

    def __init__(self) -> None:
        """Start without a request to end."""
        self.node: SafeNode[Core] | None = None
        self.asked = False
        self._first = 0.0

    def hear(self) -> None:
        """Install the handlers."""
        for number in SIGNALS:
            signal.signal(number, self._heard)

    def _heard(self, _number: int, _frame: object) -> None:
        now, before, self.asked = time.monotonic(), self.asked, True
        self._first = self._first if before else now
        patient = now - self._first < AT_ONCE if before else self.node and self.node.active
        if not patient:
            raise KeyboardInterrupt

    @staticmethod
    def ignore() -> None:
        """Ignore further signals: the node is about to end."""
        for number in SIGNALS:
            signal.signal(number, signal.SIG_IGN)


def spin(make: Callable[[], SafeNode[Core]], arguments: list[str]) -> int:
    """Run a node until it is interrupted; returns 0, or 2 if it cannot be configured first."""
    ending = Ending()
    try:
        # ROS' own handlers end the context before a last zero can be sent.
        rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
        ending.hear()
        node, code = make(), 0
    except Exception as error:  # rclpy's own for a namespace or a file of parameters have no base
        what = "" if isinstance(error, WmrError) else "ROS 2 refuses the arguments: "
        sys.stderr.write(f"error: {what}{' '.join(str(error).split())}\n")
        rclpy.try_shutdown()
        return 2
    ending.node, executor = node, SingleThreadedExecutor()
    executor.add_node(node)
    try:
        if node.value("autostart"):
            steps = (node.trigger_configure, node.trigger_activate)
            done = all(ending.asked or step() == TransitionCallbackReturn.SUCCESS for step in steps)
            code = 0 if done else 2
        while code == 0 and rclpy.ok() and not ending.asked:
            executor.spin_once(timeout_sec=TURN)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        ending.ignore()
        if node.active and rclpy.ok():
            node.rest()
            # What a reader has not taken yet may go with the process: the last zero is waited for.
            node.out.wait_for_all_acked(Duration(seconds=LAST_ZERO))
            with suppress(Exception):  # it was interrupted within another transition
                node.trigger_deactivate()
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown()
    return code
