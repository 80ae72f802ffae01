"""Nodes of a launch file for nav2 over DDS: ours as it is launched, the others by stand-ins.

``python stand_ins.py SCENARIO LAUNCH PARAMS``: substitutes arguments, starts wmr_filter with its
parameters and remappings, plays controller, smoother, monitor, lifecycle manager and base, and
prints what the base was sent as JSON.
"""

import sys
import time
import xml.etree.ElementTree as ElementTree

import rclpy
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from outside import LATEST, PATIENCE, RATE, SOON, SURE, has_changed, launch, spin_for, tell

WISH = 5.0
"""Speed that the controller asks for [m/s]."""


def filled(text, arguments):
    """A value with the launch file's arguments in it."""
    for name, value in arguments.items():
        text = text.replace(f"$(var {name})", value)
    return text


def main(scenario, file, params):
    root = ElementTree.parse(file).getroot()
    arguments = {item.get("name"): item.get("default", "") for item in root.iter("arg")}
    arguments |= {
        "scenario": scenario,
        "params": params,
        "cmd_vel": "base_cmd",
        "odom": "base_odom",
    }
    nodes = {item.get("name"): item for item in root.iter("node")}
    remaps = {
        name: {r.get("from"): filled(r.get("to"), arguments) for r in item.iter("remap")}
        for name, item in nodes.items()
    }
    values = {
        name: {p.get("name"): filled(p.get("value"), arguments)
               for p in item.iter("param") if p.get("name")}
        for name, item in nodes.items()
    }  # fmt: skip

    own = [f"{key}:={value or chr(39) * 2}" for key, value in values["wmr_filter"].items()]
    ours = [":=".join(pair) for pair in remaps["wmr_filter"].items()]
    words = [part for item in (*own, SOON) for part in ("-p", item)]
    process = launch("filter", remaps=ours, more=["--params-file", params, *words])

    rclpy.init()
    node, sent = rclpy.create_node("stand_ins"), []
    smoother, monitor = remaps["velocity_smoother"], values["collision_monitor"]
    wishes = node.create_publisher(TwistStamped, remaps["controller_server"]["cmd_vel"], SURE)
    smoothed = node.create_publisher(TwistStamped, "cmd_vel_smoothed", SURE)
    node.create_subscription(TwistStamped, smoother["cmd_vel"], smoothed.publish, SURE)
    watched = node.create_publisher(TwistStamped, monitor["cmd_vel_out_topic"], SURE)
    node.create_subscription(TwistStamped, monitor["cmd_vel_in_topic"], watched.publish, SURE)
    odometry = node.create_publisher(Odometry, arguments["odom"], LATEST)
    node.create_subscription(
        TwistStamped, arguments["cmd_vel"], lambda m: sent.append(m.twist.linear.x), SURE
    )
    managed = "wmr_filter" in values["lifecycle_manager_navigation"]["node_names"]
    try:
        for transition in (1, 3) if managed else ():
            assert has_changed(node, "wmr_filter", transition), transition
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end and len([v for v in sent if v > 0.8]) < 20:
            wish, seen = TwistStamped(), Odometry(child_frame_id="base_footprint")
            wish.header.stamp = seen.header.stamp = node.get_clock().now().to_msg()
            wish.twist.linear.x, seen.pose.pose.orientation.w = WISH, 1.0
            seen.twist.twist.linear.x = sent[-1] if sent else 0.0
            wishes.publish(wish)
            odometry.publish(seen)
            spin_for(node, RATE)
    finally:
        process.kill()
    tell({"nodes": sorted(nodes), "largest": max(sent, default=0.0), "commands": len(sent)})


if __name__ == "__main__":
    main(*sys.argv[1:])
