"""Faults around the drive on a base that takes wheel efforts, from outside over DDS.

``python effort_faults.py SCENARIO`` plays a base with mass and dry friction, breaks one thing after
the other and prints what was seen as JSON, as `drive_faults` does: a value is the larger of both
torques, so that zero is no torque at all.  Run by a Python that has rclpy.
"""

import math
import signal
import sys
import time

import rclpy
from drive_faults import SPOILT, Broken, simulated, start
from drive_live import Base
from outside import PATIENCE, SURE, tell
from std_msgs.msg import Float64MultiArray

MASS, INERTIA, FRICTION, RADIUS, HALF_TRACK = 50.0, 5.4, 0.08 * 50.0 * 9.81, 0.1, 0.25
"""Those of the scenario [kg, kg m2, N, m, m]."""


class Wheels(Broken):
    """A base that is pushed by its wheels, and slowed by friction."""

    period = 0.05

    def __init__(self, simulated):
        super().__init__(simulated)
        self.torque = 0.0, 0.0
        self.node.create_subscription(Float64MultiArray, "effort_commands", self._pushed, SURE)

    def _pushed(self, message):
        left, right = message.data
        self.torque = right, left
        self.seen.append((time.monotonic(), max(abs(right), abs(left))))

    def move(self):
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

    def until_it_drives(self):
        return self.go(PATIENCE, self.drives)


def in_real_time(scenario):
    process, found = start(scenario), {}
    base = Wheels(simulated=False)
    try:
        found |= base.spoilt()
        found |= base.stopped(lambda: max(map(abs, base.torque)))
        rival = base.node.create_publisher(Float64MultiArray, "effort_commands", SURE)
        base.said.clear()
        found["rival"] = base.go(PATIENCE, lambda: base.told("other publishers"))
        base.node.destroy_publisher(rival)
        base.until_it_drives()
        process.send_signal(signal.SIGSTOP)
        base.torque = 0.0, 0.0  # a base's own time-out
        found["while frozen"] = base.count_after_quiet(0.6)
        base.torque = 0.0, 0.0
        process.send_signal(signal.SIGCONT)
        base.go(PATIENCE, lambda: len(base.seen) >= 2)
        found["thawed"] = [value for _, value in base.seen][:2]
        found["goes on"] = base.until_it_drives()
        process.kill()
        process.wait()
        base.torque = 0.0, 0.0
        found["after the kill"] = base.count_after_quiet(0.5)
        base.torque = 0.0, 0.0
        process = start(scenario)
        base.spoil = SPOILT["missing"]
        base.go(PATIENCE, lambda: len(base.seen) > 5)
        found["next life"] = max(value for _, value in base.seen)
        base.spoil = Base.spoil
        found["drives in it"] = base.until_it_drives()
        process.send_signal(signal.SIGINT)
        found["interrupt"] = base.ended(process)
    finally:
        process.kill()
        base.node.destroy_node()
    return found


def main(scenario):
    rclpy.init()
    tell({"real": in_real_time(scenario), "simulated": simulated(Wheels, scenario)})


if __name__ == "__main__":
    main(sys.argv[1])
