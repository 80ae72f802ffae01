"""Limits of the guard that change: kept by the heaviest and lightest robot under the worst push."""

import numpy as np
import pytest

from tests.tables import changes
from wmr_ctrl.control.controller import guard
from wmr_ctrl.control.guard.changing import BEHIND, IN_FORCE
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.signals import places
from wmr_ctrl.world.scenario import load_scenario, override

PUSH, ERROR = (20.0, 5.0), (0.01, 0.01)
STATED = changes("""
    guard.enabled = true
    guard.changing = true
    disturbance.std = 0.0
    changes = []
""") | {"guard.dbar": PUSH, "guard.nbar": ERROR}  # fmt: skip
SCENARIO = load_scenario("paper-simulation", STATED)


def driven(scenario, trials, falls=1.0, seed=0):
    """Return the largest speed beyond the limits in force.

    ``falls``: how fast the limits fall, as a multiple of the allowed rate.
    """
    setup = settle(scenario, "pid")
    system, numbers = guard(setup), setup.guard
    step = system.function("guard", [system.update, system.y]).map(trials)
    at = places(item.signal for item in system.state)[IN_FORCE.name]
    draw, T = np.random.default_rng(seed), 0.01
    x, p = (np.tile(np.array(own)[:, None], trials) for own in (system.x0, system.p0))
    r, l, v, beyond = scenario.robot.r, scenario.robot.l, np.zeros((2, trials)), -np.inf
    mass = np.where(
        draw.random((2, trials)) < 0.5, np.vstack(numbers.M_min), np.vstack(numbers.M_max)
    )
    widest = np.array(scenario.limits.v_u1)[:, None] * np.ones(trials)
    limits, asked = widest, np.full((2, trials), 1e4)
    for _ in range(250):
        lowered = draw.random(trials) < 0.03
        limits = np.where(lowered, widest * draw.uniform(0, 1.2, (2, trials)), limits)
        asked = np.where(draw.random((2, trials)) < 0.02, -asked, asked)
        told = np.stack([-limits[0], limits[0], -limits[1], limits[1]])
        before, seen = x[at].copy(), v - np.sign(v) * np.vstack(ERROR)
        x, torque = (own.full() for own in step(np.vstack([asked, seen, told]), x, p))
        x[at] = before + falls * (x[at] - before)
        force = np.stack([torque[0] + torque[1], l * (torque[0] - torque[1])]) / r
        v = v + T / mass * (force + np.where(v >= 0, 1, -1) * np.vstack(PUSH))
        least, most = x[at][[0, 2]], x[at][[1, 3]]
        beyond = max(beyond, (v - most).max(), (least - v).max())
    return beyond


def test_limits_in_force_are_kept_while_they_fall():
    sides = changes("limits.v_min = [-0.5, -1.0]; limits.v_max = [0.9, 1.4]")
    assert driven(SCENARIO, 200) <= 1e-12
    assert driven(override(SCENARIO, sides), 200) <= 1e-12


def test_limits_that_fall_faster_are_not_kept():
    assert driven(SCENARIO, 200, falls=1.2) > 1e-3


def told(limits, steps=1, **changes):
    """Return the limits in force after ``steps`` at rest, and whether they lag the given limits."""
    system = guard(settle(override(SCENARIO, changes), "pid"))
    step = system.function("guard", [system.update, system.d])
    x, at = np.array(system.x0), places(item.signal for item in system.state)
    shown = places(item.signal for item in system.diagnostics)
    for _ in range(steps):
        x, d = step([0, 0, 0, 0, *limits], x, system.p0)
        x = x.full().ravel()
    return x[at[IN_FORCE.name]], bool(d[shown[BEHIND.name]])


def test_a_limit_rises_at_once_and_falls_slowly():
    wide, behind = told([-5, 5, -5, 5])
    assert wide == pytest.approx([-1, 1, -1.5, 1.5])
    assert not behind
    low, behind = told([-0.5, 0.5, -0.5, 0.5])
    assert 0.5 < low[1] < 1
    assert behind
    low, behind = told([-0.5, 0.5, -0.5, 0.5], steps=200)
    assert low == pytest.approx([-0.5, 0.5, -0.5, 0.5], rel=1e-6)
    own, _ = told([-0.5, 0.5, -0.5, 0.5], **changes("guard.falling = [0.1, 0.1]"))
    assert own[1] == pytest.approx(1 - 0.1 * 0.01)


BRAKED = {"guard.f_min": [30.0, 8.0], "guard.f_speed": [0.1, 0.1], "guard.trust": True}


@pytest.mark.parametrize("brakes", [{}, BRAKED])
def test_no_limit_is_lower_than_the_guard_can_keep(brakes):
    """Also where friction surely brakes more than pushes drive."""
    low, behind = told([np.nan, 0.0, 0.0, np.nan], steps=3000, **brakes)
    numbers = settle(override(SCENARIO, brakes), "pid").guard
    least = [
        max(f + 2 * max(d - g, 0) / (M * numbers.alpha), 2 * n)
        for f, d, g, M, n in zip(
            numbers.f_speed, numbers.dbar, numbers.f_min, numbers.M_min, ERROR, strict=True
        )
    ]
    assert low == pytest.approx([-least[0], least[0], -least[1], least[1]], rel=1e-3)
    assert behind


def test_limits_do_not_change_behind_late_commands():
    with pytest.raises(ScenarioError, match=r"guard\.changing"):
        settle(override(SCENARIO, {"actuator.delay": 0.01}), "pid")
