"""The guard with another limit backwards than forwards."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from tests.control.guard.test_guard_adversary import LIGHTEST
from tests.tables import changes
from wmr_ctrl.api import simulate
from wmr_ctrl.control.guard.delay import InFlight, largest_force
from wmr_ctrl.control.guard.guard import Bounds, ceiling, feasible, floor
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.scenario import load_scenario

PUSHED = LIGHTEST | changes("clock.duration = 10.0")
SIDES = changes("limits.v_min = [-0.3, -1.4]; limits.v_max = [0.7, 0.6]")
BACKWARDS = {**changes("initial.velocity = [-0.1, -0.1]"), "initial.pose": [6.0, 0.0, -np.pi / 2]}
"""A start far ahead of the desired motion: the law wants back, and pushes drive that way."""


def drawn(draw, late):
    """Numbers of an axis that can be met, the way back with less room than the way ahead."""
    M, alpha, period = draw.uniform(1, 50), draw.uniform(1, 20), draw.uniform(0.005, 0.05)
    u1, back = draw.uniform(0.5, 2.0), draw.uniform(0.1, 0.5)
    delay = draw.uniform(0.01, 0.1) if late else 0.0
    f_speed = draw.uniform(0, 0.2) * back
    net = draw.uniform(0, 0.5) * M * alpha * (back - f_speed) / (1 + alpha * delay)
    return {
        "u1": u1, "back": back, "period": period, "M_min": M, "M_max": 1.5 * M, "dbar": net,
        "nbar": draw.uniform(0, 0.5) * back, "alpha": min(alpha, 1 / period), "f_min": 0.0,
        "brake": net * draw.uniform(1, 5), "f_speed": f_speed, "delay": delay,
    }  # fmt: skip


def bounds(numbers, late):
    """The guard's bounds as numbers."""
    known = {name: ca.SX(value) for name, value in numbers.items()}
    if not late:
        del known["delay"]
    return Bounds(**known)


@pytest.mark.parametrize("late", [False, True])
def test_each_side_is_a_guard_of_one_limit_whose_caps_are_those_of_the_narrower(late):
    """So every statement on one side holds, and a safe force is left at every speed."""
    draw = np.random.default_rng(5)
    for _ in range(120):
        numbers = drawn(draw, late)
        both = bounds(numbers, late)
        if not float(ca.evalf(feasible(both))):
            continue
        narrow = bounds({**numbers, "u1": numbers["back"]}, late)
        narrow = replace(narrow, back=None)
        sent = None
        if late:
            most = float(ca.evalf(largest_force(both)))
            assert most == pytest.approx(float(ca.evalf(largest_force(narrow))), rel=1e-12)
            force, net = draw.uniform(-most, most), numbers["dbar"]
            ahead, back = (max(way * force + net, 0) / numbers["M_min"] for way in (1, -1))
            sent = InFlight(ca.SX(numbers["delay"] * ahead), ca.SX(numbers["delay"] * back))
        y = ca.SX(draw.uniform(-1.5 * numbers["back"], 1.5 * numbers["u1"]))
        lo, hi = (float(ca.evalf(side(y, both, sent))) for side in (floor, ceiling))
        assert lo <= hi * (1 + 1e-12) + 1e-9
        one = replace(narrow, brake=ca.fmin(narrow.brake, narrow.cap))
        assert float(ca.evalf(both.braking)) == pytest.approx(float(ca.evalf(one.brake)))
        below = float(ca.evalf(floor(y, narrow, sent)))
        assert lo == pytest.approx(below, rel=1e-9, abs=1e-9)
        assert hi >= float(ca.evalf(ceiling(y, narrow, sent))) - 1e-9


@pytest.mark.parametrize("law", ["pid", "prox"])
@pytest.mark.parametrize("way", [1, -1])
def test_an_adversary_reaches_the_limit_of_its_direction_and_never_passes_it(law, way):
    start = {} if way > 0 else BACKWARDS
    run = simulate("paper-simulation-nominal", law, guard=True, overrides=PUSHED | SIDES | start)

    margin = np.array(run.monitor.least_margin)
    assert run.monitor.violations == 0
    assert margin.min() > -1e-11
    if law == "pid":
        assert margin.min() < 1e-9, "a constant push is held at the limit"


@pytest.mark.slow
@pytest.mark.parametrize("broken", ["v_max", "v_min"])
def test_a_bound_that_is_ten_per_cent_too_small_breaks(broken):
    weak = changes("""
        guard.dbar = [54.0, 13.5]
        guard.trust = true
        clock.control = 0.05
    """)
    stated = PUSHED | SIDES | weak | (BACKWARDS if broken == "v_min" else {})
    run = simulate("paper-simulation-nominal", "pid", guard=True, overrides=stated)

    assert run.outcome == "limit-violated"
    assert run.monitor.least_margin[0] == pytest.approx(-6.0 * 0.05 / 25.0, abs=1e-6)


def test_a_guard_cannot_promise_never_to_reverse():
    stated = PUSHED | changes("limits.v_min = [0.0, -1.0]; guard.enabled = true")
    with pytest.raises(
        ScenarioError, match=r"v_min\[1\] = 0 cannot be kept. .v_min. must be"
    ) as refused:
        settle(load_scenario("paper-simulation-nominal", stated), "pid")
    least = float(str(refused.value).rpartition(" = ")[2].partition(",")[0])
    assert least < 0
    settle(
        load_scenario("paper-simulation-nominal", {**stated, "limits.v_min": [least, -1.0]}), "pid"
    )
