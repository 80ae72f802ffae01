"""The corridor behind drives with jitter, against an adversary that chooses when commands act."""

import numpy as np
import pytest

from benchmarks.corridor_late import farthest_held, farthest_jittered
from tests.corridor.further import GUARDED, simulated
from wmr_ctrl.theory.corridor import find_corridor


@pytest.mark.slow
def test_no_adversary_leaves_it_whenever_commands_act():
    tube = find_corridor(simulated("actuator.jitter = 0.002"), "prox")
    within, beyond = (
        farthest_jittered(simulated(), "prox", 250, 0.3, 2, times) for times in (1.0, 1.2)
    )

    assert tube.position / 1.15 <= within.position <= tube.position < beyond.position
    assert np.abs(within.e[:, 2]).max() <= tube.heading


SWINGING = """
    clock.control = 0.05
    clock.plant = 0.0025
    reference.kind = line
    reference.speed = 0.5
    gains.kanayama.k = [21.2, 32.0, 10.0]
    gains.kanayama.rate = [13.4, 14.0]
    gains.kanayama.wo = 0.2
    disturbance.std = 3.33333e-5
"""
"""A velocity that swings for long after each push."""


@pytest.mark.slow
def test_close_to_where_its_changes_feed_themselves_there_is_a_corridor_and_beyond_it_none():
    """The largest change of a command is 30 times its value without jitter."""
    plain, tube, over = (
        find_corridor(simulated(SWINGING, {"actuator.jitter": 2.5e-3 * steps}), "kanayama")
        for steps in (0, 5, 6)
    )
    assert 10 * plain.position < tube.position < 50 * plain.position
    assert "may grow as large as what the loop corrects" in over.refused


LATE = {"jitter": "actuator.jitter = 0.004", "delay": "actuator.unmodelled_delay = 0.004"}


@pytest.mark.slow
@pytest.mark.parametrize("late, worst", [("jitter", farthest_jittered), ("delay", farthest_held)])
def test_behind_a_guard_that_counts_late_commands_it_changes_none(late, worst):
    scenario = simulated(GUARDED, LATE[late], "disturbance.std = 0.1")
    tube = find_corridor(scenario, "prox")
    found = worst(scenario, "prox", 150, 0.3, 4)

    assert found.position <= tube.position < 1.35 * found.position
    assert not found.clipped
    assert "the guard's count" not in tube.binding


@pytest.mark.slow
def test_a_guard_that_would_act_on_late_commands_is_named_and_acts():
    close = "limits.v_u1 = [0.5, 1]; limits.v_u2 = [0.45, 0.9]; disturbance.std = 0.5"
    wide, near = (
        simulated(GUARDED, LATE["delay"], close, {"guard.alpha": alpha}) for alpha in (20.0, 5.0)
    )
    tube = find_corridor(near, "prox")

    assert "the guard's ceiling" in find_corridor(wide, "prox").binding
    assert "the guard's ceiling (linear) may reach" in tube.refused
    assert farthest_held(near, "prox", 60, 1.5, 4).clipped


def test_what_is_not_covered_of_late_commands_is_refused_by_name():
    lagging = find_corridor(simulated(GUARDED, "actuator.lag = 0.005"), "prox")
    jitters, late = (
        find_corridor(
            simulated("reference.kind = lemniscate", GUARDED, LATE[key]), "prox", whole=True
        )
        for key in LATE
    )

    assert "the guard counts a lag or late velocities" in lagging.refused
    assert "actuator.jitter is not covered over a whole run" in jitters.refused
    assert "a guard that counts late commands is not covered over a whole run" in late.refused
