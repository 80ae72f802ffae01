"""Faults around the drive on a base that takes wheel efforts, from outside over DDS.

``python effort_faults.py SCENARIO`` simulates a base with mass and dry friction, causes one fault
after the other and prints the reactions as JSON, as `drive_faults` does.  A value is the larger of
both torques, so zero means no torque at all.  Run by a Python that has rclpy.
"""

import math
import sys
import time
from functools import partial

from drive_faults import run
from outside import PATIENCE, SURE, Base, missing, start_drive
from std_msgs.msg import Float64MultiArray

MASS, INERTIA, FRICTION, RADIUS, HALF_TRACK = 50.0, 5.4, 0.08 * 50.0 * 9.81, 0.1, 0.25
"""Mass, inertia, friction, wheel radius and half track of the scenario [kg, kg m2, N, m, m]."""


class Wheels(Base):
    """A base that wheel torques push and friction slows."""

    period = 0.05

    def __init__(self, process, simulated):
        super().__init__(process, simulated)
        self.rest()
        self.node.create_subscription(Float64MultiArray, "effort_commands", self._pushed, SURE)

    def rest(self):
        self.torque = 0.0, 0.0

    def _pushed(self, message):
        left, right = message.data
        self.torque = right, left
        self.seen.append((time.monotonic(), max(abs(right), abs(left))))

    def move(self):
        super().move()
        right, left = self.torque
        v, omega = self.speed
        v += self.period * (right + left) / RADIUS / MASS
        slower = self.period * FRICTION / MASS
        v = math.copysign(max(abs(v) - slower, 0.0), v)
        omega += self.period * (right - left) * HALF_TRACK / RADIUS / INERTIA
        self.speed = v, omega

    def drives(self):
        return self.speed[0] > 0.1 and any(self.torque)

    def fell(self):
        return any(torque == 0.0 for _, torque in self.seen)


def further(scenario, base):
    """A stop, a rival, a frozen process, and a killed one."""
    found = base.stopped()
    rival = base.node.create_publisher(Float64MultiArray, "effort_commands", SURE)
    found["rival"] = base.until_said("other publishers")
    base.node.destroy_publisher(rival)
    base.go(PATIENCE, base.drives)
    found["while frozen"] = base.frozen()
    base.go(PATIENCE, lambda: len(base.seen) >= 2)
    found["thawed"] = [value for _, value in base.seen][:2]
    found["goes on"] = base.go(PATIENCE, base.drives)
    found |= base.killed(partial(start_drive, scenario), spoil=missing)
    found["drives in it"] = base.go(PATIENCE, base.drives)
    return found | {"interrupt": base.interrupted()}


if __name__ == "__main__":
    run(sys.argv[1], Wheels, partial(further, sys.argv[1]))
