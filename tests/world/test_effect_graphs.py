"""What an effect's System computes, fed with a motion that wanders, against its twin."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import pytest

from tests.world import twins
from tests.world.motion import (
    EFFECTS,
    Changes,
    bound_of,
    delayed,
    fed,
    rows,
    scenario,
)
from wmr_ctrl.world.effect import Effect
from wmr_ctrl.world.encoder import ENCODER
from wmr_ctrl.world.gust import GUST
from wmr_ctrl.world.jitter import JITTER
from wmr_ctrl.world.model.dynamics import wheel_to_force
from wmr_ctrl.world.motor import MOTOR
from wmr_ctrl.world.pose_delay import POSE_DELAY
from wmr_ctrl.world.resistance import RESISTANCE
from wmr_ctrl.world.slope import SLOPE
from wmr_ctrl.world.velocity_mean import VELOCITY_MEAN
from wmr_ctrl.world.wheels import WHEELS

WHEELED = {"r": 0.1, "l": 0.25, "radius": (0.02, -0.01), "track": 0.02}
PLAIN = {"r": 0.1, "l": 0.25, "radius": (0.0, 0.0), "track": 0.0}
GROUND = {"m": 50.0, "g": 9.81, "l": 0.25, "v_s": 0.01}


def each(twin: Callable[..., tuple[float, float]], n: Changes) -> Callable[..., Any]:
    return lambda k, row: twin(n, row)


CASES: list[tuple[str, Effect, Changes, Callable[[], Callable[..., Any]]]] = [
    ("encoder", ENCODER, {"encoder.counts": 512},
     lambda: twins.EncoderTwin({**PLAIN, "counts": 512, "periods": 1, "T": 0.01})),
    ("encoder on other wheels", ENCODER,
     {"encoder.counts": 512, "encoder.window": 0.04, **EFFECTS["wheels"]},
     lambda: twins.EncoderTwin({**WHEELED, "counts": 512, "periods": 4, "T": 0.01})),
    ("mean", VELOCITY_MEAN, {"sensor.velocity_window": 0.03, "sensor.velocity_age": 0.02},
     lambda: twins.MeanTwin({"window": 3, "age": 2, "T": 0.01})),
    ("age", VELOCITY_MEAN, {"sensor.velocity_age": 0.02},
     lambda: twins.MeanTwin({"window": 0, "age": 2, "T": 0.01})),
    ("jitter", JITTER, {"actuator.jitter": 0.006},
     lambda: twins.JitterTwin({"delay": 0, "steps": 10, "most": 6})),
    ("jitter of a whole period", JITTER, {"actuator.jitter": 0.01, "actuator.delay": 0.013},
     lambda: twins.JitterTwin({"delay": 13, "steps": 10, "most": 10})),
    ("motor", MOTOR, EFFECTS["motor"],
     lambda: each(twins.motor_twin, {"step": 0.2, "dead_zone": 0.1, "stall": 20.0, "free": 30.0,
                                     "r": 0.1, "l": 0.25})),
    ("slope", SLOPE, EFFECTS["slope"],
     lambda: each(twins.slope_twin, {**GROUND, "angle": 0.03, "direction": 0.5, "offset": 0.02})),
    ("resistance", RESISTANCE, EFFECTS["resistance"],
     lambda: each(twins.resistance_twin, {**GROUND, "rolling": (0.01, 0.012),
                                          "viscous": (2.0, 0.1)})),
    ("gust", GUST, EFFECTS["gust"],
     lambda: twins.GustTwin({"size": (5.0, 1.0), "time": 0.1, "T": 0.01})),
]  # fmt: skip


@pytest.mark.parametrize(("effect", "changes", "twin"), [c[1:] for c in CASES],
                         ids=[c[0] for c in CASES])  # fmt: skip
@pytest.mark.slow_but("encoder", "mean", "age", "jitter", "motor", "slope", "resistance")
def test_a_system_is_its_twin(effect, changes, twin):
    motion, other = rows(400, np.random.default_rng(7)), twin()
    if effect is JITTER:
        late = 13 if "actuator.delay" in changes else 0
        motion = delayed(motion, late)
    wanted = np.array([other(k, row) for k, row in enumerate(motion)])

    assert np.abs(fed(effect.build(scenario(changes)), motion) - wanted).max() < 1e-12


def test_wheels_turn_torque_into_force_as_their_size_says():
    motion = rows(100, np.random.default_rng(8))
    shown = fed(WHEELS.build(scenario(EFFECTS["wheels"])), motion)
    forces = [wheel_to_force(ca.SX(0.1), ca.SX(0.25), ca.SX(torque)) for torque in shown.tolist()]
    wanted = [twins.wheels_twin(WHEELED, row) for row in motion]

    assert np.allclose([[float(f[0]), float(f[1])] for f in forces], wanted, rtol=1e-13)


def test_late_poses_are_old_poses():
    motion = rows(30, np.random.default_rng(9))
    shown = fed(POSE_DELAY.build(scenario({"sensor.pose_delay": 0.05})), motion)
    pose = [[row[n][0] for n in ("x", "y", "theta")] for row in motion]

    assert np.array_equal(shown, [pose[max(0, k - 5)] for k in range(30)])


def test_the_time_between_counts_shows_a_steady_speed_to_rounding():
    """Forwards, backwards, and so slow that a count takes many samples."""
    effect = ENCODER.build(scenario(EFFECTS["encoder by time"]))
    for speed in (0.5, -0.3, 0.004):
        motion = rows(400, np.random.default_rng(1))
        for k, row in enumerate(motion):
            row |= {"path": [0.01 * k * speed], "theta": [0.0], "skid": [0.0]}
        shown = fed(effect, motion)

        assert np.abs(shown[-100:, 0] - speed).max() < 1e-9 * abs(speed)
        assert np.abs(shown[:, 0]).max() <= abs(speed) * (1 + 1e-9)
        assert not shown[:, 1].any()


def test_the_time_between_counts_forgets_a_speed_when_the_robot_stops():
    motion = rows(300, np.random.default_rng(1))
    for k, row in enumerate(motion):
        row |= {"path": [0.005 * min(k, 100)], "theta": [0.0], "skid": [0.0]}
    shown = fed(ENCODER.build(scenario(EFFECTS["encoder by time"])), motion)[:, 0]
    count = 2 * math.pi * 0.1 / 1024

    assert shown[99] == pytest.approx(0.5)
    assert (np.diff(shown[102:]) < 0).all()
    assert shown[-1] < count / 1.9


# Why the time between counts has no bound.

COUNTS = pytest.mark.parametrize("counts", [64, 1024, 65536])


def timed(counts: int, v1: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """(v1, omega) shown for velocities (n,) that hold over a sample each."""
    motion = rows(len(v1) + 1, np.random.default_rng(1))
    way, turn = (np.concatenate([[0.0], np.cumsum(0.01 * item)]) for item in (v1, omega))
    for k, row in enumerate(motion):
        row |= {"path": [float(way[k])], "theta": [float(turn[k])], "skid": [0.0]}
    changes = {"encoder.counts": counts, "encoder.method": "time"}
    return fed(ENCODER.build(scenario(changes)), motion)[1:]


@COUNTS
@pytest.mark.slow_but("64", "65536")
def test_the_first_counts_after_a_stand_show_the_mean_over_all_of_it(counts):
    v1 = np.concatenate([np.full(50, 0.5), np.zeros(1000), np.full(5, 0.9)])
    shown = timed(counts, v1, 0 * v1)[:, 0]

    assert v1[1050] == 0.9
    assert shown[1050] < 0.01
    assert shown[1052] == pytest.approx(0.9)


@COUNTS
def test_two_windows_mix_turn_and_thrust_whatever_the_counts(counts):
    """The left wheel stands while the right one drives, then friction stops the turn."""
    omega = np.concatenate([np.full(300, 1.5), np.zeros(20)])
    v1 = np.full(320, 0.25 * 1.5)
    v1[0] += 0.4 * 2 * math.pi * 0.1 / counts / 0.01  # so that the left wheel stands between edges
    shown = timed(counts, v1, omega)
    off = v1[300:] - shown[300:, 0]

    assert off.max() == pytest.approx(0.25 * 1.5 / 2, rel=0.05)
    assert bound_of(ENCODER, {"encoder.counts": counts, "encoder.method": "time"}).void


@COUNTS
@pytest.mark.slow_but("1024")
def test_a_wheel_turns_by_nearly_a_count_unseen(counts):
    """As far as a difference over one period may be off, of the mean over that period."""
    count = 2 * math.pi * 0.1 / counts
    speed = 0.98 * count / 0.01
    v1 = np.zeros(2002)
    v1[0], v1[2001] = 1.01 * count / 0.01, speed
    shown = timed(counts, v1, 0 * v1)[2001, 0]
    nbar = bound_of(ENCODER, {"encoder.counts": counts}).nbar[0]

    assert 0.97 * nbar < speed - shown < nbar
