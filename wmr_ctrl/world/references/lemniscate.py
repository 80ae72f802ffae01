"""Figure of eight, the lemniscate of Gerono: x_d = a sin wt, y_d = a sin wt cos wt.

Its direction swings by 135 degrees to either side of -Y, so that the angle from -Y, an atan2 that
never meets its branch cut, gives a continuous theta_d.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from wmr_ctrl.fields.section import quantity
from wmr_ctrl.signals import Signal
from wmr_ctrl.symbolic import ca
from wmr_ctrl.world.references.kind import Numbers, Reference, ReferenceKind, speeds, timed

SIZE = Signal("ref_size", "m", "half the width of the desired figure of eight")
RATE = Signal("ref_rate", "rad/s", "rate of the phase along the figure of eight")


class Lemniscate(Reference):
    """Figure of eight (of Gerono): x = a sin wt, y = a sin wt cos wt."""

    size: float = quantity(2.0, unit="m", doc="half the width; the height equals it", minimum=1e-6)
    rate: float = quantity(
        0.1, unit="rad/s", doc="rate of the phase; one lap is 2 pi/rate", minimum=1e-6
    )

    @property
    def cycle(self) -> float:
        """Time of one lap, s."""
        return 2 * math.pi / self.rate


def numbers(reference: Lemniscate) -> Numbers:
    """Return size [m] and rate [rad/s]."""
    return ((SIZE, (reference.size,)), (RATE, (reference.rate,)))


def trajectory(t: ca.SX, p: Mapping[str, ca.SX]) -> ca.SX:
    """Return the reference (7, 1) at time ``t`` [s], in the order of ``signals.REFERENCE``."""
    size, rate = p[SIZE.name], p[RATE.name]
    phase = rate * t
    sin1, cos1 = ca.sin(phase), ca.cos(phase)
    sin2, cos2 = ca.sin(2 * phase), ca.cos(2 * phase)
    velocity = size * rate * ca.vertcat(cos1, cos2)
    acceleration = -size * rate**2 * ca.vertcat(sin1, 2 * sin2)
    jerk = -size * rate**3 * ca.vertcat(cos1, 4 * cos2)
    theta = ca.atan2(cos1, -cos2) - ca.pi
    position = size * ca.vertcat(sin1, sin2 / 2)
    return ca.vertcat(position, theta, speeds(velocity, acceleration, jerk))


KIND = ReferenceKind("lemniscate", Lemniscate, numbers, timed(trajectory))
