"""Parameters of nav2: velocity smoother, path-following controllers, costmaps.

Source: Nav2 documentation, Configuration Guide.
"""

import math
from collections.abc import Iterator

from wmr_ctrl.core.errors import ScenarioError, show
from wmr_ctrl.core.fields.yaml_text import yaml_document

from .found import NAMED, Found, Rank, number, read_table, rounded
from .parameter_files import Flat

VECTORS = ("max_velocity", "min_velocity", "max_accel", "max_decel")
"""Parameters of the smoother that must have x, y and theta."""


def reads(node: str) -> bool:
    """True for a nav2 node whose parameters describe the robot."""
    last = node.rpartition("/")[2]
    return last in ("velocity_smoother", "controller_server") or last.endswith("costmap")


def read(node: str, params: Flat, file: str) -> Iterator[Found]:
    """Limits, ramps, period, size, frames and topics of one node."""
    where, last = f"{file}: {node}.", node.rpartition("/")[2]
    if last == "velocity_smoother":
        for name in filter(params.__contains__, VECTORS):
            given = params[name]
            if not isinstance(given, list) or len(given) != 3:
                raise ScenarioError(
                    f"{where}{name} = {show(given)} must be three numbers: x, y, theta."
                )
        yield from read_table(params, NAMED["smoother"], where, Rank.SMOOTHER)
        return
    if last == "controller_server":
        yield from read_table(params, NAMED["server"], where, Rank.PLANNER)
        for plugin in (name.removesuffix("plugin") for name in params if name.endswith(".plugin")):
            own = {name.removeprefix(plugin): value for name, value in params.items()}
            yield from read_table(own, NAMED["planner"], f"{where}{plugin}", Rank.PLANNER)
        return
    corners = params.get("footprint")
    if isinstance(corners, str) and corners.strip(" []"):
        place = f"{where}footprint"
        radius = _radius(yaml_document(corners, place), place)
        yield Found("body.radius", radius, f"{place}: farthest corner", Rank.PLANNER)
    yield from read_table(
        params, NAMED["local" if "local" in last else "costmap"], where, Rank.PLANNER
    )


def _radius(corners: object, place: str) -> float:
    """Distance [m] of the farthest corner from the base's frame."""
    sizes = []
    for corner in corners if isinstance(corners, list) else [corners]:
        if not isinstance(corner, list) or len(corner) != 2:
            raise ScenarioError(f"{place}: {show(corner)} is no point [x, y] in m.")
        sizes.append(math.hypot(*(number(item, place) or 0.0 for item in corner)))
    return rounded(max(sizes))
