"""Faults of process, graph and time around the filter, from outside over DDS.

``python filter_live.py SCENARIO [NODE]`` runs the node (in Python, or the program NODE, which has
no parameters) in a namespace with remapped topics: frozen, killed and started again, with two
senders, with parameters set and another scenario; then on simulated time that stops, goes back and
leaps ahead.  The results are printed as JSON.
"""

import sys
import time
from functools import partial
from pathlib import Path

import rclpy
from geometry_msgs.msg import TwistStamped
from outside import (
    ACTIVATE,
    CLEAN_UP,
    CONFIGURE,
    DEACTIVATE,
    KEPT,
    PATIENCE,
    SURE,
    World,
    command_of,
    has_changed,
    has_set,
    silence,
    start,
    tell,
)

SPACE = ["-r", "__ns:=/robot1", "-r", "cmd_vel:=/base/cmd_vel", "-r", "odom:=/base/odom"]


def to_rest(world, **how):
    """Speeds until the base is at rest, and the longest silence."""
    world.seen.clear()
    world.go(PATIENCE, lambda: bool(world.seen) and not any(world.seen[-1][1:]), **how)
    return {
        "speeds": [v for _, v, _ in world.seen], "silence": silence([t for t, *_ in world.seen])
    }  # fmt: skip


def scaled(world):
    """Effect of a parameter that is set while the base drives."""
    scale = partial(has_set, world.node, "wmr_filter", "speed_scale")
    found = {f"scale {value:g}": scale(value) for value in (7.0, 0.25)}
    world.go(PATIENCE, lambda: world.speed[0] == 0.125)
    found["scaled"] = world.speed[0]
    scale(1.0)
    return found


def reconfigured(world, scenario):
    """Largest speed after cleanup and configuration with another scenario, half as fast."""
    slower = Path(scenario).with_name("slower.toml")
    text = Path(scenario).read_text("utf-8")
    slower.write_text(text.replace("[1.0, 2.0]", "[0.5, 1.0]").replace("[0.7, 1.4]", "[0.4, 0.8]"))
    changed = partial(has_changed, world.node, "wmr_filter")
    assert changed(DEACTIVATE)
    assert changed(CLEAN_UP)
    assert has_set(world.node, "wmr_filter", "scenario", str(slower))
    world.seen.clear()
    assert changed(CONFIGURE)
    assert changed(ACTIVATE)
    world.go(3.0, command=lambda: world.command(5.0, 0.0))
    return {"slower": max(row[1] for row in world.seen)}


def in_a_namespace(scenario, node):
    again = partial(start, scenario, node, *SPACE, odometry="none")
    world, found = World(again()), {}
    publish, hear = world.node.create_publisher, world.node.create_subscription
    try:
        world.drive()
        rival = publish(TwistStamped, "/base/cmd_vel", SURE)
        began = time.monotonic()
        found["rival"] = world.until_said("other publishers")
        times = began, *(row[0] for row in world.seen if row[0] > began), time.monotonic()
        found |= {"rival after": times[-1] - began, "silence": silence(times)}
        world.node.destroy_publisher(rival)
        found["well"] = world.until_said("driving")
        deaf = hear(TwistStamped, "/base/cmd_vel", print, KEPT)
        found["deaf"] = world.until_said("reaches it")
        world.node.destroy_subscription(deaf)

        def sideways():
            message = command_of(world.stamp(), 0.2, 0.0)
            message.twist.linear.y = 0.3
            world.commands.publish(message)

        found["other parts"] = world.until_said("other-parts", command=sideways)
        second = publish(TwistStamped, "cmd_vel_in", SURE)
        found["two senders"] = world.until_said("twist_mux")
        world.node.destroy_publisher(second)
        found |= {} if node else scaled(world)
        world.drive()
        found["while frozen"] = world.frozen(command=False)
        found["thawed"] = to_rest(world, command=False)["speeds"]
        world.drive()
        found |= world.killed(again, command=False)
        world.drive()
        found |= {} if node else reconfigured(world, scenario)
    finally:
        world.process.kill()
        world.node.destroy_node()
    return found


def on_simulated_time(scenario, node):
    simulated = ["-p", "use_sim_time:=true", *SPACE]
    world = World(start(scenario, node, *simulated, odometry="none"), simulated=True)
    try:
        world.drive()
        world.rate = 0.0
        found = {"stopped": to_rest(world)}
        world.rate = 1.0
        for name, leap in (("back", -10_000_000_000), ("ahead", 10_000_000_000)):
            world.drive()
            world.time += leap
            world.go(1.0)
            world.drive()
            found[name] = world.speed[0] == 0.5
        found["interrupt"] = world.interrupted()
    finally:
        world.process.kill()
    return found


def main(scenario, node=""):
    rclpy.init(args=["--ros-args", *SPACE])
    space, simulated = in_a_namespace(scenario, node), on_simulated_time(scenario, node)
    tell({"space": space, "simulated": simulated})


if __name__ == "__main__":
    main(*sys.argv[1:])
