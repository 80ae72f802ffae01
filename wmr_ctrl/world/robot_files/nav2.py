"""Parameters of nav2: velocity smoother, path-following controllers, costmaps.

Source: Nav2 documentation, Configuration Guide.
"""

import math
from collections.abc import Iterator

from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.problems import show
from wmr_ctrl.core.fields.yaml_text import yaml_document

from . import found as our
from .found import Found, Rank, number, read_table, rounded
from .parameter_files import Flat

FRAMES = {our.BASE_FRAME: ("robot_base_frame",), our.ODOMETRY: ("odom_topic",)}
SMOOTHER = FRAMES | {
    our.V: ("max_velocity[1]", "min_velocity[1]"),
    our.OMEGA: ("max_velocity[3]", "min_velocity[3]"),
    our.UP: ("max_accel[1]",),
    our.TURN_UP: ("max_accel[3]",),
    our.DOWN: ("max_decel[1]",),
    our.TURN_DOWN: ("max_decel[3]",),
    our.PERIOD: ("smoothing_frequency",),
}
PLANNER = {
    our.V: ("max_vel_x", "min_vel_x", "desired_linear_vel", "vx_max", "vx_min", "v_linear_max"),
    our.OMEGA: ("max_vel_theta", "rotate_to_heading_angular_vel", "wz_max", "v_angular_max"),
    our.UP: ("acc_lim_x", "ax_max"),
    our.TURN_UP: ("acc_lim_theta", "az_max"),
    our.DOWN: ("decel_lim_x", "ax_min"),
    our.TURN_DOWN: ("decel_lim_theta",),
}
"""Names of DWB, of regulated pure pursuit, of MPPI and of the graceful controller."""
SERVER = FRAMES | {our.PERIOD: ("controller_frequency",)}
COSTMAP = FRAMES | {"body.radius": ("robot_radius",)}
LOCAL = COSTMAP | {our.ODOMETRY_FRAME: ("global_frame",)}


def reads(node: str) -> bool:
    """True for a node of nav2 that says something on the robot."""
    last = node.rpartition("/")[2]
    return last in ("velocity_smoother", "controller_server") or last.endswith("costmap")


def read(node: str, params: Flat, file: str) -> Iterator[Found]:
    """Limits, ramps, period, size, frames and topics of one node."""
    where, last = f"{file}: {node}.", node.rpartition("/")[2]
    if last == "velocity_smoother":
        yield from read_table(params, SMOOTHER, where, Rank.SMOOTHER)
        return
    if last == "controller_server":
        yield from read_table(params, SERVER, where, Rank.PLANNER)
        for plugin in (name.removesuffix("plugin") for name in params if name.endswith(".plugin")):
            own = {name.removeprefix(plugin): value for name, value in params.items()}
            yield from read_table(own, PLANNER, f"{where}{plugin}", Rank.PLANNER)
        return
    corners = params.get("footprint")
    if isinstance(corners, str) and corners.strip(" []"):
        place = f"{where}footprint"
        radius = _radius(yaml_document(corners, place), place)
        yield Found("body.radius", radius, f"{place}: farthest corner", Rank.PLANNER)
    yield from read_table(params, LOCAL if "local" in last else COSTMAP, where, Rank.PLANNER)


def _radius(corners: object, place: str) -> float:
    """Distance [m] of the farthest corner from the base's frame."""
    sizes = []
    for corner in corners if isinstance(corners, list) else [corners]:
        if not isinstance(corner, list) or len(corner) != 2:
            raise ScenarioError(f"{place}: {show(corner)} is no point [x, y] in m.")
        sizes.append(math.hypot(*(number(item, place) or 0.0 for item in corner)))
    return rounded(max(sizes))
