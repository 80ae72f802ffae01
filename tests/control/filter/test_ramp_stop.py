"""A clip that stops on a base that slows down by a least deceleration, against an adversary."""

import re

import casadi as ca
import numpy as np
import pytest

from benchmarks.filter_trials.stopping import RAMP_TEETH, RAMPS, bitten_ramps, breaks, drives
from tests.papers_robot import preset
from tests.tables import changes
from wmr_ctrl import command_filter, load_scenario
from wmr_ctrl.control.filter import filter_system
from wmr_ctrl.control.filter.ramp_stop import stopping_speed
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError

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
AHEAD, ANY, TO_AND_FRO, TAPS = range(4)
T, PARTS = 0.05, 20


def gaps(stated, real=None, trials=120, steps=300, seed=1):
    """Least gap [m] to a wall ahead of each base while it moves on, all bounds at their worst."""
    scenario = load_scenario("paper-simulation", {**BASE, **stated})
    settings, own = scenario.filter, real or {}
    system, draw = filter_system(scenario), np.random.default_rng(seed)
    step = system.function("filter", [system.update, system.y]).map(trials)
    x, p = (np.tile(np.array(part)[:, None], trials) for part in (system.x0, system.p0))
    (soonest, latest), (weak, strong) = (
        settings.intervals("delay")[0],
        settings.intervals("gain")[0],
    )
    push, slows = own.get("d", settings.d[0]), own.get("decel", settings.decel[0])
    rest, error = own.get("rest", settings.rest), own.get("error", settings.free_error)
    place, v, acting, zero = (np.zeros(trials) for _ in range(4))
    wall, asked = draw.uniform(0.3, 3, trials), np.full(trials, 1e3)
    driver, gap, t, sent = draw.integers(0, 4, trials), np.full(trials, np.inf), 0.0, []
    for k in range(steps):
        some = draw.choice([1e3, -1e3, 0, 0.3, -0.3], trials)
        anyhow = np.where(draw.random(trials) < 0.04, some, asked)
        swung, tapped = (1e3, -1e3)[k // 60 % 2], np.where(draw.random(trials) < 0.5, -0.3, 0.0)
        asked = np.choose(driver, [np.full(trials, 1e3), anyhow, np.full(trials, swung), tapped])
        u = np.zeros((system.u.numel(), trials))
        u[0], u[2], u[5], u[6] = asked, v - settings.odometry[0], T, wall - place + error
        u[7:10] = 1e9
        x, y = (part.full() for part in step(u, x, p))
        before = sent[-1][1] if sent else np.zeros(trials)
        takes = np.where(y[0] > before, t + soonest, t + latest)
        sent.append((np.maximum(takes, sent[-1][0] if sent else 0), y[0]))
        for part in range(PARTS):
            now, h = t + part * T / PARTS, T / PARTS
            for when, command in sent[-8:]:
                acting = np.where(when <= now + 1e-12, command, acting)
            zero = np.where(acting == 0, np.minimum(zero, now), np.inf)
            target = np.where(acting > 0, strong, weak) * acting + push
            next_v = np.where(v > target, np.maximum(target, v - slows * h), target)
            stands = (acting == 0) & (now >= zero + rest - 1e-12)
            next_v = np.where(stands, 0.0, next_v)
            place = place + np.where(stands, 0.0, (v + next_v) / 2 * h)
            gap = np.where((v > 0) | (next_v > 0), np.minimum(gap, wall - place), gap)
            v = next_v
        t += T
    return gap


@pytest.mark.parametrize(
    "stated", ["", "filter.delay = [0, 0.2]", "filter.decel = [0.5, 1]; filter.rest = 0.3"]
)
def test_no_base_within_the_bounds_touches(stated):
    least = gaps(changes(stated)).min()
    assert -1e-9 < least < 0.01


@pytest.mark.parametrize("real", [{"d": 0.055}, {"rest": 1.1}, {"error": 0.027}, {"decel": 0.7}])
def test_a_base_beyond_a_bound_may_touch(real):
    assert gaps({}, real, seed=5).min() < -1e-3


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
@pytest.mark.slow_but("0.1 to 0.15 s late")
def test_drives_do_not_touch(name):
    found = drives(RAMPS[name], 300, 4)
    assert {what: int(item.sum()) for what, item in breaks(found).items() if item.any()} == {}
    assert found["gap"].min() < 0.02


@pytest.mark.parametrize("name", RAMP_TEETH)
@pytest.mark.slow_but("deceleration")
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


def test_a_base_of_a_run_that_slows_down_less_is_named():
    run = BASE | changes("""
        base.decel = [1.0, 2.0]
        base.gain = [0.9, 1.0]
        base.delay = 0.1
        filter.tau = [0.1, 0.2]
        disturbance.std = 0
        robot.mu = 0
    """)
    with pytest.raises(ScenarioError, match=r"base\.gain\[1\] = 0\.9, less than filter\.decel"):
        settle(load_scenario("paper-simulation", run), "kanayama")
    settle(load_scenario("paper-simulation", {**run, "filter.decel": [0.9, 2.0]}), "kanayama")


@pytest.mark.parametrize(
    "stated",
    ["filter.slew = [1, 1]", "filter.delay = [[0, 0.1], [0, 0.2]]",
     "filter.leave = 1; filter.nearing = 0.1"],
)  # fmt: skip
def test_what_it_cannot_keep_is_refused(stated):
    with pytest.raises(ScenarioError, match=re.escape(stated.split(" ")[0])):
        preset("paper-simulation", BASE, stated)


@pytest.mark.parametrize("key", ["filter.decel", "filter.odometry", "filter.rest"])
def test_what_it_needs_is_asked_for(key):
    with pytest.raises(ScenarioError, match=re.escape(key)):
        load_scenario("paper-simulation", {**BASE, key: None})
