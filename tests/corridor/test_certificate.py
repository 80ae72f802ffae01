"""Corridors against an adversary on the tests' own loop, and their refusals."""

import re

import numpy as np
import pytest

import wmr_ctrl.theory.corridor as room
from benchmarks.corridor_adversary import farthest
from tests.papers_robot import safe
from tests.tables import cases, changes
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.theory.corridor import find_corridor
from wmr_ctrl.theory.corridor.answer import Corridor, bounds
from wmr_ctrl.world.scenario import load_scenario, override
from wmr_proofs.corridor import asked, stated
from wmr_proofs.corridor.masses import certified
from wmr_proofs.corridor_check.intervals import RefusedError

EXACT_POSE = changes("""
    sensor.pose_period = 0.0
    sensor.pose_noise = 0.0
    sensor.correction = 1.0
""")
QUICK = EXACT_POSE | changes("""
    clock.control = 0.05
    gains.kinematics.k = [12.0, 196.0, 5.0]
    gains.prox = {rho = [24.0, 16.0], wo = 12.0}
""")
CASES = {
    "prox, 10 ms": ("safe-simulation", "prox", {}, 300, 1.3),
    "mb, 10 ms": ("safe-simulation", "mb", {}, 300, 1.3),
    "kanayama, 10 ms": ("safe-simulation", "kanayama", {}, 400, 1.3),
    "prox, 50 ms": ("safe-experiment", "prox", QUICK, 150, 1.3),
}
"""Preset, law, changes, samples that an attack takes, and how tight the corridor is at least."""


@pytest.mark.parametrize("case", CASES)
@pytest.mark.slow_but("prox, 10 ms")
def test_no_adversary_leaves_the_corridor_and_some_come_near(case):
    preset, law, changes, samples, loose = CASES[case]
    scenario = override(load_scenario(preset), changes)
    size = scenario.disturbance.std * scenario.disturbance.truncate

    tube = find_corridor(scenario, law)
    reached = farthest(scenario, law, samples, size)

    assert tube.position / loose <= reached.position <= tube.position
    assert reached.position == pytest.approx(tube.linear, rel=0.03)
    assert np.abs(reached.e[:, 2]).max() <= tube.heading
    assert not reached.clipped
    assert reached.torque < settle(scenario, law).tau_max


@pytest.mark.slow
def test_what_a_start_adds_is_gone_in_the_end_and_the_words_name_it():
    plain = safe()
    tube = find_corridor(override(plain, changes("corridor.start = [0.002, 0.002, 0.02]")), "prox")

    assert "on it, or moved there by up to 2 mm ahead" in tube.sentence
    assert tube.position_late == pytest.approx(find_corridor(plain, "prox").position, rel=3e-3)
    assert tube.position_late < tube.position


@pytest.mark.parametrize("changes", [{}, {"sensor.pose_noise": 1e-5}])
def test_a_start_too_far_off_is_refused_with_the_largest_share_that_closes(changes):
    start = np.array([0.05, 0.05, 0.15])
    scenario = safe({**changes, "corridor.start": start})
    tube = find_corridor(scenario, "prox")

    assert tube.position is None
    told = re.search(r"; it closes from (\S+) % of corridor.start$", tube.sentence)
    assert 0.9 * tube.near <= float(told[1]) / 100 <= tube.near < 1
    for share, closes in ((0.98, True), (1.02, False)):
        nearer = override(scenario, {"corridor.start": share * tube.near * start})
        tube_there = certified(settle(nearer, "prox"), closing=False)
        assert (tube_there.position is not None) == closes


@pytest.mark.slow
def test_of_masses_in_an_interval_each_keeps_within_one_corridor():
    told = changes("""
        guard.M_min = [48.0, 5.2]
        guard.M_max = [52.0, 5.6]
        corridor.cells = 2
    """)
    told |= {"changes": []}
    scenario = safe(told)
    alone = find_corridor(safe(), "prox")
    tube = find_corridor(scenario, "prox")
    believed = changes("model.m = 50.0; model.I = 5.4; model.mu = 0.08")
    corners = [{**believed, "robot.m": m, "robot.I": i} for m in (48.0, 52.0) for i in (5.2, 5.6)]

    assert tube.masses == ((48.0, 52.0), (5.2, 5.6))
    assert tube.position > alone.position
    for corner in corners:
        assert farthest(override(scenario, corner), "prox", 100, 3.0).position <= tube.position


@pytest.mark.parametrize(
    "preset, changed, words",
    cases("""
        paper-simulation  | guard.enabled = true       | disturbance.truncate = inf
        safe-experiment   | sensor.pose_period = 0.2   | corrected in part
        safe-simulation   | reference.kind = lemniscate | circles and lines alone
        robot-10ms        | guard.enabled = true       | the effect encoder
        safe-simulation   | actuator.lag = 0.005       | counts a lag or late velocities
        safe-simulation   | clock.control = 0.2; guard.enabled = false | unstable
        safe-simulation   | slope.angle = 0.01         | depends on the heading
        safe-experiment   | guard.enabled = true | v_c0 (angular) may reach 3.43 of 1.3, which is \
so for the linear loop already | slow
        safe-experiment   | sensor.pose_period = 0; sensor.pose_noise = 0; sensor.correction = 1 | \
may grow as large as what the loop corrects, beyond the 30.4 mm that the linear loop leaves | slow
    """),
)
def test_what_is_not_covered_is_refused_by_name(preset, changed, words):
    tube = find_corridor(override(load_scenario(preset), changes(changed)), "prox")

    assert tube.position is None
    assert words in tube.refused
    assert words in tube.sentence


def test_a_law_that_adapts_is_refused():
    refused = find_corridor(safe(), "smc").refused
    assert "away from their limits" in refused


@pytest.mark.parametrize(
    "whole, changed",
    cases("""
        False | corridor.start = [0.05, 0.05, 0.15]
        True  | reference.kind = lemniscate; clock.duration = 0.5; disturbance.std = 9.0
    """),
)
def test_a_share_that_closes_is_checked_like_a_corridor(whole, changed, monkeypatch):
    scenario = safe("guard.enabled = false; changes = []; actuator.tau_max = inf", changed)
    found = []
    for right in (stated.check, refusing):
        monkeypatch.setattr(stated, "check", right)
        asked._found.cache_clear()
        found.append(find_corridor(scenario, "prox", whole=whole == "True"))

    assert found[0].closes is not None
    assert found[1].closes is None


def refusing(written):
    """A checker that accepts nothing."""
    raise RefusedError("no")


@pytest.mark.slow
def test_where_none_closes_it_says_for_which_share_one_would():
    scenario = override(load_scenario("safe-experiment"), EXACT_POSE)
    tube = find_corridor(scenario, "prox")

    assert "it closes while each wheel is pushed by at most" in tube.sentence
    for share, closed in ((0.9, True), (1.1, False)):
        less = override(scenario, {"disturbance.std": share * tube.closes})
        assert (find_corridor(less, "prox").position is not None) is closed


@pytest.mark.parametrize(
    "less, words",
    [
        pytest.param(
            "corridor.cells = 1",
            "with M = 58.2 kg products of deviations may grow",
            marks=pytest.mark.slow,
        ),
        ("sensor.velocity_window = 0.02", "leave out sensor.velocity_window = 0.02"),
    ],
)
def test_a_refusal_has_numbers_and_says_what_to_change(less, words):
    told = {"guard.enabled": "corridor.cells" in less, **changes(less)}
    tube = find_corridor(safe(told), "prox")

    assert tube.position is None
    assert words in tube.refused


def test_figures_and_words_are_rounded_to_the_safe_side():
    assert bounds(0.0, 0.0, (0.0019999, 0.00109999)) == (
        "velocities to within 0.00199 m/s and 0.00109 rad/s"
    )
    tube = Corridor(
        "prox", position=1e-14, heading=2e-15, position_late=1e-14, share=0.1,
        masses=((45.00000049, 71.50000051), (4.0, 5.0)),
    )  # fmt: skip
    assert {tube.figures[key] for key in ("position", "heading", "position_late")} == {1e-9}
    assert "M is anything from 45.0001 to 71.5 kg" in tube.sentence


def test_what_a_refusal_closes_with_is_the_share_of_all_that_disturbs():
    tube = Corridor("prox", refused="no", closes=0.5, push=2.0, pose=0.02, velocity=(0.004, 0.2))

    assert tube.sentence == (
        "no corridor: no; it closes while each wheel is pushed by at most 1 N m, positions are "
        "measured to within 10 mm, velocities to within 0.002 m/s and 0.1 rad/s"
    )


def test_without_ball_arithmetic_it_is_not_checked(monkeypatch):
    monkeypatch.setattr(room, "is_open", lambda: False)

    assert "NOT_CHECKED" in find_corridor(safe(), "prox").sentence


def test_a_name_instead_of_a_scenario_is_refused():
    with pytest.raises(ArgumentError, match=r"find_corridor: scenario = .* must be Scenario"):
        find_corridor("safe-simulation", "prox")
