"""QoS of the nodes, and others on their topics: names, and those with whom nothing is exchanged."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from geometry_msgs.msg import Twist, TwistStamped
from rclpy.duration import Infinite
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import (
    DurabilityPolicy,
    QoSCompatibility,
    QoSProfile,
    ReliabilityPolicy,
    qos_check_compatible,
)
from rclpy.subscription import Subscription
from rclpy.topic_endpoint_info import TopicEndpointInfo

from .diagnosis import rivals, two_senders

EVER = {"deadline": Infinite, "liveliness_lease_duration": Infinite}
"""Durations that the graph reports of endpoints without them; left out, they pass for another."""
LATEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT, **EVER)
SURE = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, **EVER)
KEPT = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
    **EVER,
)


def useless(node: Node, out: Publisher, heard: Iterable[Subscription]) -> str:
    """Sentence on what voids a node's promise or keeps everything from it; "" where all is well.

    That is another publisher beside ``out``, or a sender of whom nothing is ``heard``.
    """
    topic = out.topic_name
    rival = rivals(node.get_fully_qualified_name(), _publishers(node, topic), topic)
    return rival or next((text for item in heard for text in _unheard(node, item)), "")


def doubtful(node: Node, out: Publisher, topics: Iterable[str]) -> str:
    """Sentence on several senders of what a node reads, or readers who do not get ``out``."""
    senders = (two_senders(_publishers(node, topic), topic) for topic in topics)
    return next(filter(None, (*senders, *_unheeding(node, out))), "")


def _publishers(node: Node, topic: str) -> list[str]:
    """Full names of the nodes that publish on a topic, as it is called after remapping."""
    return [_full_name(item) for item in node.get_publishers_info_by_topic(topic)]


def _unheard(node: Node, heard: Subscription) -> Iterator[str]:
    """Sentences on senders whose messages a subscription does not get: another type, wrong QoS."""
    for item in node.get_publishers_info_by_topic(heard.topic_name):
        problem = _problem(item, heard.msg_type, item.qos_profile, heard.qos_profile)
        if problem:
            yield f"{_full_name(item)} sends on {heard.topic_name} {problem} is heard."


def _unheeding(node: Node, out: Publisher) -> Iterator[str]:
    """Sentences on readers who do not get what a publisher sends."""
    for item in node.get_subscriptions_info_by_topic(out.topic_name):
        problem = _problem(item, out.msg_type, out.qos_profile, item.qos_profile)
        if problem:
            yield f"{_full_name(item)} reads {out.topic_name} {problem} reaches it."


def _full_name(item: TopicEndpointInfo) -> str:
    """Name of a node; who was found just now has none yet, and rmw says so in capitals."""
    if "_UNKNOWN_" in item.node_name:
        return "a node whose name is not known yet"
    return f"{item.node_namespace.rstrip('/')}/{item.node_name}"


def _problem(item: TopicEndpointInfo, own: type, sent: QoSProfile, wanted: QoSProfile) -> str:
    """The middle of a sentence that begins with a node and a topic; "" where all is well."""
    if item.topic_type != _type_name(own):
        remedy = " (stamped:=true or false says which)" if own in (Twist, TwistStamped) else ""
        return f"as {item.topic_type}, where this node has {_type_name(own)}{remedy}: nothing"
    verdict, why = qos_check_compatible(sent, wanted)
    if verdict == QoSCompatibility.ERROR:
        return f"with another QoS ({why.rstrip(';')}): nothing"
    return ""


def _type_name(message: type) -> str:
    """Name of a message's type as the graph has it."""
    package = message.__module__.partition(".")[0]
    return f"{package}/msg/{message.__name__}"
