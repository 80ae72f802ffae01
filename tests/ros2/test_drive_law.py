"""Frames of REP-103 at the drive's interface, and its law's memory behind the gate."""

import math

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.control.filter.test_filter_behind_laws import scenario
from wmr_ctrl.control.filter.gate import GateSettings
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.signals import SAMPLE
from wmr_ctrl.ros2.clocks import Moment
from wmr_ctrl.ros2.drive_core import DriveCore, DriveSettings
from wmr_ctrl.ros2.drive_law import DesiredMotion, heading

DRAWS = 300


def turned(yaw, pitch=0.0, roll=0.0):
    """Quaternion (x, y, z, w): yaw, then pitch, then roll, as REP-103 composes them."""
    return Rotation.from_euler("ZYX", (yaw, pitch, roll)).as_quat()


@pytest.fixture(scope="module")
def theta_of():
    quaternion, near = ca.SX.sym("quaternion", 4), ca.SX.sym("near")
    return ca.Function("theta", [quaternion, near], [heading(quaternion, near)])


def test_theta_is_yaw_less_a_quarter_turn_whatever_tilt_length_and_sign(theta_of):
    """q and -q are one orientation."""
    draws = np.random.default_rng(1)
    for _ in range(DRAWS):
        yaw, (pitch, roll) = draws.uniform(-20, 20), draws.uniform(-1.4, 1.4, 2)
        q = draws.choice([-1, 1]) * draws.uniform(0.99, 1.01) * turned(yaw, pitch, roll)
        theta = float(theta_of(q, yaw - math.pi / 2 + draws.uniform(-3, 3)))
        assert theta == pytest.approx(yaw - math.pi / 2, abs=1e-12)


ROW = [3.0, 0.0, 0.0, 0.4, 0.2, 0.0, 0.0]
"""A desired motion that stays far away."""
SLOW = GateSettings(odometry="required", command_timeout=0.1, rise=(1e-6, 1e-6))
"""Ramps that let nothing through: the base stands still whatever a law wishes."""


@pytest.mark.parametrize("law", ["kanayama", "pursuit", "prox"])
@pytest.mark.slow_but("prox")
def test_behind_a_ramp_nothing_winds_up(law, monkeypatch):
    core = DriveCore(settle(scenario(), law), DriveSettings(gate=SLOW))
    monkeypatch.setattr(core._motion, "at", lambda _sample, _rest: ROW)
    found, wish = [], core._law.wish

    def watched(*given):
        found.append(wish(*given))
        return found[-1]

    monkeypatch.setattr(core._law, "wish", watched)
    for k in range(1, 300):
        now = Moment(10**9 + k * 20_000_000, k * 20_000_000)
        core.see(now)
        standing = (0.0, -2.0, 0.0, 0.0, *turned(math.pi / 2 - 3.0)[2:], 0.0, 0.0)
        core.odometry(standing, now.ros, "odom", "base_link", now)
    wishes = np.array([item.command for item in found])

    assert max(map(abs, core.last.command)) < 1e-3
    assert len(wishes) > 200
    assert np.abs(wishes[0]).max() > 0.01
    assert np.ptp(wishes[5:], axis=0).max() < 1e-3


class Recorder:
    """A reference with memory that records the samples shown and committed."""

    def __init__(self):
        self.seen, self.taken = [], []

    def look(self, u):
        self.seen.append(u[0])
        return [0.0]

    def move(self):
        self.taken.append(self.seen[-1])


def test_a_reference_with_memory_takes_each_sample_in_once_and_in_order():
    """Also if a sample is requested several times, or an earlier one in between."""
    motion, stepper = object.__new__(DesiredMotion), Recorder()
    vars(motion).update(_stepper=stepper, _inputs=[SAMPLE], _stateful=True, _period=0.1, _sample=0)
    for sample in (0, 3, 3, 2, 4):
        motion.at(sample, 0.0)

    assert stepper.taken == [0.0, 1.0, 2.0, 3.0]
    assert stepper.seen[-1] == 4.0
