"""The pose sensor: dead reckoning, corrected by each new pose."""

import math

import numpy as np
import pytest

from tests.world.motion import scenario
from wmr_ctrl.world.pose_sensor import POSE_SENSOR, PoseSensor

CHANGES = {"sensor.pose_period": 0.03, "sensor.pose_noise": 0.02, "sensor.correction": 0.5}
TRUE, VELOCITY = np.array([1.0, 2.0, 0.3]), [0.4, 0.6]
ESTIMATE, BEFORE = [0.9, 2.2, 0.1], [0.5, -1.0]


def seen(sample, changes=CHANGES, *lost):
    system = POSE_SENSOR.build(scenario(changes))
    graph = system.function("seen", [system.y])
    drawn = [0.5, -1.0, *lost]
    given = [*TRUE, *VELOCITY, sample]
    return graph(given, [*ESTIMATE, *BEFORE], system.p0, drawn).full().ravel()


def test_between_poses_it_is_reckoned_by_the_velocity_before_the_angle_first():
    theta = 0.1 - 1.0 * 0.01
    reckoned = [0.9 - 0.005 * math.sin(theta), 2.2 + 0.005 * math.cos(theta), theta]
    measured = TRUE + np.array([0.02 * 0.5, 0.02 * -1.0, 0.0])

    assert seen(4) == pytest.approx(reckoned, abs=1e-15)
    assert seen(6) == pytest.approx((np.array(reckoned) + measured) / 2, abs=1e-15)
    assert seen(0) == pytest.approx(measured, abs=1e-15)


def test_a_pose_is_lost_by_its_chance_but_never_the_first():
    losing = {**CHANGES, "sensor.pose_dropout": 0.25}

    assert seen(6, losing, -0.51, 0.0) == pytest.approx(seen(4), abs=1e-15)
    assert seen(6, losing, -0.49, 0.0) == pytest.approx(seen(6), abs=1e-15)
    assert seen(0, losing, -1.0, 0.0) == pytest.approx(seen(0), abs=1e-15)


@pytest.mark.parametrize("key", ["pose_period", "pose_noise", "pose_dropout", "correction"])
def test_it_is_perfect_only_without_any_error(key):
    assert scenario({}).section(PoseSensor).perfect
    assert not scenario({f"sensor.{key}": 0.5}).section(PoseSensor).perfect
