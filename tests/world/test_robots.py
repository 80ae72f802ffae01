"""Robots as one has them: their presets keep the limit behind the guard, and leave it without."""

from __future__ import annotations

import pytest

from tests.matrix import quick
from wmr_ctrl.api import scenario_of, simulate
from wmr_ctrl.campaign.comparison import BASES, FACTORS, OUR_LAWS, overrides_of
from wmr_ctrl.control.setup import settle
from wmr_ctrl.laws.registry import NAMES
from wmr_ctrl.world.encoder import ENCODER
from wmr_ctrl.world.gyro import GYRO
from wmr_ctrl.world.jitter import JITTER
from wmr_ctrl.world.lag import LAG
from wmr_ctrl.world.wheels import WHEELS

ROBOTS = ("robot-10ms", "robot-100ms")
FACTOR = "as a robot has it"
UNSEEN = 7401
"""A seed that no gain was chosen with."""


@pytest.mark.parametrize("name", ROBOTS)
def test_a_robot_is_complete_and_guarded(name):
    setup = settle(scenario_of(name), "nn")

    assert {ENCODER, GYRO, JITTER, LAG, WHEELS} <= set(setup.effects)
    assert setup.guard.enabled
    assert setup.bound.void == ""


@pytest.mark.parametrize("law", quick(NAMES, "nn"))
@pytest.mark.parametrize("name", ROBOTS)
def test_it_tracks_inside_the_limit(name, law):
    run = simulate(name, law, seed=UNSEEN)

    assert run.monitor.violations == 0
    assert run.outcome.value == "completed"


def test_without_guard_the_slow_robot_leaves_the_limit():
    """With the paper's gains: what the guard is for, and that these robots do try it."""
    changes = overrides_of("100 ms", FACTOR)

    assert simulate("paper-simulation", "mb", seed=UNSEEN, overrides=changes).monitor.violations > 0


@pytest.mark.slow
@pytest.mark.parametrize("base", BASES)
def test_guarded_laws_of_the_comparison_keep_it(base):
    assert FACTOR in FACTORS
    for law in OUR_LAWS:
        changes = overrides_of(base, FACTOR)
        run = simulate("paper-simulation", law, seed=UNSEEN, guard=True, overrides=changes)
        assert run.monitor.violations == 0, law


@pytest.mark.slow
def test_check_has_nothing_against_the_fast_robot_in_what_it_shows():
    for law in NAMES:
        assert simulate("robot-10ms", law).remarks == (), law


@pytest.mark.slow
def test_nor_against_the_slow_one_with_the_laws_that_it_is_for():
    for law in set(NAMES) - {"pid"}:
        assert simulate("robot-100ms", law).remarks == (), law
    assert [item.key for item in simulate("robot-100ms", "pid").remarks] == ["not-tracked"]
