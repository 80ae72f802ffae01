"""A clip that stops on a base that slows down by a least deceleration."""

import re

import casadi as ca
import numpy as np
import pytest

from benchmarks.filter_trials.stopping import RAMP_TEETH, RAMPS, bitten_ramps, breaks, drives
from tests.papers_robot import preset
from tests.tables import cases, changes
from wmr_ctrl import command_filter, load_scenario
from wmr_ctrl.control.filter.ramp_stop import stopping_speed
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.scenario import override

BASE = changes("""
    base.kind = velocity
    limits.v_u1 = [1.0, 2.0]
    limits.v_u2 = [0.8, 1.6]
    clock.control = 0.05
    filter.kind = clip
    filter.gain = [0.9, 1.1]
    filter.d = [0.05, 0.05]
    filter.odometry = [0.02, 0.02]
    filter.delay = [0.1, 0.15]
    filter.free_error = 0.02
    filter.rest = 1.0
    filter.decel = [1.0, 2.0]
    filter.leave = 0
""")
T = 0.05


def test_the_speed_from_which_a_stop_takes_the_room_that_there_is():
    room, h, A = 10 ** np.random.default_rng(2).uniform(-6, 6, (3, 50))
    m = np.array([float(stopping_speed(*row)) for row in zip(room, h, A, strict=True)])
    assert m * h + m * m / (2 * A) == pytest.approx(room, rel=2**-48)
    assert float(ca.evalf(stopping_speed(ca.SX(-1.0), ca.SX(0.1), ca.SX(1.0)))) == 0


def test_a_clip_stops_without_distances_and_leaves_with_one():
    clip = command_filter(load_scenario("paper-simulation", BASE))
    for _ in range(80):
        near = clip.step((1.0, 0.0), measured=(0.0, 0.0), free=(0.01, 2.0), turn=(9.0, 9.0), dt=T)
    assert near.command == (0.0, 0.0)
    assert "near" in near.flags
    assert clip.step((-0.3, 0.0), measured=(0.0, 0.0), free=(0.01, 2.0), dt=T).command == (0, 0)
    away = clip.step((-0.3, 0.0), measured=(0.0, 0.0), free=(0.08, 2.0), dt=T)
    assert away.command == (-0.3, 0.0)
    assert "near" not in away.flags
    for _ in range(200):  # what is known shrinks by what may be driven
        blind = clip.step((-0.3, 0.0), measured=(0.0, 0.0), dt=T)
    assert blind.command == (0.0, 0.0)
    assert "no-distance" in blind.flags


@pytest.mark.parametrize("name", RAMPS)
@pytest.mark.slow_but("0.1 to 0.15 s late", "1 m/s back, 0.1 m/s ahead, no push, no brake")
def test_drives_do_not_touch(name):
    found = drives(RAMPS[name], 300, 4)
    assert {what: int(item.sum()) for what, item in breaks(found).items() if item.any()} == {}
    assert found["gap"].min() < 0.02


@pytest.mark.parametrize("name", RAMP_TEETH)
@pytest.mark.slow_but("deceleration", "distances")
def test_a_bound_that_does_not_hold_is_seen(name):
    assert (bitten_ramps(name, 300, 5)["gap"] < 0).any()


def test_it_goes_on_leaving_only_from_standstill():
    """A command away that follows a tiny one, sent while a push drives the base, is refused."""
    told = {"measured": (-0.05, 0.0), "turn": (9.0, 9.0), "dt": T}
    clip = command_filter(load_scenario("paper-simulation", {**BASE, "filter.rest": 1.5}))
    for _ in range(12):
        clip.step((1e-3, 0.0), free=(3.0, 0.12), **told)
    moving = clip.step((1.0, 0.0), free=(3.0, 0.09), **told)
    assert moving.command == (0.0, 0.0)

    for _ in range(120):
        clip.step((0.0, 0.0), free=(3.0, 0.12), **told)
    resting = [clip.step((1.0, 0.0), free=(3.0, 0.099), **told).command[0] for _ in range(5)]
    assert min(resting) > 0.3


def test_a_command_away_does_not_keep_a_brake_open_while_an_obstacle_comes_nearer():
    own = {**BASE, "filter.d": (0.0, 0.0), "filter.nearing": 0.5, "filter.tau": (0.1, 0.5)}
    clip = command_filter(load_scenario("paper-simulation", own))
    told = {"measured": (0.3, 0.0), "free": (0.1, 9.0), "turn": (99.0, 99.0), "dt": T}
    assert clip.step((-1e-3, 0.0), **told).command == (0.0, 0.0)


def test_a_lowered_limit_does_not_hide_how_fast_the_base_still_is():
    told = {"measured": (1.0, 0.0), "turn": (9.0, 9.0), "dt": T}
    clip = command_filter(preset("paper-simulation", BASE, "filter.changing = true"))
    for _ in range(9):
        assert clip.step((1.0, 0.0), free=(3.0, 3.0), **told).command[0] > 0.8
    slow = ((-0.2, 0.2), (-1.0, 1.0))
    assert clip.step((1.0, 0.0), free=(0.6, 3.0), limits=slow, **told).command == (0.0, 0.0)
    assert 0 < clip.step((1.0, 0.0), free=(3.0, 3.0), limits=slow, **told).command[0] < 0.2


def test_a_base_that_a_lag_keeps_moving_is_not_taken_to_stand():
    own = {**BASE, "filter.d": (0.0, 0.0), "filter.rest": None, "filter.tau": (0.1, 5.0)}
    clip = command_filter(load_scenario("paper-simulation", own))
    told = {"measured": (0.3, 0.0), "free": (1.0, 9.0), "turn": (99.0, 99.0), "dt": T}
    for _ in range(200):
        clip.step((0.0, 0.0), **told)
    assert clip.step((1.0, 0.0), **told).command == (0.0, 0.0)
    assert clip.step((1.0, 0.0), **{**told, "free": (9.0, 9.0)}).command[0] > 0.1


def test_a_base_of_a_run_that_slows_down_less_is_named():
    run = preset("paper-simulation", BASE, """
        base.decel = [1.0, 2.0]
        base.gain = [0.9, 1.0]
        base.delay = 0.1
        filter.tau = [0.1, 0.2]
        disturbance.std = 0
        robot.mu = 0
    """)  # fmt: skip
    with pytest.raises(ScenarioError, match=r"base\.gain\[1\] = 0\.9, less than filter\.decel"):
        settle(run, "kanayama")
    settle(override(run, {"filter.decel": [0.9, 2.0]}), "kanayama")


@pytest.mark.parametrize(
    "changed, words",
    cases("""
        base.jerk = [9, 9]                                    | base.jerk
        base.wheel_accel = 0.1; base.wheel_decel = 0.1        | base.wheel_accel
        actuator.tau_max = 0.1                                | actuator.tau_max
        base.timeout = 0.05; base.losses = 1; filter.losses = 1 | base.timeout
        base.deadband = [0.1, 0.1]                            | errors of the command may push
        filter.losses = 1                                     | none
        base.w_max = 20.0                                     | none
        base.timeout = 0.05; base.losses = 1; filter.losses = 1; filter.hold = 0.05 | none
    """),
)
def test_what_holds_back_a_stop_of_a_run_is_named(changed, words):
    run = preset("paper-simulation", BASE, """
        base.decel = [1.0, 2.0]
        base.delay = 0.1
        filter.tau = [0.1, 0.2]
        disturbance.std = 0
        robot.mu = 0
    """, changed)  # fmt: skip
    if words == "none":
        settle(run, "kanayama")
        return
    with pytest.raises(ScenarioError, match=words):
        settle(run, "kanayama")


@pytest.mark.parametrize(
    "stated",
    cases("""
        filter.slew = [1, 1]
        filter.delay = [[0, 0.1], [0, 0.2]]
        filter.leave = 1; filter.nearing = 0.1
        filter.decel = None
        filter.odometry = None
        filter.rest = None
    """),
)
def test_what_it_cannot_keep_and_lacks_is_told_by_name(stated):
    key, _, value = stated.partition(" = ")
    with pytest.raises(ScenarioError, match=re.escape(key)):
        preset("paper-simulation", BASE, {key: None} if value == "None" else stated)
