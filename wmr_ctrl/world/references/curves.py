"""References in closed form: straight line, circle of Section V, stop and go, figure of eight.

Each trajectory gives the reference (7, 1) at time ``t`` [s], in the order of `signals.REFERENCE`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from wmr_ctrl.core.fields.section import quantity
from wmr_ctrl.core.fields.unstated import derived
from wmr_ctrl.core.symbolic import ca

from .kind import Pair, Reference, ReferenceKind, driven, speeds, timed

EIGHT_TURNS = 3.2
"""Fastest turning of the figure of eight over the rate of its phase; its speed is sqrt(2) times."""


class Circle(Reference):
    """Circle through the origin, as in Section V: x = R sin wt, y = R - R cos wt.

    Omitted fields are derived: the speed is half its limit, turning at most a quarter of its own.
    """

    radius: float = quantity(derived(1.0), "m", "radius of the desired circle", minimum=1e-6)
    rate: float = quantity(
        derived(0.1), "rad/s", "angular rate of the desired motion; negative: backwards"
    )

    def sized(self, limits: Pair, accel: Pair) -> Mapping[str, float]:
        """Radius and rate of a circle that the robot can follow."""
        speed, rate = driven(limits)
        if radius := self.stated("radius"):
            rate = min(rate, speed / radius)
        return {"rate": rate, "radius": speed / abs(self.stated("rate") or rate)}


def circle(t: ca.SX, p: Mapping[str, ca.SX]) -> ca.SX:
    """x_d = R sin wt, y_d = R - R cos wt, theta_d = wt - pi/2."""
    radius, rate = p["ref_radius"], p["ref_rate"]
    angle = rate * t
    x, y = radius * ca.sin(angle), radius - radius * ca.cos(angle)
    return ca.vertcat(x, y, angle - ca.pi / 2, radius * rate, rate, 0, 0)


class Line(Reference):
    """Straight line at constant speed along (-sin heading, cos heading).

    An omitted speed is half of the limit.
    """

    speed: float = quantity(derived(0.1), "m/s", "speed of the desired motion")
    heading: float = quantity(
        -math.pi / 2, "rad", "orientation of the desired line, 0 along +Y", orientation=1
    )
    origin: tuple[float, float] = quantity((0.0, 0.0), "m", "desired position x, y at t = 0")

    def sized(self, limits: Pair, accel: Pair) -> Mapping[str, float]:
        """The speed, if it is omitted: half of its limit."""
        return {"speed": driven(limits)[0]}


def line(t: ca.SX, p: Mapping[str, ca.SX]) -> ca.SX:
    """(x_d, y_d) = origin + speed t (-sin heading, cos heading)."""
    speed, heading, origin = p["ref_speed"], p["ref_heading"], p["ref_origin"]
    x = origin[0] - ca.sin(heading) * speed * t
    y = origin[1] + ca.cos(heading) * speed * t
    return ca.vertcat(x, y, heading, speed, 0, 0, 0)


class StopAndGo(Reference):
    """The circle with a speed that rises from 0 and falls to 0 again in every period.

    Omitted fields are derived: the speed is half its limit, turning at most a quarter of its own.
    """

    radius: float = quantity(derived(1.0), "m", "radius of the desired circle", minimum=1e-6)
    speed: float = quantity(
        derived(0.1), "m/s", "largest speed of the desired motion; the mean is half of it", above=0
    )
    period: float = quantity(10.0, "s", "time from one stop to the next", minimum=1e-6)

    def sized(self, limits: Pair, accel: Pair) -> Mapping[str, float]:
        """Speed and radius of a circle that the robot can follow."""
        speed, rate = driven(limits)
        if radius := self.stated("radius"):
            speed = min(speed, rate * radius)
        return {"speed": speed, "radius": (self.stated("speed") or speed) / rate}

    @property
    def cycle(self) -> float:
        """Period of the velocities [s]."""
        return self.period


def stop_and_go(t: ca.SX, p: Mapping[str, ca.SX]) -> ca.SX:
    """v1_d = V/2 (1 - cos 2 pi t/P) on the circle."""
    radius, mean, rate = p["ref_radius"], p["ref_speed"] / 2, 2 * ca.pi / p["ref_period"]
    angle = mean * (t - ca.sin(rate * t) / rate) / radius
    v1 = mean * (1 - ca.cos(rate * t))
    v1_dot = mean * rate * ca.sin(rate * t)
    x = radius * ca.sin(angle)
    y = radius - radius * ca.cos(angle)
    return ca.vertcat(x, y, angle - ca.pi / 2, v1, v1 / radius, v1_dot, v1_dot / radius)


class Lemniscate(Reference):
    """Figure of eight (of Gerono): x = a sin wt, y = a sin wt cos wt.

    Omitted fields are derived: the speed is half its limit, turning at most a quarter of its own.
    """

    size: float = quantity(
        derived(1.0),
        "m",
        "half the width of the desired figure of eight; the height equals it",
        minimum=1e-6,
    )
    rate: float = quantity(
        derived(0.1),
        "rad/s",
        "rate of the phase along the figure of eight; one lap is 2 pi/rate",
        minimum=1e-6,
    )

    def sized(self, limits: Pair, accel: Pair) -> Mapping[str, float]:
        """Size and rate of an eight that the robot can follow."""
        speed, turning = driven(limits)
        rate, across = turning / EIGHT_TURNS, speed / math.sqrt(2)
        if size := self.stated("size"):
            rate = min(rate, across / size)
        return {"rate": rate, "size": across / (self.stated("rate") or rate)}

    @property
    def cycle(self) -> float:
        """Time of one lap [s]."""
        return 2 * math.pi / self.rate


def lemniscate(t: ca.SX, p: Mapping[str, ca.SX]) -> ca.SX:
    """x_d = a sin wt, y_d = a sin wt cos wt.

    The direction swings by 135 degrees to either side of -Y. So the angle from -Y, an atan2 that
    never meets its branch cut, gives a continuous theta_d.
    """
    size, rate = p["ref_size"], p["ref_rate"]
    phase = rate * t
    sin1, cos1 = ca.sin(phase), ca.cos(phase)
    sin2, cos2 = ca.sin(2 * phase), ca.cos(2 * phase)
    velocity = size * rate * ca.vertcat(cos1, cos2)
    acceleration = -size * rate**2 * ca.vertcat(sin1, 2 * sin2)
    jerk = -size * rate**3 * ca.vertcat(cos1, 4 * cos2)
    theta = ca.atan2(cos1, -cos2) - ca.pi
    position = size * ca.vertcat(sin1, sin2 / 2)
    return ca.vertcat(position, theta, speeds(velocity, acceleration, jerk))


CIRCLE = ReferenceKind("circle", Circle, timed(circle))
LINE = ReferenceKind("line", Line, timed(line))
STOP_AND_GO = ReferenceKind("stop-and-go", StopAndGo, timed(stop_and_go))
LEMNISCATE = ReferenceKind("lemniscate", Lemniscate, timed(lemniscate))
