"""Scans and limits over real DDS, in Python and in C: bit for bit the commands of the core."""

import math
from functools import cache

import numpy as np
import pytest

from tests.ros2.conftest import OVER_DDS, in_both
from tests.ros2.lasers import LDS_01, RPLIDAR, walls
from tests.ros2.test_scans import RADIUS, STATED
from wmr_ctrl.ros2.c_node import node_settings
from wmr_ctrl.ros2.clocks import Moment
from wmr_ctrl.ros2.filter_core import FilterCore
from wmr_ctrl.world.scenario import load_scenario, to_toml

COMPILED = (
    "trigger=command", "command_timeout=60.0", "odometry_timeout=60.0", "rise=[1e6, 1e6]",
    "excess=[1.0, 1.0]", "odometry=watched", "fall=[0.5, 1.0]", 'scans=["/base/scan"]',
    f"radius={RADIUS}", "scan_pose=[0.05, 0.0, 0.1]", "no_return=range_max",
)  # fmt: skip
OURS = tuple(word.replace("=", ":=", 1) for word in COMPILED[6:])
"""Those that the script does not give by itself."""
LATER = 100_000_000_000
AT_REST, DRIVEN = 60, 160
CHANGES = {**STATED, "filter.free_age": 0.5}
ROOM = walls((1.0, 0.1, 1.6), (-1.0, 0.2, 1.5), (0.1, 1.0, 0.9), (0.0, -1.0, 1.0))
pytestmark = [pytest.mark.slow, OVER_DDS]


@cache
def played():
    """Rows of a base that follows its commands in a room, and the commands of the core."""
    scenario, settings = load_scenario("paper-simulation", CHANGES), node_settings(COMPILED)
    core = FilterCore(scenario, settings.gate, "", settings.sight, at_once=True)
    period = round(scenario.clock.control * 1e9)
    chance, pose, rows, sent = np.random.default_rng(1), np.zeros(3), [], []
    asked = np.array([0.3, 0.0])
    for k in range(AT_REST + DRIVEN):
        stamp, laser = LATER + k * period, RPLIDAR if k % 3 else LDS_01
        numbers = [float(np.float32(number)) for number in laser.numbers]
        ranges = [float(np.float32(r)) for r in laser.scan(ROOM, tuple(pose))]
        if k % 20 == 0:
            asked = chance.uniform([-0.5, -1.0], [0.5, 1.0]) * (1, k % 40 > 0)
        v, omega = asked if k >= AT_REST else (0.0, 0.0)
        limit, age = (0.5, 0.25)[k > AT_REST + DRIVEN // 2], int(chance.integers(0, 4)) * 10**7
        now = Moment(stamp, k * period, True)
        core.see(now)
        core.limit("v_max", (limit, 9.0), now)
        assert core.scan(0, tuple(numbers), ranges, stamp - age, now) == ""
        gated = core.command((v, omega), stamp, "", now)[1]
        sent.append(gated.command)
        turn = pose[2]
        pose += 0.05 * np.array([v_ := sent[-1][0], 0.0, sent[-1][1]]) * [math.cos(turn), 0, 1]
        pose[1] += 0.05 * v_ * math.sin(turn)
        rows.append({
            "stamp": stamp, "age": age, "v": float(v), "omega": float(omega), "limit": limit,
            "numbers": numbers, "ranges": [r if math.isfinite(r) else str(r) for r in ranges],
        })  # fmt: skip
    return {"settings": OURS, "rows": rows}, np.array(sent)


def JOBS():
    text = to_toml(load_scenario("paper-simulation", CHANGES), comments=False)
    jobs = in_both("scan_lockstep.py", text, ("{rows}",), COMPILED, played()[0])
    return {f"scans, {node}": job for node, job in jobs.items()}


@pytest.mark.parametrize("node", ["Python", "C"])
def test_answers_to_scans_and_limits_are_those_of_the_core(report, node):
    rows, expected = played()
    found = report(f"scans, {node}")
    asked = np.array([[row["v"], row["omega"]] for row in rows["rows"]])

    assert found["code"] == 0
    assert np.array(found["answers"], dtype=float).tobytes() == expected.tobytes()
    assert (asked != expected)[AT_REST:].mean() > 0.1
    assert np.any(expected != 0)
    least = np.diff(np.abs(expected[:, 0])).min()
    assert least < -0.1, "a stop for what is near is not ramped as the gate ramps others"
