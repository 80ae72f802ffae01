"""A node that is interrupted where Python drops exceptions; run by a Python that has rclpy.

``python interrupted.py SCENARIO`` runs the filter; from its first tick on a destructor is at work
when SIGINT comes.  It prints the exit code as JSON, or is killed by SIGALRM.
"""

from __future__ import annotations

import json
import os
import signal
import sys

from wmr_ctrl.ros2.filter_node import FilterNode
from wmr_ctrl.ros2.spin import spin

PATIENCE = 60
"""Time [s] after which the process is killed: a machine that is busy, and no more."""


TICKED: list[bool] = []
"""Whether the node was active, at each tick."""


class Dropped:
    """What interrupts its process when it is destroyed."""

    def __del__(self) -> None:
        os.kill(os.getpid(), signal.SIGINT)


class Interrupted(FilterNode):
    """The filter, at the end of whose tick something is destroyed."""

    def _on_tick(self) -> None:
        super()._on_tick()
        TICKED.append(self.active)
        if len(TICKED) == 1:
            Dropped()


def main(scenario: str) -> None:
    signal.alarm(PATIENCE)
    code = spin(Interrupted, ["--ros-args", "-p", f"scenario:={scenario}", "-p", "odometry:=none"])
    print(json.dumps({"code": code, "active": TICKED[:1]}))


if __name__ == "__main__":
    main(*sys.argv[1:])
