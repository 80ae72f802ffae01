"""The guard with different limits forwards and backwards."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from tests.control.guard.test_guard import NAMES, drawn
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


@pytest.mark.parametrize("late", [False, True])
def test_each_side_is_a_guard_of_one_limit_whose_caps_are_those_of_the_narrower(late):
    """So every statement about one side holds, and a safe force exists at every speed."""
    draw, sent = np.random.default_rng(5), None
    for _ in range(60):
        numbers = dict(zip(NAMES, drawn(draw)[0], strict=True))
        if late:
            numbers["delay"] = draw.uniform(0.5, 3) * numbers["period"]
            numbers["dbar"] = numbers["f_min"] + 0.2 * (numbers["dbar"] - numbers["f_min"])
        narrow = Bounds(**{name: ca.SX(value) for name, value in numbers.items()})
        both = replace(narrow, u1=draw.uniform(1, 3) * narrow.u1, back=narrow.u1)
        if not number(feasible(narrow)):
            continue
        if late:
            most = number(largest_force(both))
            assert most == pytest.approx(number(largest_force(narrow)), rel=1e-12)
            force = draw.uniform(-most, most)
            ahead, back = (ca.fmax(way * force + narrow.net, 0) / narrow.M_min for way in (1, -1))
            sent = InFlight(narrow.delay * ahead, narrow.delay * back)
        y = ca.SX(draw.uniform(-1.5, 3)) * narrow.u1
        lo, hi = (number(side(y, both, sent)) for side in (floor, ceiling))
        assert lo - hi <= 1e-9 * max(1, abs(hi))
        one = replace(narrow, brake=ca.fmin(narrow.brake, narrow.cap))
        assert number(both.braking) == pytest.approx(number(one.brake))
        assert lo == pytest.approx(number(floor(y, narrow, sent)), rel=1e-9, abs=1e-9)
        assert hi >= number(ceiling(y, narrow, sent)) - 1e-9


def number(expression):
    return float(ca.evalf(expression))


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
