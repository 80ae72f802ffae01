"""Filters for bases with dead bands and ramps of wheels, or with a least turning radius."""

import math

import casadi as ca
import numpy as np
import pytest

import wmr_ctrl
from tests.tables import cases, changes
from wmr_ctrl.control.filter import asked as able
from wmr_ctrl.control.filter.gate import GateSettings, gate_system
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.theory.checks import warnings_for
from wmr_ctrl.world.scenario import load_scenario, override

CREATE3 = load_scenario("irobot-create3", {"clock.duration": 10.0})


BANDED = (
    "filter.kind = governor; filter.tau = [0.05, 0.2]; filter.delay = [0, 0.05]; "
    "base.deadband = [0.01, 0.02]; base.accel = [inf, inf]; base.decel = [inf, inf]"
)


@pytest.mark.parametrize(
    "changed, words",
    cases(rf"""
        base.wheel_accel = 0.5       | wheel_accel = 0\.5 m/s2, wheel_decel = inf m/s2: with two
        base.wheel_deadband = 0.03   | may push the base on by 0\.01597.* filter\.d\[1\] = 0\.005
        base.min_radius = 0.4; filter.scale = axes | scale = "axes" .* base\.min_radius = 0\.4 m
        base.min_radius = -0.4       | base\.min_radius = -0\.4 must be at least 0
        base.wheel_deadband = -1     | base\.wheel_deadband = -1 must be at least 0
        base.wheel_decel = 0         | base\.wheel_decel = 0 must be above 0
        {BANDED}                     | may push the base on by 0\.01.* filter\.d\[1\] = 0\.005
    """),
)
def test_what_no_filter_covers_is_refused_with_numbers(changed, words):
    with pytest.raises(ScenarioError, match=words):
        wmr_ctrl.simulate(override(CREATE3, changes(changed)), "kanayama")


def turning(radius, **changes):
    return override(CREATE3, {"base.min_radius": radius, **changes})


def test_a_step_turns_no_tighter_than_the_base():
    step = wmr_ctrl.command_filter(turning(0.4)).step
    assert step((0.0, 0.5)).command == (0.0, 0.0)
    assert "turn-radius" in step((0.0, 0.5)).flags
    tight = step((0.2, -1.0))
    assert tight.command == pytest.approx((0.2, -0.5))
    assert tight.flags == ("turn-radius",)
    assert step((-0.2, 0.4)).command == (-0.2, 0.4)
    assert step((0.2, 0.4)).flags == ()
    for wrong in ((math.nan, 0.1), (0.1, math.nan), (0.1, math.inf)):
        assert step(wrong).command == (0.0, 0.0)
        assert "refused" in step(wrong).flags


@pytest.mark.parametrize("kind", ["clip", "none"])
def test_a_run_turns_no_tighter_than_the_base(kind):
    run = wmr_ctrl.simulate(turning(0.6, **{"filter.kind": kind}), "kanayama")
    sent = np.stack([run["v_command"], run["omega_command"]], axis=1)
    assert (np.abs(sent[:, 1]) * 0.6 <= np.abs(sent[:, 0]) + 1e-12).all()
    free = wmr_ctrl.simulate(turning(0.0, **{"filter.kind": kind}), "kanayama")
    assert (np.abs(free["omega_command"]) * 0.6 > np.abs(free["v_command"]) + 1e-3).any()


def found(scenario):
    return {item.key: str(item) for item in warnings_for(settle(scenario, "kanayama"))}


def test_check_objects_to_a_path_tighter_than_the_base():
    assert "base.min_radius" not in found(turning(0.8))
    assert "radius of 0.8 m" in found(turning(0.81))["base.min_radius"]


@pytest.mark.parametrize(
    "given, sent",
    [((0.4, 0.5), 0.5), ((0.4, 2.0), 0.8), ((-0.4, -2.0), -0.8), ((0.0, 1.0), 0.0)],
)
def test_a_turn_is_no_tighter_than_the_least_radius(given, sent):
    found = ca.evalf(able.turning(ca.SX(given), ca.SX(0.5))).full().ravel()

    assert found == pytest.approx([given[0], sent])


LEAST = changes("base.deadband = [0.03, 0.26]; filter.least = true")
DOCK = {
    "initial.pose": [0.0, 0.0, -math.pi / 2], "clock.duration": 30.0, "metrics.tolerance": 0.02,
    "reference": {"kind": "waypoints", "points": [[0.0, 0.0], [0.6, 0.0], [1.0, 0.1]],
                  "speed": 0.06, "tolerance": 0.05},
}  # fmt: skip


def docked(changes, law, engine="native"):
    run = wmr_ctrl.simulate(override(CREATE3, {**DOCK, **changes}), law, engine=engine)
    away = np.hypot(run["x"][-1] - run["x_d"][-1], run["y"][-1] - run["y_d"][-1])
    return float(away), [item.key for item in run.remarks]


@pytest.mark.slow_but("kanayama")
@pytest.mark.parametrize("law", ["kanayama", "pursuit", "prox"])
def test_a_goal_within_the_dead_band_is_reached(law):
    away, remarks = docked(LEAST, law)
    assert away < 0.01
    assert not {"not-tracked", "goal-not-reached", "dead-band", "filter-holds-back"} & {*remarks}
    if law != "prox":
        assert docked({**LEAST, "filter.least": False}, law)[0] > 0.09
    assert docked(LEAST, law, "numpy")[0] == pytest.approx(away, abs=1e-9)


BANDS = [
    (LEAST, (0.03, 0.26)),
    (changes("base.deadband = [0.0, 0.26]"), (0.0, 0.26)),
    (changes("base.wheel_deadband = 0.03; filter.d = [0.02, 0.2]"), (0.03, 0.03)),
]


@pytest.mark.parametrize("band, size", BANDS)
def test_what_is_sent_acts_and_is_in_the_mean_what_was_asked(band, size):
    step = wmr_ctrl.command_filter(override(CREATE3, {**band, "filter.least": True})).step
    l, rng = CREATE3.robot.l, np.random.default_rng(6)
    parts = np.array([[1.0, l], [1.0, -l]]) if "base.wheel_deadband" in band else np.eye(2)
    asked = np.repeat(rng.uniform(-1, 1, (40, 2)) * (0.06, 0.3), rng.integers(1, 60, 40), axis=0)
    sent = np.array([step(tuple(u)).command for u in asked])
    asked, sent = asked @ parts.T, sent @ parts.T
    assert ((np.abs(sent) >= np.multiply(size, 1 - 1e-12)) | (np.abs(sent) < 1e-12)).all()
    small = np.abs(asked) < size
    assert sent[~small] == pytest.approx(asked[~small], abs=1e-12)
    for axis in (0, 1):
        runs = np.split(np.arange(len(asked)), np.flatnonzero(np.diff(small[:, axis])) + 1)
        for rows in runs:
            drift = np.cumsum((asked - sent)[rows, axis])
            assert np.abs(drift).max() <= size[axis] * (1 + 1e-6)
    assert step((0.0, 0.0)).command == (0.0, 0.0)


def test_the_least_command_is_sent_only_where_the_filter_admits_it():
    weak = override(
        CREATE3, LEAST | changes("limits.v_u1 = [0.306, 0.2]; limits.v_u2 = [0.2, 0.15]")
    )
    step = wmr_ctrl.command_filter(weak).step
    sent = np.array([step((0.0, 0.1)).command[1] for _ in range(50)])
    assert 0 < sent.max() <= (0.2 - 0.05) / 1.05
    assert "limited" in {flag for _ in range(9) for flag in step((0.0, 0.1)).flags}


def test_making_up_for_no_dead_band_is_refused():
    with pytest.raises(ScenarioError, match=r"base\.deadband and base\.wheel_deadband are 0"):
        wmr_ctrl.command_filter(override(CREATE3, {"filter.least": True}))
    with pytest.raises(ScenarioError, match=r"filter\.least: a gate ramps commands"):
        gate_system(override(CREATE3, LEAST), GateSettings())
