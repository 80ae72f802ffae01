"""Faults of process, graph and time around the filter, from outside over DDS.

``python filter_live.py SCENARIO [NODE]`` runs the node (that in Python, or the program NODE, which
has no parameters) in a namespace with remapped topics: frozen, killed and started again, with two
senders, with parameters set; then on simulated time that stops, goes back and leaps ahead.  What
was seen is printed as JSON.
"""

import signal
import sys

import rclpy
from geometry_msgs.msg import TwistStamped
from outside import KEPT, PATIENCE, SURE, World, has_set, silence, start, tell
from rosgraph_msgs.msg import Clock

SPACE = ["-r", "__ns:=/robot1", "-r", "cmd_vel:=/base/cmd_vel", "-r", "odom:=/base/odom"]


class Simulated(World):
    """A world whose time is its own."""

    def __init__(self, process):
        super().__init__(process)
        self.clock = self.node.create_publisher(Clock, "/clock", SURE)
        self.time, self.rate = 100_000_000_000, 1.0

    def _stamp(self, ago):
        return rclpy.time.Time(nanoseconds=self.time - round(ago * 1e9)).to_msg()

    def command(self, v=0.5, omega=0.3, ago=0.0, frame=""):
        """The time that has passed, then a command of it."""
        self.time += round(0.02e9 * self.rate)
        self.clock.publish(Clock(clock=self._stamp(0.0)))
        super().command(v, omega, ago, frame)


def to_rest(world, **go):
    """Speeds until the base is at rest, and the longest silence."""
    world.seen.clear()
    world.go(PATIENCE, until=lambda: bool(world.seen) and world.speed == (0.0, 0.0), **go)
    times = [t for t, _, _ in world.seen]
    return {"speeds": [v for _, v, _ in world.seen], "silence": silence(times)}


def scaled(world):
    """A parameter that is set while it drives."""
    found = {
        f"scale {value:g}": has_set(world.node, "wmr_filter", "speed_scale", value)
        for value in (7.0, 0.25)
    }
    world.go(PATIENCE, until=lambda: world.speed[0] == 0.125)
    found["scaled"] = world.speed[0]
    has_set(world.node, "wmr_filter", "speed_scale", 1.0)
    return found


def in_a_namespace(scenario, node):
    world, found = World(start(scenario, node, *SPACE, odometry="none")), {}
    try:
        world.drive()
        rival = world.node.create_publisher(TwistStamped, "/base/cmd_vel", SURE)
        found["rival"] = world.go_until_said("other publishers")
        world.node.destroy_publisher(rival)
        found["well"] = world.go_until_said("driving")
        deaf = world.node.create_subscription(TwistStamped, "/base/cmd_vel", print, KEPT)
        found["deaf"] = world.go_until_said("reaches it")
        world.node.destroy_subscription(deaf)
        second = world.node.create_publisher(TwistStamped, "cmd_vel_in", SURE)
        found["two senders"] = world.go_until_said("twist_mux")
        world.node.destroy_publisher(second)
        found |= {} if node else scaled(world)
        world.drive()
        world.process.send_signal(signal.SIGSTOP)
        found["while frozen"] = world.count_after_quiet(0.6, command=False)
        world.process.send_signal(signal.SIGCONT)
        found["thawed"] = to_rest(world, command=False)["speeds"]
        world.drive()
        world.process.kill()
        world.process.wait()
        found["after the kill"] = world.count_after_quiet(0.5)
        world.seen.clear()
        world.process = start(scenario, node, *SPACE, odometry="none")
        world.go(PATIENCE, command=False, until=lambda: len(world.seen) > 10)
        found["next life"] = max(abs(v) for _, v, _ in world.seen)
        world.drive()
    finally:
        world.process.kill()
        world.node.destroy_node()
    return found


def on_simulated_time(scenario, node):
    simulated = ["-p", "use_sim_time:=true", *SPACE]
    world, found = Simulated(start(scenario, node, *simulated, odometry="none")), {}
    try:
        world.drive()
        world.rate = 0.0
        found["stopped"] = to_rest(world)
        world.rate = 1.0
        for name, leap in (("back", -10_000_000_000), ("ahead", 10_000_000_000)):
            world.drive()
            world.time += leap
            world.go(1.0)
            world.drive()
            found[name] = world.speed[0] == 0.5
        world.process.send_signal(signal.SIGINT)
        found["interrupt"] = world.ended()
    finally:
        world.process.kill()
    return found


def main(scenario, node=""):
    rclpy.init(args=["--ros-args", *SPACE])
    space, simulated = in_a_namespace(scenario, node), on_simulated_time(scenario, node)
    tell({"space": space, "simulated": simulated})


if __name__ == "__main__":
    main(*sys.argv[1:])
