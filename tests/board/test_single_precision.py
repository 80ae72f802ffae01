"""Single precision keeps the velocity limit wherever double precision does."""

import shutil

import numpy as np
import pytest

from tests.board.emulated import HostBuild
from tests.board.robot import Robot
from tests.tables import changes
from wmr_ctrl.codegen.single_precision import PERIODS
from wmr_ctrl.world.scenario import load_scenario

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="NOT RUN: no cc")

NEAR = 0.9999
"""Largest share of the limits at a start."""

REGION = np.array([5.0, 5.0, np.pi, NEAR * 1.0, NEAR * 1.5])
"""Half-widths of the starts: x, y [m], theta [rad], v1 [m/s], omega [rad/s]."""

LIMITS = np.array([1.0, 1.5])
WORST = """
guard.enabled = true
robot.mu = 0.0
guard.mass_margin = 0.0
guard.dbar = [60.0, 15.0]
"""
"""No friction and the lightest robot, for which a disturbance of dbar is worst."""
SIDES = {"limits.v_min": [-0.6, -1.0], "limits.v_max": [1.0, 1.5]}
"""The limits backwards and to the right are smaller than the others."""


def nominal(control, stated):
    """The paper's circle without noise or change."""
    return load_scenario("paper-simulation-nominal", {"clock.control": control, **stated})


def starts(inside, at_the_edge):
    """Starts anywhere in the region, then some with both velocities at its edge."""
    draw = np.random.default_rng(3)
    drawn = draw.uniform(-1, 1, (inside + at_the_edge, 5))
    drawn[inside:, 3:] = np.sign(drawn[inside:, 3:])
    return list(drawn * REGION)


@pytest.mark.parametrize("law, guarded, control", [("mb", False, 1e-3), ("nn", True, 1e-2)])
@pytest.mark.slow
def test_the_limit_is_kept_from_the_stated_region(law, guarded, control, tmp_path):
    assert control in PERIODS[law, guarded]
    scenario = nominal(control, {"guard.enabled": guarded})
    builds = [HostBuild(law, scenario, tmp_path / str(f), float32=f) for f in (False, True)]
    for start in starts(4, 2) if control < 1e-2 else starts(12, 8):
        double, single = (largest(build, Robot(scenario, start), control) for build in builds)
        assert max(double, single) < 1.0
        assert abs(single - double) < 2e-4


@pytest.mark.parametrize("law, sides", [("pid", {}), ("mb", {}), ("mb", SIDES)])
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.slow_but("-1.0-pid-sides0", "1.0-mb-sides2")
def test_the_guard_keeps_the_limit_against_the_worst_push(law, side, sides, tmp_path):
    """A disturbance of dbar acts all the time, with a target ahead."""
    scenario = nominal(1e-2, changes(WORST) | sides)
    build = HostBuild(law, scenario, tmp_path, float32=True)
    robot = Robot(scenario, np.array([0.0, -side * 60.0, 0.0, 0.0, 0.0]))
    least = np.array(sides.get("limits.v_min", -LIMITS))

    assert 0.999 < largest(build, robot, 1e-2, least, push=3.0 * side, seconds=8.0) < 1.0


def largest(build, robot, control, least=-LIMITS, push=0.0, seconds=2.0):
    """Largest velocity as a share of its limit, under a constant push [N m] on the wheels."""
    build.reset()
    for k in range(round(seconds / control)):
        status, torque = build.step(robot.inputs(k))
        assert status == 0
        robot.advance(torque + push)
    return float(np.maximum(robot.velocities / LIMITS, robot.velocities / least).max())
