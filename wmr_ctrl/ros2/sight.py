"""Limits and free distances for ``wmr_filter``: its lasers, their poses, and the meaning of
silence.
"""

import math
from dataclasses import dataclass

import numpy as np

from wmr_ctrl.control.filter.stop_numbers import leaving, smallest_window, stopping
from wmr_ctrl.control.loop import LOOK_AHEAD
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.signals import LARGEST
from wmr_ctrl.world.scenario import Scenario
from wmr_ctrl.world.sight import WIDEST

MOST = 4
"""Most lasers (`fmu/ros2/scan_core.h`)."""
SLACK = 1e-3
"""Angle [rad] by which the smallest window is wider than it must be, for roundings."""
LARGEST_SHARE = 0.99
"""Share of the radius within which a laser must be."""


@dataclass(frozen=True, kw_only=True)
class SightSettings:
    """Parameters of ``wmr_filter`` about limits and lasers, by their names in parameters.toml."""

    scans: tuple[str, ...] = ("",)
    scan_pose: tuple[float, ...] = (0.0, 0.0, 0.0)
    radius: float = 0.0
    look: float = 0.3
    no_return: str = "blind"
    ignore: tuple[float, ...] = (0.0, 0.0)
    limit_timeout: float = 0.0
    speed_limit: str = ""

    @property
    def topics(self) -> tuple[str, ...]:
        """Topics of the lasers."""
        return tuple(filter(None, self.scans))

    @property
    def poses(self) -> list[list[float]]:
        """Pose (x [m], y [m], yaw [rad]) of each laser in the frame of the base."""
        return np.reshape(self.scan_pose, (-1, 3)).tolist()

    @property
    def ignored(self) -> list[list[float]]:
        """Angles [rad], from and to, that the robot's own parts cover in a laser's frame."""
        return np.reshape(self.ignore, (-1, 2)).tolist()

    def check(self, scenario: Scenario) -> None:
        """Raise ArgumentError if these settings do not fit the scenario, or each other."""
        if (self.limit_timeout or self.speed_limit) and not scenario.filter.changing:
            raise ArgumentError(
                "limit_timeout and speed_limit are about limits that change, and this scenario's "
                "do not. Set filter.changing = true, or leave the parameters out."
            )
        if not self.topics:
            return
        if scenario.filter.free_error is None:
            raise ArgumentError(
                f"scans = {', '.join(self.topics)}: this scenario's filter asks for no distances. "
                "Set filter.free_error [m], or leave out scans."
            )
        if len(self.topics) > MOST or len(self.scan_pose) != 3 * len(self.topics):
            raise ArgumentError(
                f"scan_pose has {len(self.scan_pose)} numbers: give three (x, y, yaw) for each of "
                f"scans, of which there may be {MOST}."
            )
        outside = [
            pose for pose in self.poses if math.hypot(*pose[:2]) >= LARGEST_SHARE * self.radius
        ]
        if outside:
            raise ArgumentError(
                f"radius = {self.radius:g} m: the disc must hold the robot with its lasers, and "
                f"one is at {outside[0][:2]}."
            )
        least, _ = smallest_window(scenario)
        if not least <= self.look <= WIDEST:
            raise ArgumentError(
                f"look = {self.look:g} rad must be from {least:.3g}, through which a push turns "
                f"the base until it stands, to {WIDEST:g}: else no command to turn is ever sent."
            )
        if len(self.ignore) % 2:
            raise ArgumentError("ignore has an odd number of angles: give pairs, from and to.")


def windows(scenario: Scenario) -> dict[str, float]:
    """Windows of headings [rad], by their names in C; ``enough`` [m] is more than any stop takes.

    ``turning`` [s]: for how long a requested turn widens the window.
    """
    settings, ends = scenario.filter, [abs(end) for end in scenario.limits.sides[0]]
    enough = max(stopping(scenario, end).distance for end in ends)
    enough += (max(ends) + settings.nearing) * settings.free_age
    smallest = min(max(smallest_window(scenario)) + SLACK, WIDEST)
    return {"widest": WIDEST, "smallest": smallest, "any": LARGEST, "turning": LOOK_AHEAD,
            "enough": enough}  # fmt: skip


def remedy(scenario: Scenario) -> str:
    """Sentence on what to do if an obstacle is too near."""
    found = leaving(scenario)
    holds = found is not None and 0 < found.hold < math.inf
    return f"near: back off{f', hold it for {found.hold:.1f} s' if found and holds else ''}"
