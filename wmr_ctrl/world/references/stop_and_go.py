"""The circle with a speed that rises from zero and falls to zero: v1_d = V/2 (1 - cos 2 pi t/P)."""

from __future__ import annotations

from collections.abc import Mapping

from wmr_ctrl.fields.section import quantity
from wmr_ctrl.signals import Signal
from wmr_ctrl.symbolic import ca
from wmr_ctrl.world.references.kind import Numbers, Reference, ReferenceKind, timed

RADIUS = Signal("ref_radius", "m", "radius of the desired circle")
SPEED = Signal("ref_speed", "m/s", "largest speed of the desired motion")
PERIOD = Signal("ref_period", "s", "time from one stop to the next")


class StopAndGo(Reference):
    """The circle with a speed that rises from 0 and falls to 0 again in every period."""

    radius: float = quantity(2.0, unit="m", doc="radius", minimum=1e-6)
    speed: float = quantity(0.4, unit="m/s", doc="largest speed; the mean is half of it", above=0)
    period: float = quantity(10.0, unit="s", doc="time from one stop to the next", minimum=1e-6)

    @property
    def cycle(self) -> float:
        """Period of the velocities, s."""
        return self.period


def numbers(reference: StopAndGo) -> Numbers:
    """Return radius [m], largest speed [m/s] and period [s]."""
    return (
        (RADIUS, (reference.radius,)),
        (SPEED, (reference.speed,)),
        (PERIOD, (reference.period,)),
    )


def trajectory(t: ca.SX, p: Mapping[str, ca.SX]) -> ca.SX:
    """Return the reference (7, 1) at time ``t`` [s], in the order of ``signals.REFERENCE``."""
    radius, mean, rate = p[RADIUS.name], p[SPEED.name] / 2, 2 * ca.pi / p[PERIOD.name]
    angle = mean * (t - ca.sin(rate * t) / rate) / radius
    v1 = mean * (1 - ca.cos(rate * t))
    v1_dot = mean * rate * ca.sin(rate * t)
    x = radius * ca.sin(angle)
    y = radius - radius * ca.cos(angle)
    return ca.vertcat(x, y, angle - ca.pi / 2, v1, v1 / radius, v1_dot, v1_dot / radius)


KIND = ReferenceKind("stop-and-go", StopAndGo, numbers, timed(trajectory))
