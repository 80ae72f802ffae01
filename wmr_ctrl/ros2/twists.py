"""Commands as messages of geometry_msgs: stamped, or not."""

from __future__ import annotations

from geometry_msgs.msg import Twist, TwistStamped
from rclpy.node import Node


def command_kind(stamped: bool) -> type[TwistStamped] | type[Twist]:
    """The message's class."""
    return TwistStamped if stamped else Twist


def twist_message(
    node: Node, frame: str, stamped: bool, command: tuple[float, float]
) -> TwistStamped | Twist:
    """Velocities [m/s, rad/s] of the frame, stamped with the node's time."""
    message = command_kind(stamped)()
    twist = message.twist if stamped else message
    twist.linear.x, twist.angular.z = command
    if stamped:
        message.header.stamp = node.get_clock().now().to_msg()
        message.header.frame_id = frame
    return message
