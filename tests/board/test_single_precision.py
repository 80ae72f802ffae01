"""Where single precision keeps the velocity limit: wherever double precision does."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.board.emulated import HostBuild
from tests.board.robot import Robot
from wmr_ctrl.scenario import load_scenario

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="NOT RUN: no cc")

REGION = np.array([5.0, 5.0, np.pi, 0.98, 0.98 * 1.5])
"""Half-widths of the starts: x, y [m], theta [rad], v1 [m/s], omega [rad/s]."""


@pytest.mark.parametrize(
    ("law", "control", "starts"), [("mb", 1e-3, 6), ("nn", 1e-3, 6), ("nn", 1e-2, 40)]
)
def test_the_limit_is_kept_from_the_stated_region(
    law: str, control: float, starts: int, tmp_path: Path
) -> None:
    scenario = load_scenario("paper-simulation-nominal", {"clock.control": control})
    builds = [HostBuild(law, scenario, tmp_path / str(f), float32=f) for f in (False, True)]
    draw = np.random.default_rng(3)
    for _ in range(starts):
        start = draw.uniform(-1, 1, 5) * REGION
        double, single = (fastest(build, Robot(scenario, start), control) for build in builds)
        assert double < 1.0
        assert single < 1.0
        assert abs(single - double) < 2e-4


def fastest(build: HostBuild, robot: Robot, control: float) -> float:
    """Largest velocity in 2 s, as a share of its limit."""
    build.reset()
    for k in range(round(2.0 / control)):
        status, torque = build.step(robot.inputs(k))
        assert status == 0
        robot.advance(torque)
    return float((robot.fastest / [1.0, 1.5]).max())
