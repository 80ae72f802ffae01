"""Parameters of ros2_control's `diff_drive_controller`, and of its ancestor in ROS 1.

Source: ros2_controllers, diff_drive_controller_parameter.yaml.
"""

from collections.abc import Iterator

from .found import NAMED, Found, Rank, Table, read_table
from .parameter_files import Flat

TABLE: Table = NAMED["controller"]
AXES: dict[str, Table] = NAMED["axes"]
"""Limits of an axis, which ``has_..._limits`` may switch off."""
SIGNS = (*TABLE["separation"], *TABLE["separation factor"], "left_wheel_names")


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
        for key, topic in (("ros.cmd_vel", f"cmd_vel{plain}"), ("ros.odom", "odom")):
            yield Found(key, f"/{node}/{topic}", f"{where}~/{topic}", rank)
