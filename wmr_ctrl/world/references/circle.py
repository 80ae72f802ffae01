"""Circle of Section V: x_d = R sin wt, y_d = R - R cos wt, theta_d = wt - pi/2."""

from __future__ import annotations

import math
from collections.abc import Mapping

from wmr_ctrl.fields.section import quantity
from wmr_ctrl.signals import Signal
from wmr_ctrl.symbolic import ca
from wmr_ctrl.world.references.kind import Numbers, Reference, ReferenceKind, timed

RADIUS = Signal("ref_radius", "m", "radius of the desired circle")
RATE = Signal("ref_rate", "rad/s", "angular rate of the desired motion")


class Circle(Reference):
    """Circle through the origin, as in Section V: x = R sin wt, y = R - R cos wt."""

    radius: float = quantity(2.0, unit="m", doc="radius", minimum=1e-6)
    rate: float = quantity(0.1, unit="rad/s", doc="angular rate; negative: driven backwards")

    @property
    def cycle(self) -> float:
        """Period of the velocities, s: they are constant."""
        return math.inf


def numbers(reference: Circle) -> Numbers:
    """Return radius [m] and rate [rad/s]."""
    return ((RADIUS, (reference.radius,)), (RATE, (reference.rate,)))


def trajectory(t: ca.SX, p: Mapping[str, ca.SX]) -> ca.SX:
    """Return the reference (7, 1) at time ``t`` [s], in the order of ``signals.REFERENCE``."""
    radius, rate = p[RADIUS.name], p[RATE.name]
    angle = rate * t
    return ca.vertcat(
        radius * ca.sin(angle),
        radius - radius * ca.cos(angle),
        angle - ca.pi / 2,
        radius * rate,
        rate,
        0,
        0,
    )


KIND = ReferenceKind("circle", Circle, numbers, timed(trajectory))
