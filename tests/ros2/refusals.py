"""Nodes that cannot be configured; run by a Python that has rclpy.

``python refusals.py SCENARIO CASES`` runs the nodes of CASES (JSON: rows of a node and its words;
{} in one is the scenario) one after the other in this process, as their command does, and prints
the exit code of each and what it wrote, as JSON.
"""

import json
import os
import signal
import sys
import tempfile
from pathlib import Path

from wmr_ctrl.ros2.drive_node import DriveNode
from wmr_ctrl.ros2.filter_node import FilterNode
from wmr_ctrl.ros2.spin import spin

NODES = {"filter": FilterNode, "drive": DriveNode}
PATIENCE = 120
"""Time [s] after which a node is interrupted that should not have started."""


def refusal(node, words):
    """Exit code of a node, and the text that it, ROS and their C code wrote to stderr."""
    with tempfile.TemporaryFile() as written:
        before = os.dup(2)
        os.dup2(written.fileno(), 2)
        signal.alarm(PATIENCE)
        try:
            code = spin(NODES[node], ["--ros-args", *words])
        finally:
            signal.alarm(0)
            os.dup2(before, 2)
            os.close(before)
        written.seek(0)
        return code, written.read().decode()


def interrupt(_number, _frame):
    raise KeyboardInterrupt


def main(scenario, cases):
    signal.signal(signal.SIGALRM, interrupt)
    given = json.loads(Path(cases).read_text("utf-8"))
    found = [refusal(node, [word.format(scenario) for word in words]) for node, words in given]
    print(json.dumps(found))


if __name__ == "__main__":
    main(*sys.argv[1:])
