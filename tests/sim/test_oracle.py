"""The NumPy oracle against independent evaluations of its definitions, and its figures."""

from __future__ import annotations

import math
from dataclasses import astuple, replace
from typing import Any

import mpmath
import numpy as np
import pytest

from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.scenario import (
    Actuator,
    Change,
    Circle,
    Clock,
    Disturbance,
    Lemniscate,
    Line,
    Robot,
    RoundedSquare,
    Scenario,
    Sensor,
    StopAndGo,
    Waypoints,
    load_scenario,
)
from wmr_ctrl.signals import LOG_HEAD
from wmr_ctrl.sim.oracle import actuator, noise, simulate_oracle
from wmr_ctrl.sim.oracle.barrier import barrier
from wmr_ctrl.sim.oracle.plant import Plant, limited_force, plants, wheel_torques
from wmr_ctrl.sim.oracle.references import reference_of
from wmr_ctrl.sim.oracle.sensing import Sensor as OracleSensor

KINEMATICS = {"k": (10.0, 5.0, 4.0)}
GAINS: dict[str, dict[str, Any]] = {
    "pid": {"Kp": (210.0, 1.1), "Kd": (0.64, 0.08)},
    "smc": {
        "K": (200.0, 20.0),
        "eta": (5.0, 0.5),
        "boundary": 0.1,
        "v_s": 0.01,
        "g_m": 0.5,
        "g_F": 50.0,
        "axis_scale": (1.0, 0.1),
    },
    "mb": {"rho": (15.0, 57.6)},
    "nn": {
        "rho1": (1350.0, 21.6),
        "Gamma": (20000.0, 800.0),
        "sigma": (1e-4, 1e-4),
        "eta": math.sqrt(2.0),
        "node": 1.0,
        "ratio_cap": 1e3,
        "integrator": "explicit",
    },
}
LAWS = tuple(GAINS)


def simulate(
    scenario: Scenario, law: str, seed: int = 0
) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    return simulate_oracle(scenario, law, GAINS[law], KINEMATICS, seed)


def shortened(scenario: Scenario, duration: float) -> Scenario:
    """The scenario's first ``duration`` seconds."""
    changes = tuple(change for change in scenario.changes if change.t < duration)
    return replace(scenario, changes=changes, clock=replace(scenario.clock, duration=duration))


# -- the barrier, Eqs. (10)-(20), at 50 digits -----------------------------------------------------

LIMITS = ((1.0, 0.8), (1.5, 1.3), (3.0, 0.5))


def exact_barrier(v: float, c: float, u1: float, u2: float) -> tuple[Any, ...]:
    """(v_c1, v - v_c1, V1, V1/A, q), straight from the printed definitions."""
    with mpmath.workdps(50):
        V, C, U1, U2 = (mpmath.mpf(number) for number in (v, c, u1, u2))
        delta, side = U1 - U2, mpmath.sign(C)
        x = C
        if abs(C) > U2:
            x = side * U2
        if abs(C) > U2 + 1 / delta:
            x = side * (abs(C) + U1 - mpmath.sqrt((abs(C) - U1) ** 2 + 4)) / 2

        def f(speed: Any) -> Any:
            return -mpmath.log((U1 - abs(speed)) / delta) if abs(speed) > U2 else mpmath.mpf(0)

        V1 = (V - C) ** 2 / 2 + f(V) - (x - C) ** 2 / 2 - f(x)
        A = V - C + (mpmath.sign(V) / (U1 - abs(V)) if abs(V) > U2 else 0)
        return x, V - x, V1, V1 / A, (V - x) / A


def random_points(u1: float, u2: float, count: int) -> list[tuple[float, float]]:
    """(v, c) in all regions: anywhere, near v_c1, near the kink and near the limit."""
    rng = np.random.default_rng(20)
    dead = u2 + 1.0 / (u1 - u2)
    points = []
    for _ in range(count):
        c = rng.choice([rng.uniform(0, u2), rng.uniform(u2, dead), dead + 10 ** rng.uniform(-6, 3)])
        x = float(exact_barrier(0.1234, c, u1, u2)[0])
        near = rng.choice([-1, 1]) * 10 ** rng.uniform(-12, -1)
        v = rng.choice([rng.uniform(-u1, u1), x + near, u2 + near, -u2 + near, u1 - abs(near)])
        side = rng.choice([-1, 1])
        points.append((side * float(np.clip(v, 1e-6 - u1, u1 - 1e-6)), side * float(c)))
    return points


@pytest.mark.parametrize(("u1", "u2"), LIMITS)
def test_barrier_equals_its_definition_at_50_digits(u1: float, u2: float) -> None:
    for v, c in random_points(u1, u2, 3000):
        expected = exact_barrier(v, c, u1, u2)
        actual = astuple(barrier(v, c, u1, u2))

        for name, found, true in zip(("v_c1", "gap", "V1", "V1/A", "q"), actual, expected):
            error = abs(found - true)
            assert error <= max(1e-12 * abs(true), 1e-15), (name, v, c, found, true)


@pytest.mark.parametrize(("u1", "u2"), LIMITS)
def test_barrier_pushes_towards_its_minimiser(u1: float, u2: float) -> None:
    for v, c in random_points(u1, u2, 1000):
        b = barrier(v, c, u1, u2)

        assert b.V1 >= 0.0
        assert 0.0 <= b.q <= 1.0
        assert b.V1_by_A * b.gap >= 0.0
        assert abs(b.V1_by_A) <= abs(b.gap) * (1.0 + 1e-12)


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize(("c", "q"), [(0.3, 1.0), (3.0, 0.0), (7.17, None)])
def test_barrier_has_its_limits_at_the_minimiser(c: float, q: float | None, side: float) -> None:
    x = barrier(0.0, c, 1.0, 0.8).v_c1
    b = barrier(side * x, side * c, 1.0, 0.8)

    assert b.v_c1 == side * x
    assert abs(b.V1_by_A) < 1e-16
    assert b.q == pytest.approx(1.0 / (1.0 + (1.0 - x) ** -2) if q is None else q, abs=1e-15)


def test_border_of_the_saturated_regions_is_decided_exactly() -> None:
    u1, u2 = 1.0, 0.5  # 1/delta = 2 and all of these are exact in binary

    assert barrier(0.6, 2.5, u1, u2).v_c1 == 0.5
    assert barrier(0.6, math.nextafter(2.5, 3.0), u1, u2).q > 0.05
    assert barrier(0.5, 2.5, u1, u2).q == 0.0


# -- noise -----------------------------------------------------------------------------------------


def philox4x64(counter: tuple[int, int, int, int], key: tuple[int, int]) -> list[int]:
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
def test_raw_numbers_are_philox_blocks_to_the_bit(seed: int, attempt: int, stream: int) -> None:
    key = noise.key_of(seed)
    raw = noise.raw_blocks(key, 0, 5, stream, attempt).tolist()

    pair = (int(key[0]), int(key[1]))
    assert raw == [philox4x64((k, stream, attempt, 0), pair) for k in range(5)]
    assert noise.raw_blocks(key, 3, 2, stream, attempt).tolist() == raw[3:]


def test_torque_noise_is_standard_normal() -> None:
    drawn = noise.torque_noise(noise.key_of(1), 100_000, Disturbance(std=2.0))

    assert drawn.mean(axis=0) == pytest.approx([0.0, 0.0], abs=0.03)
    assert drawn.std(axis=0) == pytest.approx([2.0, 2.0], rel=0.01)


def test_truncated_noise_redraws_only_what_is_beyond() -> None:
    key = noise.key_of(2)
    free = noise.torque_noise(key, 500, Disturbance(std=1.0))
    held = noise.torque_noise(key, 500, Disturbance(std=1.0, truncate=1.5))

    inside = np.abs(free).max(axis=1) <= 1.5
    assert 0 < inside.sum() < 500
    assert np.array_equal(held[inside], free[inside])
    assert np.abs(held).max() <= 1.5
    assert np.abs(noise.torque_noise(key, 20, Disturbance(1.0, truncate=1e-9))).max() <= 1e-9


# -- references ------------------------------------------------------------------------------------

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
def test_reference_is_feasible_and_its_rates_are_its_derivatives(kind: Any) -> None:
    reference = reference_of(kind)
    h = 1e-5
    for t in np.linspace(0.0123, 119.7, 400):
        here, before, after = reference(t), reference(t - h), reference(t + h)
        slope = [(b - a) / (2.0 * h) for a, b in zip(astuple(before), astuple(after))]

        assert slope[0] == pytest.approx(-here.v1 * math.sin(here.theta), abs=1e-7)
        assert slope[1] == pytest.approx(here.v1 * math.cos(here.theta), abs=1e-7)
        rates = [here.v2, here.v1_dot, here.v2_dot]
        assert slope[2:5] == pytest.approx(rates, abs=1e-6)


def test_circle_is_the_papers() -> None:
    here = reference_of(Circle(radius=2.0, rate=0.1))(7.0)

    assert here.x == 2.0 * math.sin(0.7000000000000001)
    assert here.theta == pytest.approx(0.7 - math.pi / 2.0, abs=1e-15)
    assert astuple(here)[3:] == pytest.approx((0.2, 0.1, 0.0, 0.0), abs=1e-15)


# -- plant, drives, sensor -------------------------------------------------------------------------


def test_plant_without_friction_accelerates_as_newton_says() -> None:
    plant = Plant(Robot(mu=0.0))
    state = (0.0, 0.0, 0.0, 0.0, 0.0)
    for _ in range(1000):
        state = plant.step(state, (1.5, 0.5), 0.001)

    thrust, moment = 2.0 / 0.1, 0.25 * 1.0 / 0.1
    assert state[3] == pytest.approx(thrust / 50.0, rel=1e-12)
    assert state[4] == pytest.approx(moment / 5.4, rel=1e-12)
    assert state[2] == pytest.approx(moment / 5.4 / 2.0, rel=1e-12)


def test_plant_step_converges_with_the_fourth_order() -> None:
    plant = Plant(Robot(mu=0.0))
    start, torque = (0.0, 0.0, 0.3, 0.5, 1.0), (3.0, 1.0)

    def error(steps: int) -> float:
        state = start
        for _ in range(steps):
            state = plant.step(state, torque, 1.0 / steps)
        return math.hypot(state[0] - fine[0], state[1] - fine[1])

    fine = start
    for _ in range(1000):
        fine = plant.step(fine, torque, 0.001)
    assert error(4) / error(8) == pytest.approx(16.0, rel=0.25)


def test_change_holds_from_the_first_plant_step_that_starts_with_it() -> None:
    schedule = plants(Robot(), (Change(t=0.0035, m=60.0), Change(t=0.3, mu=0.2)), Clock())

    assert [first for first, _ in schedule] == [0, 4, 300]
    last = schedule[-1][1].robot
    assert (last.m, last.I, last.mu) == (60.0, 5.4, 0.2)


def test_torque_limit_serves_the_thrust_first() -> None:
    robot, most = Robot(), 2.0 * 5.0 / 0.1

    assert limited_force((30.0, 2.0), 5.0, robot) == (30.0, 2.0)
    assert limited_force((500.0, 2.0), 5.0, robot) == (most, 0.0)
    for force in [(80.0, -40.0), (-10.0, 99.0), (-300.0, 1.0)]:
        torque = wheel_torques(limited_force(force, 5.0, robot), robot)
        assert max(map(abs, torque)) == pytest.approx(5.0, abs=1e-12)


def test_drive_delays_then_lags() -> None:
    drive = actuator.Actuator(Actuator(delay=0.002, lag=0.01), 0.001)
    acting = [drive.advance((1.0, -2.0)) for _ in range(5)]

    keep = math.exp(-0.1)
    expected = [0.0, 0.0, 1.0 - keep, 1.0 - keep**2, 1.0 - keep**3]
    assert [right for right, _ in acting] == pytest.approx(expected, abs=1e-15)
    assert [left for _, left in acting] == pytest.approx([-2.0 * e for e in expected], abs=1e-15)


def test_pose_is_dead_reckoned_between_corrections() -> None:
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


# -- the loop --------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", LAWS)
def test_columns_follow_the_catalogue(law: str) -> None:
    scenario = shortened(load_scenario("paper-simulation"), 0.2)
    columns, monitor = simulate(scenario, law)

    further = {"nn": {"W_norm": 2}, "smc": {"m_hat": 2, "F_hat": 2}}.get(law, {})
    sizes = {signal.name: signal.size for signal in LOG_HEAD} | further
    assert list(columns) == list(sizes)
    for name, size in sizes.items():
        assert columns[name].shape == ((20,) if size == 1 else (20, size)), name
    assert np.array_equal(columns["t"], np.arange(20) * 0.01)
    assert monitor["stopped"] is None


def test_first_row_is_the_start_with_its_known_errors() -> None:
    columns, _ = simulate(shortened(load_scenario("paper-simulation"), 0.01), "mb")

    assert columns["e"][0] == pytest.approx([0.70453, -0.06031, -0.87080], abs=1e-5)
    assert columns["v_c0"][0] == pytest.approx([7.174, -3.020], abs=1e-3)
    assert columns["v_c1"][0] == pytest.approx([0.84207, -1.3], abs=1e-5)
    assert columns["margin"][0] == 1.0


def test_same_seed_same_run_and_another_seed_another() -> None:
    scenario = shortened(load_scenario("paper-simulation"), 0.5)
    first, again, other = (simulate(scenario, "nn", seed)[0] for seed in (3, 3, 4))

    assert all(np.array_equal(first[name], again[name]) for name in first)
    assert not np.array_equal(first["noise_left"], other["noise_left"])


def test_semi_implicit_weights_stay_near_the_explicit_ones() -> None:
    scenario = shortened(load_scenario("paper-simulation-noise-free"), 2.0)
    implicit = GAINS["nn"] | {"integrator": "semi-implicit"}
    columns, _ = simulate_oracle(scenario, "nn", implicit, KINEMATICS, 0)
    explicit, _ = simulate(scenario, "nn")

    assert columns["W_norm"][-1] == pytest.approx(explicit["W_norm"][-1], rel=0.05)
    assert not np.array_equal(columns["W_norm"], explicit["W_norm"])


def test_unstable_gains_end_the_run_with_time_and_axis() -> None:
    scenario = load_scenario("paper-simulation-nominal")
    wild = {"Kp": (210.0, 1e5), "Kd": (0.0, 0.0)}
    columns, monitor = simulate_oracle(scenario, "pid", wild, KINEMATICS, 0)

    when, axis = monitor["stopped"]
    assert (monitor["stop_reason"], axis) == ("diverged", 2)
    assert len(columns["t"]) == math.ceil(when / 0.01 - 1e-9)
    assert np.abs(columns["omega"]).max() < 1e3 <= monitor["max_abs_v"][1]


def test_start_beyond_a_limit_counts_from_time_zero() -> None:
    scenario = shortened(load_scenario("outside-start"), 0.01)
    _, monitor = simulate(scenario, "mb")

    assert monitor["first_violation"] == (0.0, 1)
    assert monitor["violations"] >= 2


def test_progress_is_told_the_share_that_is_done() -> None:
    shares: list[float] = []
    scenario = shortened(load_scenario("paper-simulation"), 4.0)
    simulate_oracle(scenario, "pid", GAINS["pid"], KINEMATICS, 0, shares.append)

    assert shares == [0.25, 0.5, 0.75, 1.0]


def test_a_law_without_a_twin_is_refused_with_the_remedy() -> None:
    with pytest.raises(ArgumentError, match="pid, smc, mb, nn.*native"):
        simulate_oracle(load_scenario("paper-simulation"), "lqr", {}, KINEMATICS, 0)


# -- figures of whole runs -------------------------------------------------------------------------


def ise(columns: dict[str, np.ndarray]) -> float:
    pairs = (("x_d", "x"), ("y_d", "y"), ("theta_d", "theta"))
    return float(sum(((columns[a] - columns[b]) ** 2).sum() for a, b in pairs) * 0.01)


FIGURES = {
    "paper-simulation-nominal": {"pid": 2.34, "smc": 0.425, "mb": 1.02, "nn": 0.822},
    "paper-simulation": {"pid": 4.2, "smc": 0.43, "mb": 1.04, "nn": 0.84},
}


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", FIGURES)
def test_figures_of_the_papers_simulation(name: str, law: str) -> None:
    columns, monitor = simulate(load_scenario(name), law)

    tolerance = 0.005 if name.endswith("nominal") else 0.1
    assert ise(columns) == pytest.approx(FIGURES[name][law], rel=tolerance)
    assert (monitor["violations"] == 0) == (law in ("mb", "nn"))
