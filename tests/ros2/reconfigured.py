"""The filter configured with one scenario, cleaned up, and configured with another.

``python reconfigured.py SCENARIO`` prints what was seen as JSON; run by a Python that has rclpy.
"""

import sys
from pathlib import Path

import rclpy
from geometry_msgs.msg import TwistStamped
from outside import PATIENCE, World, has_changed, has_set, start, tell

CONFIGURE, CLEAN_UP, ACTIVATE, DEACTIVATE = 1, 2, 3, 4


def change(world, *transitions):
    for transition in transitions:
        assert has_changed(world.node, "wmr_filter", transition), transition


def largest(world, wish):
    """Largest speed that is sent on a wish, once it no longer grows."""
    world.seen.clear()
    world.go(3.0, command=lambda: world.command(wish, 0.0))
    return max((v for _, v, _ in world.seen), default=0.0)


def main(scenario):
    slower = Path(scenario).with_name("slower.toml")
    text = Path(scenario).read_text("utf-8")
    slower.write_text(text.replace("[1.0, 2.0]", "[0.5, 1.0]").replace("[0.7, 1.4]", "[0.4, 0.8]"),
                      encoding="utf-8")  # fmt: skip
    process = start(scenario, "", "-p", "autostart:=false", odometry="none")
    rclpy.init()
    world, found = World(process), {}
    try:
        change(world, CONFIGURE, ACTIVATE)
        found["first"] = largest(world, 5.0)
        found["changed while active"] = has_set(world.node, "wmr_filter", "scenario", str(slower))

        def sideways():
            message = TwistStamped()
            message.header.stamp = world.node.get_clock().now().to_msg()
            message.twist.linear.x, message.twist.linear.y = 0.2, 0.3
            world.commands.publish(message)

        world.said.clear()
        world.go(PATIENCE, command=sideways, until=lambda: world.told("other-parts"))
        found["other parts"] = sorted({t for t in world.said if "other-parts" in t})
        change(world, DEACTIVATE, CLEAN_UP)
        found["changed after cleanup"] = has_set(world.node, "wmr_filter", "scenario", str(slower))
        change(world, CONFIGURE, ACTIVATE)
        found["second"] = largest(world, 5.0)
    finally:
        process.kill()
    tell(found)


if __name__ == "__main__":
    main(*sys.argv[1:])
