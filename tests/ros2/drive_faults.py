"""Faults around the drive, from outside over DDS; run by a Python that has rclpy.

``python drive_faults.py SCENARIO`` simulates a base that follows its commands without delay, and
causes one fault after the other.  It prints as JSON for each fault when the command began to fall
and when it was zero [s after the fault], the diagnostics, and whether it drove again.  Then it does
the same on simulated time that stops, goes back and leaps ahead.
"""

import sys

import rclpy
from outside import PATIENCE, Base, faults, start_drive, tell


def of_odometry(base):
    """Reactions of the node, by fault of odometry."""
    known = faults()
    del known["infinite"], known["ahead"]
    found = {"well": base.until_said("driving")}
    for name, spoil in known.items():
        found[name] = base.fault(base.rested("no-odometry"), spoil=spoil)
    found["out of order"] = base.out_of_order()

    def leap():
        base.pose[0] += 1.0

    return found | {"pose leaps": leaps(base, "pose-jump", leap)}


def leaps(base, word, leap):
    """Reaction to a leap reported as ``word``, until the base has braked and drives again."""
    return base.fault(
        lambda: base.told(word) and base.fell() and base.drives(), first=leap, again=True
    )


def in_simulated_time(base):
    """Reactions to a clock that goes back, leaps ahead, and stops."""

    def to(seconds):
        base.time += round(seconds * 1e9)

    def still():
        base.rate = 0.0

    found = {
        "back": leaps(base, "time-back", lambda: to(-10.0)),
        "ahead": leaps(base, "time-forth", lambda: to(10.0)),
        "stopped": base.fault(base.rested("no-odometry"), first=still),
    }
    base.rate = 1.0
    return found | {"drives again": base.go(PATIENCE, base.drives)}


def run(scenario, kind, more):
    """Report how a base of a kind behaves in real time, with ``more``, and in simulated time."""
    rclpy.init()
    found = {}
    for name, settings in (("real", []), ("simulated", ["use_sim_time:=true"])):
        base = kind(start_drive(scenario, *settings), simulated=bool(settings))
        try:
            if settings:
                found[name] = in_simulated_time(base)
            else:
                found[name] = of_odometry(base) | more(base)
        finally:
            base.process.kill()
            base.node.destroy_node()
    tell(found)


if __name__ == "__main__":
    run(sys.argv[1], Base, lambda base: base.latched() | base.stopped())
