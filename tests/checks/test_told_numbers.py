"""Numbers in the warnings of checks, against the tests' own calculations."""

import math
import re
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.corridor_adversary import Attacked
from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.checks import stability
from wmr_ctrl.theory.checks.outlook import CheckVerdict, verdict
from wmr_ctrl.theory.checks.radius import largest_radius, operating_points
from wmr_ctrl.theory.checks.sending import loop_of
from wmr_ctrl.theory.checks.stable_ranges import shortest_tried
from wmr_ctrl.theory.checks.surroundings import oldest_shown
from wmr_ctrl.world.phases import largest_friction
from wmr_ctrl.world.scenario import load_scenario, override


@pytest.mark.parametrize("tolerance, objects", [(0.001, True), (1.0, False)])
def test_a_wrong_friction_is_objected_to_where_it_leads_beyond_the_tolerance(
    told, tolerance, objects
):
    wrong = {"model.mu": 0.06, "metrics.tolerance": tolerance}
    (warning,) = [item for item in told("mb", wrong, key="model") if "Friction is" in str(item)]

    assert warning.objects is objects


def test_the_period_that_the_kink_admits_is_that_of_the_faster_axis(told):
    gains = {"gains.mb.rho": [40.0, 10.0], "clock.control": 0.1}
    kinks = [item.sentence for item in told("mb", gains, key="clock.control")]
    (kink,) = [text for text in kinks if "where the barrier begins" in text]

    assert "0.05 s for v1 and 0.2 s for omega" in kink
    assert "Choose 0.025 s or less" in kink


def test_the_largest_delay_is_one_at_which_the_loop_is_on_the_edge():
    """The loop becomes unstable at the reported delay, of which the observer ignores 4 ms."""
    scenario = load_scenario("safe-simulation", {"actuator.unmodelled_delay": 0.004})
    scenario = override(scenario, {"guard.enabled": False})
    known = 1e3 * (stability(scenario, "prox").delay - 0.004)
    near = [
        largest_radius(loop_of(settle(override(scenario, {"actuator.delay": delay}), "prox")), 0.01)
        for delay in (1e-3 * math.floor(known), 1e-3 * math.ceil(known))
    ]

    assert near[0] < 1 < near[1]


def test_a_law_that_predicts_leaves_so_many_commands_under_way_at_most():
    early = {"gains.prox.delay": 0.08, "guard.enabled": False, "actuator.delay": 0.04}
    setup = settle(load_scenario("safe-simulation", early), "prox")

    assert shortest_tried(loop_of(setup)) == pytest.approx(0.08 / 40)


def test_a_drive_counts_with_its_slowest_lag():
    radii = [
        largest_radius(loop_of(settle(load_scenario("paper-simulation", lag), "pid")), 0.01)
        for lag in (
            {"actuator.lag": 0.06},
            {"actuator.lag": 0.04, "actuator.lag_spread": 0.5},
            {"actuator.lag": 0.04},
        )
    ]

    assert radii[0] == pytest.approx(radii[1], abs=1e-12)
    assert abs(radii[0] - radii[2]) > 1e-9


def test_the_oldest_velocity_is_as_old_as_its_age_and_its_window():
    late = {"sensor.velocity_age": 0.01, "sensor.velocity_window": 0.02}

    assert oldest_shown(settle(load_scenario("paper-simulation", late), "pid")) == (
        pytest.approx(0.03)
    )


def test_points_of_a_reference_lie_within_its_cycle():
    """If spread over a run of eight cycles, all points would be at one place of the reference."""
    eight = {"reference.kind": "lemniscate", "reference.rate": 2 * math.pi / 10}
    points = operating_points(load_scenario("paper-simulation", eight))

    assert np.ptp(points, axis=0)[1] > 0.1


@pytest.mark.parametrize(
    "key, said",
    [("chatter", CheckVerdict.OBJECTED), ("exact-pose", CheckVerdict.IN_PART),
     ("objected", CheckVerdict.HOLDS)],
)  # fmt: skip
def test_what_a_run_shows_counts_in_the_verdict(key, said):
    assert verdict([], SimpleNamespace(remarks=[SimpleNamespace(key=key)])) is said


@pytest.mark.parametrize("rare", [0.0, 0.04])
def test_torques_that_noise_makes_are_the_laws_answers_to_it(told, rare):
    """The reported torque noise equals the law's response to single measurement errors.

    The response is taken on the reference, at the first sample of the tests' own loop.
    """
    noise = {"sensor.velocity_noise": [0.05, 0.2], "sensor.pose_noise": 0.02,
             "sensor.pose_period": rare, "clock.duration": 0.05}  # fmt: skip
    (warning,) = told("mb", noise, key="gains.mb")
    change = float(re.search(r"by about ([\d.]+) N m RMS", warning.sentence)[1])

    scenario, found = load_scenario("paper-simulation-nominal", noise), []
    for off in np.vstack((np.zeros(4), 1e-7 * np.eye(4))):
        errors = np.zeros((5, 4))
        errors[0] = off
        still = np.zeros((5, 2))
        loop = Attacked(scenario, "mb", still, pose=errors[:, :2], velocity=errors[:, 2:])
        loop._sample(0)
        columns = loop.log.columns()
        found.append((columns["tau_right"][0], columns["tau_left"][0]))
    slopes = (np.array(found[1:]) - found[0]) / 1e-7
    fewer = math.sqrt(max(1.0, rare / scenario.clock.control))
    sizes = np.array([0.02 / fewer, 0.02 / fewer, 0.05, 0.2]) / math.sqrt(3)
    most = math.sqrt(2) * math.sqrt(((slopes * sizes[:, None]) ** 2).sum(axis=0).mean())

    assert change == pytest.approx(most, rel=5e-3)


def test_a_noisy_rate_of_turn_swings_the_torques_by_its_own_inertia_and_arm(told):
    loud = {"sensor.velocity_noise": [0.0, 0.3], "guard.enabled": True, "disturbance.std": 0.0}
    (warning,) = told("kanayama", loud, scenario="safe-simulation", key="guard.alpha")
    swing = float(re.search(r"swing by about ([\d.]+) N m", warning.sentence)[1])
    scenario = load_scenario("safe-simulation", loud)
    robot, guard = scenario.robot, settle(scenario, "kanayama").guard
    inertia, alpha = guard.M_min[1], guard.alpha

    assert f"more than {largest_friction(scenario) * robot.r / 2:.3g} N m" in warning.sentence
    assert swing == pytest.approx(4 * 0.3 * inertia * alpha * robot.r / (2 * robot.l), rel=5e-3)
