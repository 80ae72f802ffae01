"""Straight line at constant speed along (-sin heading, cos heading)."""

from __future__ import annotations

import math
from collections.abc import Mapping

from wmr_ctrl.fields.section import quantity
from wmr_ctrl.signals import Signal
from wmr_ctrl.symbolic import ca
from wmr_ctrl.world.references.kind import Numbers, Reference, ReferenceKind, timed

SPEED = Signal("ref_speed", "m/s", "speed of the desired motion")
HEADING = Signal("ref_heading", "rad", "orientation of the desired line, 0 along +Y")
ORIGIN = Signal("ref_origin", "m", "desired position at t = 0", 2)


class Line(Reference):
    """Straight line at constant speed along (-sin heading, cos heading)."""

    speed: float = quantity(0.2, unit="m/s", doc="speed")
    heading: float = quantity(-math.pi / 2, unit="rad", doc="orientation; -pi/2 is along +X")
    origin: tuple[float, float] = quantity((0.0, 0.0), unit="m", doc="x, y at t = 0")

    @property
    def cycle(self) -> float:
        """Period of the velocities, s: they are constant."""
        return math.inf


def numbers(reference: Line) -> Numbers:
    """Return speed [m/s], heading [rad] and origin [m]."""
    return (
        (SPEED, (reference.speed,)),
        (HEADING, (reference.heading,)),
        (ORIGIN, reference.origin),
    )


def trajectory(t: ca.SX, p: Mapping[str, ca.SX]) -> ca.SX:
    """Return the reference (7, 1) at time ``t`` [s], in the order of ``signals.REFERENCE``."""
    speed, heading, origin = p[SPEED.name], p[HEADING.name], p[ORIGIN.name]
    x = origin[0] - ca.sin(heading) * speed * t
    y = origin[1] + ca.cos(heading) * speed * t
    return ca.vertcat(x, y, heading, speed, 0, 0, 0)


KIND = ReferenceKind("line", Line, numbers, timed(trajectory))
