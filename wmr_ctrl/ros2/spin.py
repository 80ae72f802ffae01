"""A node's life as a process: started, configured, spun until it is interrupted, last zero sent."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable
from threading import Event

import rclpy
from rclpy.duration import Duration
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.signals import SignalHandlerOptions

from wmr_ctrl.errors import WmrError
from wmr_ctrl.ros2.node import Core, SafeNode

LAST_ZERO = 1.0
"""Time [s] in which whoever hears a node has to take its last zero; no longer is waited."""
TURN = 0.5
"""Longest time [s] that a node waits for something to do, and thus for its end."""


def spin(make: Callable[[], SafeNode[Core]], arguments: list[str]) -> int:
    """Run a node until it is interrupted; 0, or 2 where it cannot be configured at once.

    The first SIGINT or SIGTERM is noted, and obeyed between two callbacks: an exception raised at
    once may come up where Python drops it, in a destructor.  The second one raises
    KeyboardInterrupt, for whatever takes long; a third during the end is not heard.
    """
    asked_to_end = Event()

    def end(_number: int, _frame: object) -> None:
        if asked_to_end.is_set():
            raise KeyboardInterrupt
        asked_to_end.set()

    try:
        # ROS' own handlers end the context before a last zero can be sent.
        rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, end)
        node, code = make(), 0
    except Exception as error:  # rclpy's own for a namespace or a file of parameters have no base
        what = "" if isinstance(error, WmrError) else "ROS 2 refuses the arguments: "
        sys.stderr.write(f"error: {what}{' '.join(str(error).split())}\n")
        rclpy.try_shutdown()
        return 2
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    try:
        if node.value("autostart"):
            configured = node.trigger_configure() == TransitionCallbackReturn.SUCCESS
            code = 0 if configured else 2
            if configured and not asked_to_end.is_set():
                node.trigger_activate()
        while code == 0 and rclpy.ok() and not asked_to_end.is_set():
            executor.spin_once(timeout_sec=TURN)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)
        if node.active and rclpy.ok():
            node.trigger_deactivate()
            # What a reader has not taken yet may go with the process: the last zero is waited for.
            node.out.wait_for_all_acked(Duration(seconds=LAST_ZERO))
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown()
    return code
