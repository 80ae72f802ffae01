"""Closed loops with the controller on an emulated board, the plant and a host's build here."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import median

import numpy as np

from tests.board.emulated import BOARDS, Emulated, HostBuild, built
from tests.board.robot import Robot

SAMPLES = 1000
"""10 s at 10 ms."""

EXTREMES = (0.0, 1e3, -1e3, 1e7, -1e30, np.inf, np.nan)
"""Angles and the rest of such sizes take the longest ways through a mathematics library."""


@dataclass(frozen=True)
class Lockstep:
    """Results of a loop on the emulated board.

    ``worst`` is the largest difference of a torque from the host's build, relative to 1 N m + the
    torque; ``distance`` is from the desired position at the end [m]; ``stack`` is the deepest seen,
    in bytes, samples of EXTREMES included.
    """

    worst: float
    instructions: int
    most_instructions: int
    stack: int
    distance: float


def lockstep(law, scenario, board, folder, *, float32):
    """SAMPLES samples of ``law`` on ``board``; raises RuntimeError where a sample fails."""
    firmware = built(law, scenario, BOARDS[board], folder / "board", float32=float32)
    host = HostBuild(law, scenario, folder / "host", float32=float32)
    robot, counts, worst = Robot(scenario), [], 0.0
    with Emulated(firmware, BOARDS[board], float32=float32) as emulated:
        for k in range(SAMPLES):
            inputs = robot.inputs(k)
            status, torque, instructions = emulated.step(inputs)
            if status:
                raise RuntimeError(f"sample {k}: the step returned {status}")
            wanted = host.step(inputs)[1]
            counts.append(instructions)
            worst = max(worst, float((abs(torque - wanted) / (1 + abs(wanted))).max()))
            robot.advance(torque)
        for size in EXTREMES:
            emulated.step(np.full(len(inputs), size))
        stack = emulated.deepest_stack()
    return Lockstep(worst, int(median(counts)), max(counts), stack, robot.distance(SAMPLES))
