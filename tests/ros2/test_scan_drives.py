"""Bases at the ends of their bounds among walls that a laser sees: none is touched."""

import math

import numpy as np
import pytest

from tests.ros2.lasers import RPLIDAR, walls
from wmr_ctrl.control.filter.gate import GateSettings
from wmr_ctrl.ros2.clocks import Moment
from wmr_ctrl.ros2.filter_core import FilterCore
from wmr_ctrl.ros2.sight import SightSettings
from wmr_ctrl.world.scenario import load_scenario

RADIUS, PERIOD, STEP, REST = 0.25, 0.05, 0.005, 0.6
GAINS, LAGS, PUSHES, DELAYS = (0.9, 1.1), (0.1, 0.25), (0.04, 0.03), (0.02, 0.06)
STATED = {
    "limits.v_u1": [0.6, 1.2], "limits.v_u2": [0.5, 1.0], "clock.control": PERIOD,
    "base.kind": "velocity", "filter.kind": "governor", "filter.gain": GAINS, "filter.tau": LAGS,
    "filter.d": PUSHES, "filter.delay": DELAYS, "filter.free_error": 0.01, "filter.rest": REST,
}  # fmt: skip
FASTEST = GateSettings(odometry="none", rise=(1e6, 1e6), fall=(1e6, 1e6))


@pytest.fixture(scope="module")
def core():
    scenario = load_scenario("paper-simulation", STATED)
    return FilterCore(scenario, FASTEST, "", SightSettings(scans=("scan",), radius=RADIUS))


class Base:
    """Speeds that follow commands late, and stand once zeros acted for the rest."""

    def __init__(self, chance):
        self.gain, self.lag = chance.choice(GAINS, 2), chance.choice(LAGS, 2)
        self.push = chance.choice([-1, 0, 1], 2) * PUSHES
        self.delay = round(chance.choice(DELAYS) / STEP)
        self.pose, self.speed, self.idle, self.way = np.zeros(3), np.zeros(2), 0.0, 0.0
        self.waiting = [np.zeros(2)] * (self.delay + 1)

    def move(self, command):
        """A step of the motion; ``command`` is the one just sent."""
        self.waiting.append(np.array(command))
        acting = self.waiting.pop(0)
        self.idle = 0.0 if acting.any() else self.idle + STEP
        wanted = self.gain * acting + self.push
        self.speed += (wanted - self.speed) * -np.expm1(-STEP / self.lag)
        self.speed *= self.idle < REST
        v, omega = STEP * self.speed
        self.pose += [v * math.cos(self.pose[2]), v * math.sin(self.pose[2]), omega]
        self.way += abs(v)


def driven(core, seed, sees):
    """Least gap [m] and way [m] of a base that is driven by chance in a room; unseen: no walls."""
    chance = np.random.default_rng(seed)
    turns = np.arange(4) * math.pi / 2 + chance.uniform(-0.4, 0.4, 4)
    room = [(math.cos(a), math.sin(a), chance.uniform(0.5, 1.5)) for a in turns]
    seen, base, least = walls(*(room if sees else ())), Base(chance), math.inf
    core.start()
    for k in range(400):
        now = Moment(10**15 + k * 50_000_000, (k + 1) * 50_000_000)
        core.see(now)
        if k % 20 == 0:
            asked = chance.uniform(-0.8, 0.8), chance.choice([0, 1]) * chance.uniform(-1.2, 1.2)
        if k % 2 == 0:
            ranges = RPLIDAR.scan(seen, tuple(base.pose))
            assert core.scan(0, RPLIDAR.numbers, ranges, now.ros, now) == ""
        core.command(asked, now.ros, "", now)
        command = core.tick(now).command
        for _ in range(round(PERIOD / STEP)):
            base.move(command)
            least = min(least, *(c - a * base.pose[0] - b * base.pose[1] for a, b, c in room))
    return least - RADIUS, base.way


@pytest.mark.parametrize(
    "seeds", [range(4), pytest.param(range(4, 60), marks=pytest.mark.slow)], ids=["few", "many"]
)
def test_no_wall_that_is_seen_is_touched(core, seeds):
    found = [driven(core, seed, sees=True) for seed in seeds]

    assert min(gap for gap, _ in found) >= 0
    assert min(way for _, way in found) > 1


def test_walls_that_are_not_seen_are_touched(core):
    """The bases are driven into them."""
    assert min(driven(core, seed, sees=False)[0] for seed in range(2)) < 0
