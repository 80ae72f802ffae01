"""The linear loop of a base that takes velocities, against its compiled runs."""

from itertools import product

import numpy as np
import pytest

from tests.corridor.further import EXACT, QUICK
from tests.papers_robot import preset
from wmr_ctrl.api import simulate
from wmr_ctrl.cli.check_sentences import stable
from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.checks import warnings_for
from wmr_ctrl.theory.checks.radius import largest_radius
from wmr_ctrl.theory.checks.sample_time import sample_time
from wmr_ctrl.theory.checks.sending import loop_of
from wmr_ctrl.theory.checks.stable_ranges import (
    Stability,
    largest_period,
    stability,
    stable_delays,
    stable_masses,
)
from wmr_ctrl.theory.checks.surroundings import IDLE, lost_samples, rounded_effects
from wmr_ctrl.world.model.kinematics import error_rotation
from wmr_ctrl.world.references import sample
from wmr_ctrl.world.scenario import load_scenario, override

SMALL, SAMPLES = 1e-5, 80
AWAY = np.array([1.0, -0.5, 0.8])
PI = "base.loop = pi; base.kp = 10.0; base.ki = 30.0"
STANDS = "reference.rate = 0.0"
BASES = {
    "first-order": "",
    "pi": PI,
    "late": "base.delay = 0.13",
    "late pi": f"{PI}; base.delay = 0.07",
    "late, standing": f"base.delay = 0.085; {STANDS}",
    "late by a period, standing": f"base.delay = 0.05; {STANDS}",
    "ramps": "base.accel = [1.0, 3.0]; base.jerk = [50.0, 200.0]",
    "slower than believed": "base.tau = [0.3, 0.2]; base.tau_believed = [0.1, 0.1]",
}
FREE = """
    filter.kind = none; robot.mu = 0.0; model.mu = 0.0; base.delay = 0.0; clock.duration = 4.0
"""


def moving(changed):
    """An exact Burger without delay, friction, filter; it starts on its circle, at its speed."""
    scenario = preset("turtlebot3-burger", EXACT, QUICK, FREE, changed)
    at = sample(scenario, np.zeros(1))[0]
    start = {"initial.pose": at[:3].tolist(), "initial.velocity": at[3:5].tolist()}
    return override(scenario, start)


def off(scenario, law, away):
    """Tracking error and velocity (N, 5) of a run that starts at a distance from the reference."""
    start = (np.array(scenario.initial.pose) + away * AWAY).tolist()
    run = simulate(scenario, law, overrides={"initial.pose": start})
    return np.column_stack((run["e"], run["v1"], run["omega"]))


@pytest.mark.parametrize(
    "law, base",
    [
        *product(("pid", "mb", "prox", "pursuit"), ("first-order", "pi", "slower than believed")),
        *product(("pid", "mb", "prox"), ("late, standing", "late by a period, standing")),
    ],
)
def test_a_small_displacement_follows_the_matrices(law, base):
    """The comparison uses differences of compiled runs, without derivatives.

    Commands in transit at the start are those of a base at rest.
    """
    scenario = moving(BASES[base])
    seen = (off(scenario, law, SMALL) - off(scenario, law, -SMALL)) / (2 * SMALL)
    loop = loop_of(settle(scenario, law))
    at = loop.on_reference(sample(scenario, np.zeros(1))[0][3:5])
    first, then = (loop.closed(at, 0.05, sample=k) for k in (0, None))
    x, rows = np.concatenate((seen[0], np.zeros(len(then) - 5))), []
    for k in range(SAMPLES):
        rows.append(x[:5])
        x = (then if k else first) @ x

    assert np.array(rows) == pytest.approx(seen, abs=1e-6)


@pytest.mark.parametrize("law", ["mb", "kanayama"])
def test_a_displacement_from_a_rest_beside_the_reference_follows_the_matrices(law):
    """The gains of the base are not 1, so the loop does not rest on its reference."""
    scenario, desired = moving("base.gain = [1.3, 0.8]"), sample(moving(""), np.zeros(1))[0]
    loop = loop_of(settle(scenario, law))
    at = loop.resting(desired[3:5], 0.0, 0.05)
    assert np.abs(at.e).max() > 1e-3
    theta = desired[2] - at.e[2]
    place = desired[:2] - (np.asarray(error_rotation(theta)).T @ at.e)[:2]
    start = {"initial.pose": [*place, theta], "initial.velocity": [*at.v]}
    rests = override(scenario, start)
    seen = (off(rests, law, SMALL) - off(rests, law, -SMALL)) / (2 * SMALL)
    matrix = loop.closed(at, 0.05)
    x, rows = np.concatenate((seen[0], np.zeros(len(matrix) - 5))), []
    for _ in range(SAMPLES):
        rows.append(x[:5])
        x = matrix @ x

    assert off(rests, law, 0.0) == pytest.approx(np.tile(at.s, (SAMPLES, 1)), abs=1e-9)
    assert np.array(rows) == pytest.approx(seen, abs=1e-6)


@pytest.mark.parametrize(
    "law, base",
    [("mb", "first-order"), ("prox", "late"), ("kanayama", "ramps"), ("prox", "late pi")],
)
@pytest.mark.slow_but("mb-first-order")
def test_runs_settle_at_nine_tenths_of_the_longest_period_and_cycle_beyond(law, base):
    scenario = moving(BASES[base])
    limit = largest_period(loop_of(settle(scenario, law)))
    for share in (0.9, 1.1):
        period = round(share * limit, 3)
        clock = {"clock.control": period, "clock.duration": 400 * period}
        end = np.abs(off(override(scenario, clock), law, SMALL)[-40:, :3]).max()

        assert end < 1e-6 if share < 1 else end > 1e-3


@pytest.mark.slow
def test_no_period_is_stable_over_which_the_base_stops_between_two_commands():
    scenario = moving({"base.timeout": 0.1})
    longer = override(scenario, {"clock.control": 0.2, "clock.duration": 80.0})
    (objection,) = (str(item) for item in warnings_for(settle(longer, "prox")) if item.objects)

    assert largest_period(loop_of(settle(scenario, "prox"))) == pytest.approx(0.1, rel=2e-6)
    assert largest_period(loop_of(settle(moving({}), "prox"))) > 0.2
    assert objection.startswith("clock.control = 0.2 s is longer than base.timeout = 0.1 s")
    words = stable(stability(scenario, "prox"), 0.05)
    assert "up to clock.control = 0.1 s, beyond which the base stops between commands" in words


@pytest.mark.slow
def test_a_base_so_weak_that_its_robot_stays_behind_has_no_number():
    """Pure pursuit commands the reference's speed: at half of it the distance grows for ever."""
    weak = moving({"base.gain": [0.5, 0.5], "clock.duration": 60.0})
    run = simulate(weak, "pursuit")
    (told,) = sample_time(loop_of(settle(weak, "pursuit")))

    assert np.hypot(*run["e"][-1][:2]) > 0.5
    assert told.key == "base.gain"
    assert stability(weak, "pursuit").period == 0
    assert "no rest near the reference" in stable(stability(weak, "pursuit"), 0.05)


def test_a_constant_integral_stays_zero_at_the_resting_point():
    """Friction leaves the robot behind if base.ki = 0, and the integral of the base stays 0."""
    proportional = moving({"base.loop": "pi", "base.kp": 10.0, "base.ki": 0.0, "robot.mu": 0.02})
    run = simulate(proportional, "pid", overrides={"clock.duration": 40.0})
    desired = sample(proportional, np.zeros(1))[0][3:5]
    at = loop_of(settle(proportional, "pid")).resting(desired, 0.0, 0.05)

    assert at.e[0] > 1e-3
    assert run["e"][-1] == pytest.approx(at.e, abs=1e-6)


def test_the_resting_point_does_not_depend_on_the_period():
    """At 2 m/s2 a command changes by 1 mm/s in half a millisecond."""
    scenario = moving({"base.gain": [0.75, 1.0]})
    loop, desired = loop_of(settle(scenario, "kanayama")), sample(scenario, np.zeros(1))[0][3:5]
    short, long = (loop.resting(desired, 0.0, period) for period in (0.0005, 0.05))

    assert short.s == pytest.approx(long.s, abs=1e-9)
    assert stability(scenario, "kanayama").shortest == 0


def test_a_filter_that_clips_the_reference_is_named():
    """A weak base needs 0.16 m/s / gain, and the clip passes (0.22 - 0.005) / 1.05 m/s."""
    clip = {"filter.kind": "clip", "filter.gain": [0.7, 1.05]}
    told = [stability(moving({**clip, "base.gain": [gain, 1.0]}), "pid") for gain in (0.77, 0.8)]

    assert ["filter" in " ".join(item.remarks) for item in told] == [True, False]
    assert "may end elsewhere" in stable(told[0], 0.05)


@pytest.mark.slow
def test_a_firmware_that_clips_the_reference_is_named():
    """The outer wheel of this circle turns at (0.16 + 0.08 * 0.2) / 0.033 = 5.33 rad/s."""
    told = [stability(moving({"base.w_max": w}), "kanayama").remarks for w in (5.3, 5.4)]

    assert ["base.w_max" in " ".join(remarks) for remarks in told] == [True, False]


def test_the_least_stable_delay_is_reported():
    """The least stable delay is reported for laws that predict over commands in transit."""
    words = Stability(0.0, 0.3, 0.2, None, 1e-4, least_delay=0.1)

    assert words.delay_words == "for a delay of 0.1 to 0.2 s"
    assert stable_delays(loop_of(settle(moving({}), "kanayama")))[0] == 0.0


def test_a_loop_that_knows_its_mass_is_the_same_with_every_mass():
    radii = [largest_radius(loop_of(settle(moving({"robot.m": m}), "mb")), 0.05) for m in (1, 3)]

    assert radii[0] == pytest.approx(radii[1], abs=1e-12)
    assert stable_masses(loop_of(settle(moving({}), "mb"))) == (1 / 20, 20.0)


def test_saturation_and_losses_are_left_out_and_reported():
    cut = {"base.accel": [1.0, 3.0], "base.w_max": 8.0, "actuator.tau_max": 1.0, "base.losses": 2,
           "sensor.velocity_losses": 1}  # fmt: skip
    radii = [largest_radius(loop_of(settle(moving(own), "mb")), 0.05) for own in ({}, cut)]

    assert radii[0] == radii[1]
    assert lost_samples(moving(cut)) == (
        "as if nothing were lost, though velocities up to 1 in a row and commands up to 2 in a row "
        "may be"
    )
    assert lost_samples(moving({})) == ""
    dead = override(moving(cut), {"base.deadband": [0.0, 0.1], "base.quantum": [0.01, 0.0]})
    assert rounded_effects(dead) == (
        "as if there were no rounding in [base] and as if base.deadband let every command pass"
    )
    assert override(moving(cut), IDLE).base.losses == 0


@pytest.mark.parametrize("preset", ["turtlebot3-burger", "safe-simulation"])
@pytest.mark.parametrize("law", ["kanayama", "pursuit"])
def test_laws_that_only_drive_forwards_get_no_advice_on_gains(law, preset):
    back = load_scenario(preset, {"reference.rate": -0.1})
    (told,) = sample_time(loop_of(settle(back, law)))

    assert told.key == "reference"
    assert "v1_d of this one falls to" in told.sentence
    assert not list(sample_time(loop_of(settle(load_scenario(preset), law))))
