"""Bounds stated by effects, against numbers by hand; the ledger proves that motions keep them."""

import math

import casadi as ca
import pytest

from tests.tables import changes
from tests.world.motion import (
    bound_of,
)
from wmr_ctrl.world.delay import delay_in_periods
from wmr_ctrl.world.encoder import ENCODER
from wmr_ctrl.world.motor import MOTOR, largest_torque, stepped
from wmr_ctrl.world.resistance import RESISTANCE
from wmr_ctrl.world.scenario import load_scenario
from wmr_ctrl.world.slope import SLOPE
from wmr_ctrl.world.wheels import WHEELS

LIMITED = {"actuator.tau_max": 10.0, "guard.M_max": [50.0, 5.4]}
COUNT = 2 * math.pi * 0.1 / 256 / 0.05
"""One count a window at the rim of a wheel [m/s]."""
SLIDES = 50.0 * 9.81 * math.sin(0.05)
ROLLS = 0.005 * 50.0 * 9.81 / 2


@pytest.mark.parametrize("effect, text, dbar", [
    (MOTOR, "motor.step = 0.4", (4.0, 1.0)),
    (MOTOR, "motor.dead_zone = 0.3", (6.0, 1.5)),
    # The line leaves 7.219 N m and 9.281 N m at the rims of 1 m/s and 1.5 rad/s.
    (MOTOR, "motor.stall = 11.0; motor.free = 40.0", (35.0, 6.953125)),
    (WHEELS, "wheels.radius = [0.02, 0.02]", (200 * (1 - 1 / 1.02), 50 * (1 - 1 / 1.02))),
    (WHEELS, "wheels.radius = [0.02, -0.02]; wheels.track = -0.03", (4.0016, 1.48059)),
    (WHEELS, "wheels.track = 0.05", (0.0, 2.5)),
    (SLOPE, "slope.angle = 0.05; slope.direction = 1.0; slope.offset = -0.03",
     (SLIDES, 0.03 * SLIDES)),
    (RESISTANCE, "resistance.rolling = [0.01, 0.015]; resistance.viscous = [5.0, 0.2]",
     (ROLLS, 0.25 * ROLLS)),
])  # fmt: skip
def test_force_bounds_equal_numbers_by_hand(effect, text, dbar):
    """Torques up to 10 N m at wheels of 0.1 m, 0.25 m from the middle, and 50 kg."""
    bound = bound_of(effect, {**LIMITED, **changes(text)})

    assert bound.dbar == pytest.approx(dbar, rel=1e-5)
    assert bound.void == ""


@pytest.mark.parametrize("text, nbar", [
    ("encoder.counts = 256", (COUNT, COUNT / 0.25)),
    # Speeds of other wheels, converted with the numbers of the believed ones.
    ("wheels.radius = [0.1, -0.2]; wheels.track = 0.3", (0.162642, 1.286932)),
    ("wheels.radius = [-0.1, 0.15]; wheels.track = -0.3", (0.041365, 0.943237)),
    ("wheels.radius = [0.2, 0.1]", (0.142992, 0.344697)),
    ("wheels.track = 0.4", (0.0, 0.6)),
])  # fmt: skip
def test_encoder_bounds_equal_numbers_by_hand(text, nbar):
    finest = "encoder.counts = 1e9; encoder.window = 0.05"
    bound = bound_of(ENCODER, changes(f"{finest}; {text}"))

    assert bound.nbar == pytest.approx(nbar, rel=1e-5, abs=1e-6)
    assert bound.window == (0.05, 0.05)


@pytest.mark.parametrize("plant", [0.001, 0.002, 0.005])
def test_a_delay_is_as_many_plant_steps_as_its_decimals_say(plant):
    """Also if the quotient of the doubles is just below that number, such as 0.043/0.001."""
    steps = [29, 43, 51, 57, 58, 59, 71, 86]
    found = []
    for k in steps:
        late = {"actuator.delay": float(f"{k * plant:.6g}"), "clock.plant": plant}
        drive = load_scenario("paper-simulation", {**late, "clock.control": 10 * plant})
        found.append(delay_in_periods(drive))

    assert found == [divmod(k, 10) for k in steps]
    assert any(int(float(f"{k * plant:.6g}") / plant) != k for k in steps)


@pytest.mark.parametrize("limit, step", [(1.05, 0.3), (10.0, 0.7), (2.0, 0.5)])
def test_motor_steps_exceed_the_torque_limit_within_their_bound(limit, step):
    """Motor steps exceed the torque limit by half a step at most.

    The bound is reached if the limit is half a step away from a multiple of the step.
    """
    chosen = load_scenario("far-start", {"actuator.tau_max": limit, "motor.step": step})
    given = float(stepped(ca.DM(limit), ca.DM(step)))

    assert given <= largest_torque(chosen) * (1 + 1e-12) <= limit + 0.5 * step + 1e-9
    assert (given == pytest.approx(largest_torque(chosen))) is (step == 0.3)
