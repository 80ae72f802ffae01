"""Effects fed with a motion that wanders: within their bounds, sometimes by nearly all of them."""

import itertools

import casadi as ca
import numpy as np
import pytest

from tests.world.motion import (
    EFFECTS,
    bound_of,
    fed,
    rows,
    scenario,
)
from wmr_ctrl.world.delay import delay_in_periods
from wmr_ctrl.world.encoder import ENCODER
from wmr_ctrl.world.motor import MOTOR, largest_torque, stepped
from wmr_ctrl.world.resistance import RESISTANCE
from wmr_ctrl.world.scenario import load_scenario
from wmr_ctrl.world.slope import SLOPE
from wmr_ctrl.world.wheels import WHEELS

LIMITED = {"actuator.tau_max": 10.0}


def force_of(torque):
    return np.stack((torque.sum(-1), 0.25 * (torque[..., 0] - torque[..., 1])), -1) / 0.1


@pytest.mark.parametrize("changes", [
    {"motor.step": 0.4}, {"motor.dead_zone": 0.3}, {"motor.stall": 11.0, "motor.free": 40.0},
    {"wheels.radius": [0.02, 0.02]}, {"wheels.radius": [0.02, -0.02], "wheels.track": -0.03},
    {"wheels.track": 0.05},
], ids=str)  # fmt: skip
@pytest.mark.slow_but(
    "{'motor.step': 0.4}", "{'motor.dead_zone': 0.3}", "{'motor.stall': 11.0, 'motor.free': 40.0}"
)
def test_a_drive_is_off_by_its_bound_and_sometimes_nearly_by_all_of_it(changes):
    """Torques at the edges of what they may be, wheels at the edges of the limits."""
    effect = MOTOR if next(iter(changes)).startswith("motor") else WHEELS
    system = effect.build(scenario({**LIMITED, **changes}))
    bound = bound_of(effect, {**LIMITED, **changes})
    assert bound.void == ""
    edges = [-10.0, -9.8001, -0.3, -0.19999, 0.0, 0.2, 0.3, 9.8, 10.0]
    speeds = itertools.product((-1.0, 0.0, 1.0), (-1.5, 0.0, 1.5))
    motion = [
        {"tau_right": [a], "tau_left": [b], "v1": [v], "omega": [w]}
        for (v, w), a, b in itertools.product(speeds, edges, edges)
    ]
    told = np.array([[row["tau_right"][0], row["tau_left"][0]] for row in motion])
    off = np.abs(force_of(fed(system, motion)) - force_of(told)).max(axis=0)

    assert (off <= np.array(bound.dbar) + 1e-12).all()
    assert (off >= 0.98 * np.array(bound.dbar)).all()


@pytest.mark.parametrize("window", [0.01, 0.05])
@pytest.mark.parametrize("wheels", [{}, EFFECTS["wheels"]], ids=["believed", "others"])
@pytest.mark.slow_but("believed-0.01", "others-0.05")
def test_an_encoder_is_off_the_mean_by_less_than_its_bound(window, wheels):
    changes = {"encoder.counts": 256, "encoder.window": window, **wheels}
    bound, n = bound_of(ENCODER, changes), round(window / 0.01)
    system, worst = ENCODER.build(scenario(changes)), np.zeros(2)
    rng = np.random.default_rng(11)
    for _ in range(6):
        motion, place = rows(300, rng), np.zeros(2)
        for row in motion:
            row |= {"path": [place[0]], "theta": [place[1]], "skid": [0.0]}
            place = place + 0.01 * rng.choice([-1.0, 1.0], 2) * rng.uniform(0.9, 1, 2) * (1.0, 1.5)
        shown = fed(system, motion)
        true = np.array([[row["path"][0], row["theta"][0]] for row in motion])
        worst = np.maximum(worst, np.abs(shown[n:] - (true[n:] - true[:-n]) / window).max(axis=0))

    assert bound.window == (window, window)
    assert (worst <= bound.nbar).all()
    assert (worst > 0.4 * np.array(bound.nbar)).all()


@pytest.mark.parametrize(
    "radius, track",
    [([0.1, -0.2], 0.3), ([-0.1, 0.15], -0.3), ([0.2, 0.1], 0.0), ([0.0, 0.0], 0.4)],
    ids=str,
)
def test_other_wheels_misstate_the_velocity_by_their_bound_and_by_all_of_it(radius, track):
    """What true wheels turn, converted with r = 0.1 m and l = 0.25 m, over all velocities."""
    wheels = {"wheels.radius": radius, "wheels.track": track}
    with_them, without = (
        bound_of(ENCODER, {"encoder.counts": 1e6, **changes}).nbar for changes in (wheels, {})
    )
    v, omega = np.meshgrid(np.linspace(-1.0, 1.0, 9), np.linspace(-1.5, 1.5, 9))
    sides = [
        (v + side * 0.25 * (1 + track) * omega) / (0.1 * (1 + share))
        for side, share in zip((1, -1), radius, strict=True)
    ]
    shown = 0.1 * (sides[0] + sides[1]) / 2, 0.1 * (sides[0] - sides[1]) / (2 * 0.25)
    worst = [np.abs(shown[0] - v).max(), np.abs(shown[1] - omega).max()]

    assert np.subtract(with_them, without) == pytest.approx(worst, rel=1e-9, abs=1e-12)


def test_the_ground_pulls_and_resists_within_its_bound():
    exact = {"guard.M_max": [50.0, 5.4]}
    slope = {"slope.angle": 0.05, "slope.direction": 1.0, "slope.offset": -0.03, **exact}
    rolling = {"resistance.rolling": [0.01, 0.015], "resistance.viscous": [5.0, 0.2]}
    motion = rows(2000, np.random.default_rng(3), size=3.0)
    pulled = np.abs(fed(SLOPE.build(scenario(slope)), motion)).max(axis=0)
    force = fed(RESISTANCE.build(scenario(rolling)), motion)
    v = np.array([[row["v1"][0], row["omega"][0]] for row in motion])
    driven = (force * np.sign(v)).max(axis=0)
    slope_bound, bound = bound_of(SLOPE, slope).dbar, bound_of(RESISTANCE, rolling).dbar

    assert (pulled <= slope_bound).all()
    assert (pulled > 0.99 * np.array(slope_bound)).all()
    assert (driven <= bound).all()


@pytest.mark.parametrize("plant", [0.001, 0.002, 0.005])
def test_a_delay_is_as_many_plant_steps_as_its_decimals_say(plant):
    """Also where the quotient of the doubles is just below that number, such as 0.043/0.001."""
    steps = [29, 43, 51, 57, 58, 59, 71, 86]
    found = []
    for k in steps:
        late = {"actuator.delay": float(f"{k * plant:.6g}"), "clock.plant": plant}
        drive = load_scenario("paper-simulation", {**late, "clock.control": 10 * plant})
        found.append(delay_in_periods(drive))

    assert found == [divmod(k, 10) for k in steps]
    assert any(int(float(f"{k * plant:.6g}") / plant) != k for k in steps)


@pytest.mark.parametrize("limit, step", [(1.05, 0.3), (10.0, 0.7), (2.0, 0.5)])
def test_steps_of_a_motor_go_beyond_its_limit_by_no_more_than_is_counted(limit, step):
    """By half a step, where the limit is half a step from a whole number of them."""
    chosen = load_scenario("far-start", {"actuator.tau_max": limit, "motor.step": step})
    given = float(stepped(ca.DM(limit), ca.DM(step)))

    assert given <= largest_torque(chosen) * (1 + 1e-12) <= limit + 0.5 * step + 1e-9
    assert (given == pytest.approx(largest_torque(chosen))) is (step == 0.3)
