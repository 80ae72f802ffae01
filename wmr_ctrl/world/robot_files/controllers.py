"""Parameters of ros2_control's `diff_drive_controller`, and of its ancestor in ROS 1.

Source: ros2_controllers, diff_drive_controller_parameter.yaml.
"""

from collections.abc import Iterator

from . import found as our
from .found import Found, Rank, Table, read_table
from .parameter_files import Flat

TABLE = {
    our.SEPARATION: ("wheel_separation", "wheels.separation"),
    our.SEPARATION_FACTOR: ("wheel_separation_multiplier",),
    our.RADIUS: ("wheel_radius", "wheels.radius"),
    our.RADIUS_FACTOR: (
        *("wheel_radius_multiplier", "left_wheel_radius_multiplier"),
        "right_wheel_radius_multiplier",
    ),
    "base.timeout": ("cmd_vel_timeout",),
    our.PERIOD: ("publish_rate",),
    our.BASE_FRAME: ("base_frame_id",),
    our.ODOMETRY_FRAME: ("odom_frame_id",),
    our.STAMPED: ("use_stamped_vel", "enable_stamped_cmd_vel"),
}
AXES: dict[str, Table] = {
    "velocity": {our.V: ("max_velocity", "min_velocity")},
    "acceleration": {
        our.UP: ("max_acceleration", "max_acceleration_reverse"),
        our.DOWN: ("min_acceleration", "max_deceleration", "max_deceleration_reverse"),
    },
}
"""Limits of an axis, which ``has_..._limits`` may switch off."""
SIGNS = (*TABLE[our.SEPARATION], *TABLE[our.SEPARATION_FACTOR], *TABLE[our.RADIUS])


def is_controller(params: Flat) -> bool:
    """True for the parameters of a differential drive."""
    return any(sign in params for sign in SIGNS)


def read(node: str, params: Flat, file: str) -> Iterator[Found]:
    """Sizes, limits, ramps, time-out, period, frames and topics of one controller."""
    where, rank = f"{file}: {node}.", Rank.CONTROLLER
    yield from read_table(params, TABLE, where, rank)
    for axis, name in enumerate(("linear.x", "angular.z"), start=1):
        for kind, table in AXES.items():
            if params.get(f"{name}.has_{kind}_limits") is not False:
                own = {
                    key.replace("[1]", f"[{axis}]"): [f"{name}.{end}" for end in ends]
                    for key, ends in table.items()
                }
                yield from read_table(params, own, where, rank)
    if "left_wheel_names" in params:  # its topics are below its name
        plain = "_unstamped" if params.get("use_stamped_vel") is False else ""
        for key, topic in ((our.COMMANDS, f"cmd_vel{plain}"), (our.ODOMETRY, "odom")):
            yield Found(key, f"/{node}/{topic}", f"{where}~/{topic}", rank)
