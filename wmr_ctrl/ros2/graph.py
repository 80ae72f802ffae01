"""QoS of the nodes, and other nodes on their topics: names, and incompatible ones."""

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
"""Durations that the graph reports for endpoints that state none; without them the profiles would
differ."""
LATEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT, **EVER)
SURE = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, **EVER)
KEPT = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
    **EVER,
)


def useless(node: Node, out: Publisher, heard: Iterable[Subscription]) -> str:
    """Sentence on why a node's promise is void or it receives nothing; "" if all is well.

    Causes are another publisher beside ``out``, or a sender that no subscription in ``heard``
    receives.
    """
    topic = out.topic_name
    rival = rivals(node.get_fully_qualified_name(), _publishers(node, topic), topic)
    return rival or next((text for item in heard for text in _unheard(node, item)), "")


def doubtful(node: Node, out: Publisher, topics: Iterable[str]) -> str:
    """Sentence on several senders on an input topic, or on readers that do not receive ``out``."""
    senders = (two_senders(_publishers(node, topic), topic) for topic in topics)
    return next(filter(None, (*senders, *_unheeding(node, out))), "")


def _publishers(node: Node, topic: str) -> list[str]:
    """Full names of the nodes that publish on a topic, after remapping."""
    return [_full_name(item) for item in node.get_publishers_info_by_topic(topic)]


def _unheard(node: Node, heard: Subscription) -> Iterator[str]:
    """Sentences on senders whose messages a subscription does not receive: other type or QoS."""
    for item in node.get_publishers_info_by_topic(heard.topic_name):
        problem = _problem(item, heard.msg_type, item.qos_profile, heard.qos_profile)
        if problem:
            yield f"{_full_name(item)} sends on {heard.topic_name} {problem} is heard."


def _unheeding(node: Node, out: Publisher) -> Iterator[str]:
    """Sentences on readers that do not receive a publisher's messages."""
    for item in node.get_subscriptions_info_by_topic(out.topic_name):
        problem = _problem(item, out.msg_type, out.qos_profile, item.qos_profile)
        if problem:
            yield f"{_full_name(item)} reads {out.topic_name} {problem} reaches it."


def _full_name(item: TopicEndpointInfo) -> str:
    """Name of a node; a newly discovered node has none yet, which rmw marks in capitals."""
    if "_UNKNOWN_" in item.node_name:
        return "a node whose name is not known yet"
    return f"{item.node_namespace.rstrip('/')}/{item.node_name}"


def _problem(item: TopicEndpointInfo, own: type, sent: QoSProfile, wanted: QoSProfile) -> str:
    """Sentence, without its subject, on a mismatch of type or QoS; "" if there is none."""
    if item.topic_type != _type_name(own):
        remedy = " (stamped:=true or false says which)" if own in (Twist, TwistStamped) else ""
        return f"as {item.topic_type}, where this node has {_type_name(own)}{remedy}: nothing"
    verdict, why = qos_check_compatible(sent, wanted)
    if verdict == QoSCompatibility.ERROR:
        return f"with another QoS ({why.rstrip(';')}): nothing"
    return ""


def _type_name(message: type) -> str:
    """Name of a message's type as the ROS graph spells it."""
    package = message.__module__.partition(".")[0]
    return f"{package}/msg/{message.__name__}"
