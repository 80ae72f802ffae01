"""Faults around the filter node, from outside over DDS; run by a Python that has rclpy.

``python filter_faults.py SCENARIO [NODE]`` starts the node (in Python, or the program NODE),
simulates base and planner, and causes one fault after the other.  It prints as JSON for each fault
when the command began to fall and when it was zero [s after the fault], the longest silence of the
node, the last command, and the diagnostics.  A fault during which this process itself was late is
repeated.
"""

import sys
from functools import partial

import rclpy
from geometry_msgs.msg import TwistStamped
from outside import LATEST, World, faults, out_of_order, start, tell

OF_COMMANDS = ("missing", "NaN", "infinite", "old", "ahead", "repeated", "in map")
OF_ODOMETRY = ("missing", "NaN", "no rotation", "of a laser", "old", "repeated")


def of_commands(world):
    """Reactions of the filter, by fault of commands."""
    known, order = faults(), partial(world.command, change=out_of_order(0.1))
    found = {
        name: world.fault(
            world.rested("no-command"), command=partial(world.command, change=known[name])
        )
        for name in OF_COMMANDS
    }
    found["wild"] = world.fault(command=lambda: world.command(5.0, 3.0))
    found["out of order"] = world.fault(command=order)
    sure, world.commands = (
        world.commands,
        world.node.create_publisher(TwistStamped, "cmd_vel_in", LATEST),
    )
    found["best effort"] = world.fault()
    world.node.destroy_publisher(world.commands)
    world.commands = sure
    return found


def of_odometry(world):
    """Faults of the base's odometry."""
    known = faults()
    found = {
        name: world.fault(world.rested("no-odometry"), spoil=known[name]) for name in OF_ODOMETRY
    }
    return found | {"out of order": world.out_of_order()}


def main(scenario, node=""):
    process = start(scenario, node)
    rclpy.init()
    world, found = World(process), {}
    try:
        found["sound"] = world.fault()
        found |= {"command": of_commands(world), "odometry": of_odometry(world)}
        found |= world.latched()
        found |= world.stopped()
        found["interrupt"] = world.interrupted()
    finally:
        process.kill()
    tell(found)


if __name__ == "__main__":
    main(*sys.argv[1:])
