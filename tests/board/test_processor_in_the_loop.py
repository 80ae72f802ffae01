"""The packages on emulated Cortex-M boards: controller there, plant here, in lockstep."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.board.emulated import BOARDS, Emulated, HostBuild, built, missing
from tests.board.robot import Robot
from wmr_ctrl.scenario import load_scenario

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing())

SCENARIO = load_scenario("paper-simulation-nominal")
SAMPLES = 1000
"""10 s at 10 ms."""

TOLERANCE = {False: 1e-11, True: 2e-4}
"""Largest torque difference from the host's build of the same precision, relative to 1 N m + the
torque: two mathematics libraries, and memories that each carry on for 10 s."""

MOST_INSTRUCTIONS = {
    ("cortex-m4f", "mb", True): 2_000,
    ("cortex-m4f", "nn", True): 8_000,
    ("cortex-m4f", "mb", False): 60_000,
    ("cortex-m4f", "nn", False): 150_000,
    ("cortex-m7", "mb", True): 2_000,
    ("cortex-m7", "nn", True): 8_000,
    ("cortex-m7", "mb", False): 4_000,
    ("cortex-m7", "nn", False): 12_000,
}
"""Of the slowest sample; doubles are computed in software on the M4F."""


@pytest.mark.parametrize("float32", [True, False], ids=["float32", "double"])
@pytest.mark.parametrize("law", ["mb", "nn"])
@pytest.mark.parametrize("board", list(BOARDS))
def test_ten_seconds_in_lockstep(
    board: str, law: str, float32: bool, tmp_path: Path, record_property: object
) -> None:
    firmware = built(law, SCENARIO, BOARDS[board], tmp_path / "board", float32=float32)
    host = HostBuild(law, SCENARIO, tmp_path / "host", float32=float32)
    robot, counts, worst = Robot(SCENARIO), [], 0.0
    with Emulated(firmware, BOARDS[board], float32=float32) as emulated:
        for k in range(SAMPLES):
            inputs = robot.inputs(k)
            status, torque, instructions = emulated.step(inputs)
            counts.append(instructions)
            assert status == 0
            wanted = host.step(inputs)[1]
            worst = max(worst, float((abs(torque - wanted) / (1 + abs(wanted))).max()))
            robot.advance(torque)
        stack = emulated.deepest_stack()
    for name, value in (("worst", worst), ("instructions", float(np.median(counts))),
                        ("most_instructions", max(counts)), ("stack", stack)):  # fmt: skip
        record_property(name, value)

    assert worst < TOLERANCE[float32]
    assert max(counts) <= MOST_INSTRUCTIONS[board, law, float32]
    assert stack < 8192
    assert robot.distance(SAMPLES) < 0.2


def test_bad_input_gives_no_torque_and_keeps_the_memory(tmp_path: Path) -> None:
    firmware = built("nn", SCENARIO, BOARDS["cortex-m4f"], tmp_path, float32=True)
    with Emulated(firmware, BOARDS["cortex-m4f"], float32=True) as emulated:
        good = Robot(SCENARIO).inputs(0)
        first = emulated.step(good)[1]
        status, torque, _ = emulated.step(np.where(np.arange(len(good)) == 7, np.nan, good))

        assert status == 1
        assert (torque == 0).all()
        assert emulated.step(good)[0] == 0
        assert np.isfinite(first).all()
