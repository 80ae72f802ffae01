"""Scans like those of three lasers, in a world of straight walls."""

import math
from dataclasses import dataclass, field

FAR = 100.0
"""Distance [m] of what no laser sees."""


@dataclass(frozen=True)
class Laser:
    """Laser: angles of its beams [rad], its ranges [m], and its value if nothing returns.

    ``pose``: x, y [m], yaw [rad] on the base.
    """

    first: float
    step: float
    beams: int
    least: float
    most: float
    silence: float
    pose: tuple = field(default=(0.0, 0.0, 0.0))

    @property
    def numbers(self):
        """Fields of a message besides its ranges."""
        return self.first, self.step, self.least, self.most

    def angles(self):
        return [self.first + k * self.step for k in range(self.beams)]

    def scan(self, distance, base=(0.0, 0.0, 0.0)):
        """Ranges at a pose of the base; ``distance(x, y, angle)``: to the nearest object [m]."""
        x, y, turn = base
        ahead, left, yaw = self.pose
        x += ahead * math.cos(turn) - left * math.sin(turn)
        y += ahead * math.sin(turn) + left * math.cos(turn)
        found = [distance(x, y, turn + yaw + angle) for angle in self.angles()]
        return [r if r <= self.most else self.silence for r in found]


def walls(*listed):
    """Distance to walls (a, b, c): points with a x + b y = c, beyond which nothing is seen."""

    def distance(x, y, angle):
        found = FAR
        for a, b, c in listed:
            closing = a * math.cos(angle) + b * math.sin(angle)
            if closing > 1e-9:
                found = min(found, max(0.0, (c - a * x - b * y) / closing))
        return found

    return distance


DEGREE = 0.01745329238474369
LDS_01 = Laser(0.0, DEGREE, 360, 0.12, 3.5, 0.0)
"""A laser of a TurtleBot3: 0 without a return."""
RPLIDAR = Laser(-3.12413907, DEGREE, 360, 0.15, 12.0, math.inf)
WIDE = Laser(-2.35619449, 0.004363323, 1081, 0.06, 25.0, math.inf)
"""A laser of 270 degrees, which does not see behind itself."""
