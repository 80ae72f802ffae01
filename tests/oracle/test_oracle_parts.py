"""The oracle's noise, references, plant, drives and sensor, one by one."""

import math
from dataclasses import astuple, replace

import numpy as np
import pytest

from tests.oracle import actuator, noise
from tests.oracle.plant import Plant, limited_force, plants, wheel_torques
from tests.oracle.references import reference_of
from tests.oracle.sensing import Sensors as OracleSensor
from tests.papers_robot import paper
from wmr_ctrl.world.references import Circle, Lemniscate, Line, RoundedSquare, StopAndGo, Waypoints
from wmr_ctrl.world.registry import Actuator, Disturbance, Sensor
from wmr_ctrl.world.scenario import Change
from wmr_ctrl.world.scenario.sections import Clock

PAPER = paper().robot

# -- noise ----


def philox4x64(counter, key):
    """One block of Philox4x64 with ten rounds, as published by Salmon et al. (2011)."""
    word = 2**64 - 1
    c, k = list(counter), list(key)
    for _ in range(10):
        low, high = 0xD2E7470EE14C6C93 * c[0], 0xCA5A826395121157 * c[2]
        c = [(high >> 64) ^ c[1] ^ k[0], high & word, (low >> 64) ^ c[3] ^ k[1], low & word]
        k = [(k[0] + 0x9E3779B97F4A7C15) & word, (k[1] + 0xBB67AE8584CAA73B) & word]
    return c


@pytest.mark.parametrize("stream", [noise.TORQUE, noise.POSE, noise.VELOCITY])
@pytest.mark.parametrize("attempt", [0, 3])
@pytest.mark.parametrize("seed", [0, 7])
def test_raw_numbers_are_philox_blocks_to_the_bit(seed, attempt, stream):
    key = noise.key_of(seed)
    raw = noise.raw_blocks(key, 0, 5, stream, attempt).tolist()

    pair = (int(key[0]), int(key[1]))
    assert raw == [philox4x64((k, stream, attempt, 0), pair) for k in range(5)]
    assert noise.raw_blocks(key, 3, 2, stream, attempt).tolist() == raw[3:]


def test_torque_noise_is_standard_normal():
    drawn = noise.torque_noise(noise.key_of(1), 100_000, Disturbance(std=2.0))

    assert drawn.mean(axis=0) == pytest.approx([0.0, 0.0], abs=0.03)
    assert drawn.std(axis=0) == pytest.approx([2.0, 2.0], rel=0.01)


def test_truncated_noise_redraws_only_what_is_beyond():
    key = noise.key_of(2)
    free = noise.torque_noise(key, 500, Disturbance(std=1.0))
    held = noise.torque_noise(key, 500, Disturbance(std=1.0, truncate=1.5))

    inside = np.abs(free).max(axis=1) <= 1.5
    assert 0 < inside.sum() < 500
    assert np.array_equal(held[inside], free[inside])
    assert np.abs(held).max() <= 1.5
    assert np.abs(noise.torque_noise(key, 20, Disturbance(std=1.0, truncate=1e-9))).max() <= 1e-9


# -- references ----

KINDS = (
    Circle(),
    Circle(radius=1.0, rate=-0.2),
    Line(speed=0.3, heading=0.4, origin=(1.0, -2.0)),
    Lemniscate(size=2.0, rate=0.1),
    RoundedSquare(side=3.0, corner=0.8, speed=0.2),
    StopAndGo(radius=2.0, speed=0.4, period=10.0),
    Waypoints(points=((0.0, 0.0), (1.0, 0.2), (1.5, 1.0), (1.0, 2.0)), speed=0.2, closed=False),
    Waypoints(points=((0.0, 0.0), (2.0, 0.0), (2.0, 1.5), (0.0, 1.5)), speed=0.2, closed=True),
)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: type(kind).__name__)
def test_reference_is_feasible_and_its_rates_are_its_derivatives(kind):
    reference = reference_of(kind)
    h = 1e-5
    for t in np.linspace(0.0123, 119.7, 400):
        here, before, after = reference(t), reference(t - h), reference(t + h)
        slope = [(b - a) / (2.0 * h) for a, b in zip(astuple(before), astuple(after), strict=True)]

        assert slope[0] == pytest.approx(-here.v1 * math.sin(here.theta), abs=1e-7)
        assert slope[1] == pytest.approx(here.v1 * math.cos(here.theta), abs=1e-7)
        rates = [here.v2, here.v1_dot, here.v2_dot]
        assert slope[2:5] == pytest.approx(rates, abs=1e-6)


def test_circle_is_the_papers():
    here = reference_of(Circle(radius=2.0, rate=0.1))(7.0)

    assert here.x == 2.0 * math.sin(0.7000000000000001)
    assert here.theta == pytest.approx(0.7 - math.pi / 2.0, abs=1e-15)
    assert astuple(here)[3:] == pytest.approx((0.2, 0.1, 0.0, 0.0), abs=1e-15)


# -- plant, drives, sensor ----


def test_plant_without_friction_accelerates_as_newton_says():
    plant = Plant(replace(PAPER, mu=0.0))
    state = (0.0, 0.0, 0.0, 0.0, 0.0)
    for _ in range(1000):
        state = plant.step(state, (1.5, 0.5), 0.001)

    thrust, moment = 2.0 / 0.1, 0.25 * 1.0 / 0.1
    assert state[3] == pytest.approx(thrust / 50.0, rel=1e-12)
    assert state[4] == pytest.approx(moment / 5.4, rel=1e-12)
    assert state[2] == pytest.approx(moment / 5.4 / 2.0, rel=1e-12)


def test_plant_step_converges_with_the_fourth_order():
    plant = Plant(replace(PAPER, mu=0.0))
    start, torque = (0.0, 0.0, 0.3, 0.5, 1.0), (3.0, 1.0)

    def error(steps):
        state = start
        for _ in range(steps):
            state = plant.step(state, torque, 1.0 / steps)
        return math.hypot(state[0] - fine[0], state[1] - fine[1])

    fine = start
    for _ in range(1000):
        fine = plant.step(fine, torque, 0.001)
    assert error(4) / error(8) == pytest.approx(16.0, rel=0.25)


def test_change_holds_from_the_first_plant_step_that_starts_with_it():
    schedule = plants(PAPER, (Change(t=0.0035, m=60.0), Change(t=0.3, mu=0.2)), Clock())

    assert [first for first, _ in schedule] == [0, 4, 300]
    last = schedule[-1][1].robot
    assert (last.m, last.I, last.mu) == (60.0, 5.4, 0.2)


def test_torque_limit_serves_the_thrust_first():
    robot, most = PAPER, 2.0 * 5.0 / 0.1

    assert limited_force((30.0, 2.0), 5.0, robot) == (30.0, 2.0)
    assert limited_force((500.0, 2.0), 5.0, robot) == (most, 0.0)
    for force in [(80.0, -40.0), (-10.0, 99.0), (-300.0, 1.0)]:
        torque = wheel_torques(limited_force(force, 5.0, robot), robot)
        assert max(map(abs, torque)) == pytest.approx(5.0, abs=1e-12)


def test_drive_delays_then_lags():
    clock = Clock(duration=0.1)
    drive = actuator.Drives(Actuator(delay=0.002, lag=0.01), clock, noise.key_of(0))
    acting = [drive.advance((1.0, -2.0)) for _ in range(5)]

    keep = math.exp(-0.1)
    expected = [0.0, 0.0, 1.0 - keep, 1.0 - keep**2, 1.0 - keep**3]
    assert [right for right, _ in acting] == pytest.approx(expected, abs=1e-15)
    assert [left for _, left in acting] == pytest.approx([-2.0 * e for e in expected], abs=1e-15)


def test_pose_is_dead_reckoned_between_corrections():
    settings = Sensor(pose_period=0.02, correction=0.25)
    sensor = OracleSensor(settings, Clock(duration=0.1), noise.key_of(0))
    first, _ = sensor.look(0, (1.0, 2.0, 0.0, 0.5, 1.0))
    second, velocity = sensor.look(1, (9.0, 9.0, 9.0, 0.6, 0.0))
    third, _ = sensor.look(2, (9.0, 9.0, 9.0, 0.0, 0.0))

    assert first == (1.0, 2.0, 0.0)
    moved = (1.0 - 0.005 * math.sin(0.01), 2.0 + 0.005 * math.cos(0.01), 0.01)
    assert second == pytest.approx(moved, abs=1e-15)
    assert velocity == (0.6, 0.0)
    ahead = (moved[0] - 0.006 * math.sin(0.01), moved[1] + 0.006 * math.cos(0.01), 0.01)
    assert third == pytest.approx([p + 0.25 * (9.0 - p) for p in ahead], abs=1e-14)
