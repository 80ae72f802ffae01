"""For any inputs in any order and at any time, a core's commands are in the stated set."""

import math

import numpy as np
import pytest

from tests.ros2.worlds import MS
from tests.tables import changes
from wmr_ctrl.control.filter.gate import GateSettings
from wmr_ctrl.control.setup import settle
from wmr_ctrl.ros2.clocks import Moment
from wmr_ctrl.ros2.drive_core import DriveCore, DriveSettings
from wmr_ctrl.ros2.filter_core import FilterCore
from wmr_ctrl.world.scenario import load_scenario, override

EVENTS = 2_000
GAIN, PUSH, RIM = 1.1, 0.05, 1.2
TOP = ((1.0 - PUSH) / GAIN, (2.0 - PUSH) / GAIN)
STATED = changes(f"""
limits.v_u1 = [1.0, 2.0]; limits.v_u2 = [0.7, 1.4]; clock.control = 0.02
filter.kind = "clip"; filter.gain = [0.9, {GAIN}]; filter.d = [{PUSH}, {PUSH}]
filter.wheel_speed = {RIM}; base.kind = "velocity"
""")
WILD = (math.nan, math.inf, -math.inf, 1e300, -5.0, 0.0, 0.3, 2.0)
FRAMES = ("base_link", "", "map", "laser")


@pytest.fixture(scope="module")
def scenario():
    return load_scenario("paper-simulation", STATED)


def at_the_rim(command, half_track):
    """Largest ground speed of a wheel that a command can cause [m/s]."""
    v, omega = map(abs, command)
    return GAIN * (v + half_track * omega) + PUSH * (1 + half_track)


def inside(command, half_track):
    """True if each axis is within its limit over the gain, and each wheel's ground speed, too."""
    v, omega = map(abs, command)
    rim = at_the_rim(command, half_track)
    return v <= TOP[0] and omega <= TOP[1] and rim <= RIM * (1 + 1e-12)


class Chaos:
    """Random messages and moments: clocks that stop, leap and go back, frozen processes."""

    def __init__(self, seed):
        self.draws = np.random.default_rng(seed)
        self.ros, self.steady = 1_000_000 * MS, 7_000 * MS

    def now(self):
        draw = self.draws
        self.steady += int(draw.choice([0, MS, 20 * MS, 700 * MS], p=[0.1, 0.4, 0.49, 0.01]))
        leap = draw.choice([0, 1, 20, -10_000, 10_000], p=[0.1, 0.4, 0.49, 0.005, 0.005])
        self.ros = max(1, self.ros + int(leap) * MS)
        return Moment(self.ros, self.steady, bool(draw.random() < 0.5))

    def number(self):
        wild = self.draws.random() < 0.15
        return float(self.draws.choice(WILD) if wild else 0.5 * self.draws.normal())

    def stamp(self):
        return int(self.draws.choice([0, self.ros, self.ros - 90 * MS, self.ros + 40 * MS, 5]))

    def frame(self, right):
        return str(self.draws.choice(FRAMES)) if self.draws.random() < 0.1 else right

    def turn(self):
        yaw = 0.3 * self.draws.normal()
        whole = (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
        return whole if self.draws.random() < 0.9 else (0.0, self.number(), 0.0, self.number())


@pytest.mark.parametrize(
    "odometry, at_once", [("none", False), ("watched", True), ("required", False)]
)
@pytest.mark.slow_but("watched-True")
def test_a_filter_sends_what_it_may_whatever_comes(scenario, odometry, at_once):
    settings = GateSettings(odometry=odometry, rise=(50.0, 50.0))
    core = FilterCore(scenario, settings, "base_link", at_once=at_once)
    core.start()
    chaos, half_track, sent = Chaos(3), scenario.robot.l, []
    for _ in range(EVENTS):
        now, draw, gated = chaos.now(), chaos.draws.random(), None
        pair, stamp = (chaos.number(), chaos.number()), chaos.stamp()
        frame = chaos.frame("base_link")
        core.see(now)
        if draw < 0.4:
            _, gated = core.command(pair, stamp, frame, now)
        elif draw < 0.75:
            core.measure(pair, chaos.turn(), stamp, frame, now)
        elif draw < 0.975:
            gated = core.tick(now)
        elif draw < 0.985:
            gated = core.halt(bool(chaos.draws.random() < 0.3), now)
        else:
            core.reset()
        sent += [gated.command] if gated else []

    assert all(inside(command, half_track) for command in sent)
    assert sum(map(any, sent)) > EVENTS / 100  # it was not at rest all the time
    fastest = max(at_the_rim(command, half_track) for command in sent)
    assert fastest > 0.99 * RIM or odometry == "required"  # which is seldom there for long


def test_a_drive_sends_what_it_may_whatever_comes(scenario):
    smooth = override(scenario, changes("robot.mu = 0.0; disturbance.std = 0.0; changes = []"))
    core = DriveCore(settle(smooth, "kanayama"), DriveSettings())
    chaos, pose, sent = Chaos(4), np.zeros(2), []
    for _ in range(EVENTS // 4):
        now, draw, gated = chaos.now(), chaos.draws.random(), None
        core.see(now)
        if draw < 0.75:
            pose = pose + 0.001 * chaos.draws.normal(size=2)
            rest, stamp, child = (0.0, 0.0, 0.0, 1.0, 0.2, 0.1), now.ros, "base_link"
            if chaos.draws.random() > 0.9:
                rest = *chaos.turn(), chaos.number(), chaos.number()
                stamp, child = chaos.stamp(), chaos.frame("base_link")
            _, gated = core.odometry((*map(float, pose), *rest), stamp, "odom", child, now)
        elif draw < 0.98:
            gated = core.tick(now)
        elif draw < 0.985:
            gated = core.halt(bool(chaos.draws.random() < 0.3), now)
        else:
            core.reset()
        sent += [gated.command] if gated else []

    assert all(inside(command, scenario.robot.l) for command in sent)
    assert sum(map(any, sent)) > EVENTS / 1000
