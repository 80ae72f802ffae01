"""Numbers that the guard derives where a scenario leaves them out."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from wmr_ctrl.control.setup import settle
from wmr_ctrl.guard.bounds import early_speed
from wmr_ctrl.guard.counted import MODEL, STATED, counted
from wmr_ctrl.scenario import load_scenario

ON = {"guard.enabled": True}


def derived(**changed: object):
    return settle(load_scenario("paper-simulation-no-switch", {**ON, **changed}), None).guard


def test_dbar_counts_the_model_s_share_on_each_axis() -> None:
    alone, more = derived(), derived(**{"guard.d_model": [7.0, 3.0]})

    assert more.dbar == pytest.approx((alone.dbar[0] + 7.0, alone.dbar[1] + 3.0))


def test_a_slope_pulls_at_the_heaviest_robot_that_is_counted_on() -> None:
    slope, pull = {"slope.angle": 0.05}, 9.81 * math.sin(0.05)
    light, heavy = derived(**slope), derived(**slope, **{"guard.M_max": [70.0, 9.0]})

    assert light.dbar[0] - derived().dbar[0] == pytest.approx(1.1 * 50.0 * pull, rel=1e-9)
    assert heavy.dbar[0] - light.dbar[0] == pytest.approx((70.0 - 55.0) * pull, rel=1e-9)


TRUE = [
    {"robot.m": 90.0, "robot.I": 9.0, "robot.mu": 0.3},
    {"robot.m": 20.0, "robot.I": 2.0, "robot.mu": 0.0},
    {"changes": [{"t": 1.0, "m": 90.0, "I": 9.0, "mu": 0.3}]},
]
EFFECTS = {"slope.angle": 0.05, "slope.offset": 0.02, "resistance.rolling": [0.02, 0.01]}


@pytest.mark.parametrize("true", TRUE)
def test_no_number_follows_the_true_robot(true) -> None:
    """What the guard counts on is what is believed, whatever drives below it."""
    believed = {"model.m": 30.0, "model.I": 3.0, "model.mu": 0.05, **EFFECTS}
    guard = derived(**believed, **true)

    assert guard == derived(**believed)
    assert (guard.M_min, guard.M_max) == (pytest.approx((27, 2.7)), pytest.approx((33, 3.3)))


def test_friction_above_the_push_makes_nothing_faster_before_the_first_command() -> None:
    guard = derived(**{"guard.dbar": [60.0, 15.0], "actuator.delay": 0.02})
    held = replace(guard, f_min=(80.0, 5.0))

    assert early_speed(held) == (0.0, pytest.approx(0.02 * 10.0 / guard.M_min[1]))


def test_what_is_counted_adds_up_to_the_guard_s_numbers() -> None:
    """Where effects add to a number, they and guard.d_model are the whole of it."""
    effects = {"encoder.counts": 4096.0, "actuator.delay": 0.02, "actuator.jitter": 0.01,
               "disturbance.push": [5.0, 1.0], "guard.d_model": [7.0, 3.0],
               "disturbance.truncate": 3.0}  # fmt: skip
    setup = settle(load_scenario("far-start", {**ON, **effects}), None)
    known = counted(setup.scenario, setup.guard, setup.effects)

    assert set(known["dbar"].sources) == {"torque noise", "push", "guard.d_model"}
    for name in ("dbar", "nbar", "delay", "lag", "age", "window"):
        added = [pair for pair in known[name].sources.values() if pair is not None]
        total = tuple(sum(pair[i] for pair in added) for i in (0, 1))
        assert known[name].value == pytest.approx(total, abs=1e-15), name
    assert set(known["M_min"].sources) == {MODEL}
    assert known["delay"].value == pytest.approx((0.02, 0.03))


def test_what_is_stated_is_counted_as_stated() -> None:
    stated = {**ON, "guard.dbar": [90.0, 20.0], "disturbance.truncate": 3.0}
    setup = settle(load_scenario("paper-simulation", stated), None)
    found = counted(setup.scenario, setup.guard, setup.effects)["dbar"]

    assert (found.value, dict(found.sources)) == ((90.0, 20.0), {STATED: None})
