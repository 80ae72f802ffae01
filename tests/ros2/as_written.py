"""Run the commands of the pages as they are written there; for a Python that has rclpy.

``python as_written.py SCENARIO ROWS``: ROWS (JSON) has "files" by name, which are written beside
SCENARIO, and "commands", the words of each after ``-m wmr_ctrl.ros2``.  For each command it prints
the first velocities received, the other senders on /cmd_vel_monitored, and the exit code after
SIGINT.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import rclpy
from outside import PATIENCE, World, missing, tell

MONITORED = "/cmd_vel_monitored"


def main(scenario, rows):
    given = json.loads(Path(rows).read_text("utf-8"))
    os.chdir(Path(scenario).parent)
    for name, text in given["files"].items():
        Path(name).write_text(text, "utf-8")
    rclpy.init()
    found = []
    for words in given["commands"]:
        process = subprocess.Popen([sys.executable, "-m", "wmr_ctrl.ros2", *words])
        world = World(process)

        def enough(world=world):
            return len(world.seen) >= 3 or world.process.poll() is not None

        world.go(PATIENCE, enough, spoil=missing, command=False)
        velocities = [sent for _, *sent in world.seen[:3]]
        heard = world.node.count_subscribers(MONITORED)
        found.append([velocities, heard, world.interrupted()[1]])
        world.node.destroy_node()  # a late zero is not the next node's
    tell(found)


if __name__ == "__main__":
    main(*sys.argv[1:])
