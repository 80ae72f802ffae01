"""Filters of bases with dead bands and ramps of wheels, and of those with a least radius."""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
import pytest

import wmr_ctrl
from wmr_ctrl.control.filter import asked as able
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.theory.checks import warnings_for
from wmr_ctrl.world.scenario import Scenario, load_scenario, override

CREATE3 = load_scenario("irobot-create3", {"clock.duration": 10.0})


REFUSED = {
    "two rates": (
        {"base.wheel_accel": 0.5},
        r"base\.wheel_accel = 0\.5 m/s2, wheel_decel = inf m/s2: with two rates one wheel may stop",
    ),
    "dead band of wheels": (
        {"base.wheel_deadband": 0.03},
        r"may push the base on by 0\.01597.* filter\.d\[1\] = 0\.005",
    ),
    "dead band of a governed base": (
        {"filter.kind": "governor", "filter.tau": [0.05, 0.2], "base.deadband": [0.01, 0.02],
         "base.accel": [math.inf] * 2, "base.decel": [math.inf] * 2, "filter.delay": [0.0, 0.05]},
        r"may push the base on by 0\.01.* filter\.d\[1\] = 0\.005",
    ),
    "scale": (
        {"base.min_radius": 0.4, "filter.scale": "axes"},
        r'filter\.scale = "axes" .* base\.min_radius = 0\.4 m',
    ),
    "negative radius": ({"base.min_radius": -0.4}, r"base\.min_radius = -0\.4 must be at least 0"),
    "negative band": ({"base.wheel_deadband": -1}, r"base\.wheel_deadband = -1 must be at least 0"),
    "no rate": ({"base.wheel_decel": 0}, r"base\.wheel_decel = 0 must be above 0"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_no_filter_covers_is_refused_with_numbers(name: str) -> None:
    changes, words = REFUSED[name]
    with pytest.raises(ScenarioError, match=words):
        wmr_ctrl.simulate(override(CREATE3, changes), "kanayama")


def test_a_governor_counts_a_dead_band_in_its_push() -> None:
    """With d as large as the dead band it keeps its limit, and without it is refused (above)."""
    _, dead = (
        REFUSED["dead band of a governed base"][1],
        dict(REFUSED["dead band of a governed base"][0]),
    )
    counted = override(CREATE3, {**dead, "filter.d": [0.03, 0.08]})
    run = wmr_ctrl.simulate(counted, "kanayama")
    assert run.monitor.violations == 0


def turning(radius: float, **changes: object) -> Scenario:
    return override(CREATE3, {"base.min_radius": radius, **changes})


def test_a_step_turns_no_tighter_than_the_base() -> None:
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
def test_a_run_turns_no_tighter_than_the_base(kind: str) -> None:
    run = wmr_ctrl.simulate(turning(0.6, **{"filter.kind": kind}), "kanayama")
    sent = np.stack([run["v_command"], run["omega_command"]], axis=1)
    assert (np.abs(sent[:, 1]) * 0.6 <= np.abs(sent[:, 0]) + 1e-12).all()
    free = wmr_ctrl.simulate(turning(0.0, **{"filter.kind": kind}), "kanayama")
    assert (np.abs(free["omega_command"]) * 0.6 > np.abs(free["v_command"]) + 1e-3).any()


def found(scenario: Scenario) -> dict[str, str]:
    return {item.key: str(item) for item in warnings_for(settle(scenario, "kanayama"))}


def test_check_objects_to_a_path_tighter_than_the_base() -> None:
    assert "base.min_radius" not in found(turning(0.8))
    assert "radius of 0.8 m" in found(turning(0.81))["base.min_radius"]


@pytest.mark.parametrize(
    ("given", "sent"),
    [((0.4, 0.5), 0.5), ((0.4, 2.0), 0.8), ((-0.4, -2.0), -0.8), ((0.0, 1.0), 0.0)],
)
def test_a_turn_is_no_tighter_than_the_least_radius(given, sent) -> None:
    found = ca.evalf(able.turning(ca.SX(given), ca.SX(0.5))).full().ravel()

    assert found == pytest.approx([given[0], sent])
