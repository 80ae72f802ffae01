"""The filter configured with one scenario, cleaned up, and configured with another.

``python reconfigured.py SCENARIO`` prints what was seen as JSON; run by a Python that has rclpy.
"""

import subprocess
import sys
from pathlib import Path

import rclpy
from geometry_msgs.msg import TwistStamped
from lifecycle_msgs.srv import ChangeState
from outside import AT_ONCE, PATIENCE, World, tell
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter

CONFIGURE, CLEAN_UP, ACTIVATE, DEACTIVATE = 1, 2, 3, 4


def called(world, kind, name, request):
    client = world.node.create_client(kind, f"wmr_filter/{name}")
    assert client.wait_for_service(PATIENCE)
    future = client.call_async(request)
    rclpy.spin_until_future_complete(world.node, future, timeout_sec=PATIENCE)
    return future.result()


def change(world, *transitions):
    for transition in transitions:
        request = ChangeState.Request()
        request.transition.id = transition
        assert called(world, ChangeState, "change_state", request).success, transition


def has_set(world, name, value):
    wanted = SetParameters.Request(parameters=[Parameter(name, value=value).to_parameter_msg()])
    return bool(called(world, SetParameters, "set_parameters", wanted).results[0].successful)


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
    words = ["-p", f"scenario:={scenario}", "-p", "odometry:=none", "-p", "autostart:=false"]
    process = subprocess.Popen(
        [sys.executable, "-m", "wmr_ctrl.ros2", "filter", "--ros-args", *words, *AT_ONCE]
    )
    rclpy.init()
    world, found = World(process), {}
    try:
        change(world, CONFIGURE, ACTIVATE)
        found["first"] = largest(world, 5.0)
        found["changed while active"] = has_set(world, "scenario", str(slower))

        def sideways():
            message = TwistStamped()
            message.header.stamp = world.node.get_clock().now().to_msg()
            message.twist.linear.x, message.twist.linear.y = 0.2, 0.3
            world.commands.publish(message)

        world.said.clear()
        world.go(PATIENCE, command=sideways, until=lambda: world.told("other-parts"))
        found["other parts"] = sorted({t for t in world.said if "other-parts" in t})
        change(world, DEACTIVATE, CLEAN_UP)
        found["changed after cleanup"] = has_set(world, "scenario", str(slower))
        change(world, CONFIGURE, ACTIVATE)
        found["second"] = largest(world, 5.0)
    finally:
        process.kill()
    tell(found)


if __name__ == "__main__":
    main(*sys.argv[1:])
