"""Commands as messages of geometry_msgs: stamped, or not."""

from __future__ import annotations

from geometry_msgs.msg import Twist, TwistStamped
from rclpy.node import Node
from rclpy.time import Time


def command_kind(stamped: bool) -> type[TwistStamped] | type[Twist]:
    """The message class of commands."""
    return TwistStamped if stamped else Twist


OTHER_PARTS = ("linear.y", "linear.z", "angular.x", "angular.y")
"""Parts of a twist that a base with two driven wheels cannot follow."""


def other_parts(twist: Twist) -> list[str]:
    """Names of the components beside v and omega that are not 0."""
    values = twist.linear.y, twist.linear.z, twist.angular.x, twist.angular.y
    return [name for name, value in zip(OTHER_PARTS, values, strict=True) if value != 0]


def twist_message(
    node: Node, frame: str, stamped: bool, command: tuple[float, float], earliest: int = 0
) -> TwistStamped | Twist:
    """Velocities [m/s, rad/s] of the frame, stamped with the node's time.

    A message may overtake the clock of a simulator: the stamp is not before ``earliest`` [ns].
    """
    message = command_kind(stamped)()
    twist = message.twist if stamped else message
    twist.linear.x, twist.angular.z = command
    if stamped:
        now = node.get_clock().now().nanoseconds
        message.header.stamp = Time(nanoseconds=max(now, earliest)).to_msg()
        message.header.frame_id = frame
    return message
