"""Where the robot stands and how fast it moves at t = 0."""

from __future__ import annotations

import math

from wmr_ctrl.fields.section import Section, quantity

HEADING = -math.pi / 2
"""Orientation along +X in the paper's convention (0 is along +Y), rad."""


class Initial(Section, key="initial"):
    """Pose and velocity at t = 0; the velocity may lie outside the limits."""

    pose: tuple[float, float, float] = quantity(
        (-0.5, -0.5, -0.7), unit="m, m, rad", doc="x, y, theta (theta = 0 along +Y)"
    )
    velocity: tuple[float, float] = quantity((0.0, 0.0), unit="m/s, rad/s", doc="v1, omega")
