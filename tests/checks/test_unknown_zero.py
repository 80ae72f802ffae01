"""Bounds of size 0 are named where something is guaranteed, and change no verdict."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from tests.papers_robot import preset
from wmr_ctrl import simulate
from wmr_ctrl.cli.check_sentences import promise
from wmr_ctrl.cli.root import root
from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.checks import warnings_for
from wmr_ctrl.theory.checks.unknown_zero import (
    COARSE,
    KEY,
    exactness,
    finest,
    is_guarded,
    promise_of_run,
    unknown_zero,
)
from wmr_ctrl.world.scenario import load_scenario

PUSHED, MEASURED = "nothing pushes the robot", "measured exactly"
TORQUE, VELOCITY = "paper-simulation-nominal", "turtlebot3-burger"


def draws(seed):
    """Yield presets and changes that set bounds, about 40 % of them to 0, on one axis or both."""
    rng = np.random.default_rng(seed)

    def pair(most):
        return [float(x) for x in rng.uniform(0.1, most, 2) * (rng.random(2) > 0.4)]

    for _ in range(7):
        still = {"disturbance.std": 0.0, "guard.enabled": bool(rng.random() < 0.7)}
        yield TORQUE, still | {"guard.dbar": pair(3.0), "guard.nbar": pair(0.2)}
        kind = str(rng.choice(["clip", "governor"]))
        yield VELOCITY, {"filter.d": pair(0.2), "filter.odometry": pair(0.2), "filter.kind": kind,
                         "filter.trust": True}  # fmt: skip


@pytest.mark.parametrize("seed", range(2))
def test_headlines_name_exactly_the_drawn_bounds_that_are_zero(seed):
    for name, stated in draws(seed):
        setup = settle(load_scenario(name, stated), "kanayama")
        if setup.takes_velocity:
            heard = stated["filter.kind"] == "governor"
            assert_named(setup, setup.scenario.filter.d, setup.scenario.filter.odometry * heard)
        elif is_guarded(setup):
            assert_named(setup, setup.scenario.guard.dbar, setup.scenario.guard.nbar)
        else:
            assert_named(setup, setup.bound.dbar, setup.bound.nbar)


def assert_named(setup, pushed, error):
    """Assert that the headline and a warning without objection each name a bound of 0."""
    said = promise(setup)
    zeros = [bound is not None and 0 in bound for bound in (pushed, error)]

    assert [PUSHED in said, MEASURED in said] == zeros
    warning = unknown_zero(setup)
    assert (warning is not None) is (any(zeros) and is_guarded(setup))
    if warning is not None:
        assert not warning.objects
        assert exactness(setup) in warning.sentence
    assert KEY not in [item.key for item in warnings_for(setup)]


def test_stated_zeros_count_like_derived_ones():
    on = {"guard.enabled": True, "disturbance.std": 0.0}
    stated = {"guard.dbar": [0.0, 0.0], "guard.nbar": [0.0, 0.0]}
    derived, same = (settle(load_scenario(TORQUE, on | more), "mb") for more in ({}, stated))

    assert promise(derived) == promise(same)
    assert f"guaranteed while {PUSHED} and its speed is {MEASURED}" in promise(derived)
    assert unknown_zero(derived) == unknown_zero(same)


PI = """
    filter.kind = clip; filter.inertia = [0.003, 0.005]; filter.kp = [5.0, 20.0]
    filter.ki = [1.0, 5.0]; filter.trust = true; filter.d = [0.0, 0.0]
"""


def test_the_push_of_a_pi_loop_is_not_its_command_error():
    own = "filter.loop = pi; filter.gain = [1, 1]; filter.mass = [0.9, 1.1]"
    said = promise(settle(preset(VELOCITY, PI, own, "filter.push = [0.1, 0.01]"), "kanayama"))

    assert PUSHED not in said
    assert "its commands act exactly" in said


def test_each_axis_names_the_zero_of_its_own_loop():
    own = (
        "filter.loop = first-order, pi; filter.gain = [[0.9, 1.1], [1, 1]]; filter.push = [0, 0.01]"
    )
    said = promise(settle(preset(VELOCITY, PI, own), "kanayama"))

    assert "nothing pushes the robot forwards or backwards" in said
    assert "its commands of omega act exactly" in said


def checked(name, *options):
    result = CliRunner().invoke(root, ["check", name, "--law", "kanayama", "--json", *options])
    found = json.loads(result.stdout)
    assert isinstance(found, dict)
    return found


def test_json_has_the_bounds_and_one_warning_for_all_laws():
    stated = ("--guard", "--set", "guard.dbar=1,0.5", "--set", "clock.duration=1")
    silent, told = (checked(TORQUE, *stated, *more) for more in (
        ("--set", "guard.nbar=0.1,0.1"), ()))  # fmt: skip
    (warning,) = (item for item in told["warnings"] if item["key"] == KEY)

    assert told["bounds"] == {"dbar": [1.0, 0.5], "nbar": [0.0, 0.0]}
    assert warning["law"] is None
    assert "guard.nbar = [m/s, rad/s]" in warning["text"]
    assert KEY not in [item["key"] for item in silent["warnings"]]
    assert told["verdict"] == silent["verdict"]


def test_runs_report_what_is_exact_without_a_remark():
    short = {"clock.duration": 0.2, "metrics.rms_from": 0.0, "disturbance.std": 0.0}
    plain, guarded = (
        simulate(load_scenario(TORQUE, short | {"guard.enabled": on}), "mb", engine="numpy")
        for on in (False, True)
    )

    assert promise_of_run(plain).startswith(f"In this scenario {PUSHED} and")
    assert promise_of_run(guarded).startswith(f"The limits are guaranteed while {PUSHED} and")
    assert KEY not in [item.key for item in guarded.remarks]


def test_only_disturbed_loops_get_digits_finer_than_a_tape_measure():
    still = load_scenario(TORQUE, {"disturbance.std": 0.0})

    assert finest(still) == COARSE
    for noise in ({"disturbance.std": 0.1}, {"sensor.pose_noise": 1e-3}, {"gyro.enabled": True,
                  "gyro.noise": 1e-3}):  # fmt: skip
        assert finest(load_scenario(TORQUE, {"disturbance.std": 0.0} | noise)) < COARSE
