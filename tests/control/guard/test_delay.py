"""Behind drives with a delay: inside stays inside, outside comes back, whatever is under way."""

from __future__ import annotations

import math
import re

import casadi as ca
import numpy as np
import pytest

from tests.control.guard.harness import LIGHT, LIMITS, MOST
from tests.control.guard.late import hostile, late
from tests.control.guard.test_guard import evaluated
from tests.control.guard.test_guard_adversary import LIGHTEST
from wmr_ctrl.api import simulate
from wmr_ctrl.control.controller import guard as guard_alone
from wmr_ctrl.control.guard.delay import InFlight, in_flight
from wmr_ctrl.control.guard.price import early_speed, usable_speed
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.results import Run
from wmr_ctrl.world.scenario import load_scenario

ON = {"guard.enabled": True}
DELAYS = (0.1, 0.5, 1.0, 2.0)
"""In control periods; 0.1 is one plant step."""
REACHING = {"pid", "smc"}
"""Laws that the adversary drives onto both limits at every delay."""


def adverse(law: str, period: float, delay: float) -> Run:
    """The lightest robot, pushed the way it moves, its torque ``delay`` periods late."""
    pushed = {"clock.control": period, "clock.plant": period / 10, "clock.duration": 400 * period}
    weak = {"guard.dbar": [60.0, 13.0], "disturbance.push": [60.0, 13.0]}
    changed = {**LIGHTEST, **pushed, **weak, "actuator.delay": delay * period}
    return simulate("paper-simulation-nominal", law, guard=True, overrides=changed)


def checked(law: str, period: float, delay: float) -> None:
    run = adverse(law, period, delay)
    gap = np.array(run.monitor.max_abs_v) - LIMITS
    assert run.monitor.violations == 0, gap
    assert run.outcome == "completed"
    assert (run["feasible"] == 1).all()
    if law in REACHING:
        assert gap.max() > -1e-9


@pytest.mark.parametrize("delay", DELAYS)
@pytest.mark.slow_but("1.0")
def test_greedy_adversary_reaches_the_limit_and_never_passes_it(delay: float) -> None:
    checked("pid", 0.01, delay)


@pytest.mark.parametrize(
    ("law", "delay", "period"), [("smc", 0.5, 0.001), ("nn", 2.0, 0.001), ("pursuit", 1.0, 0.01)]
)
@pytest.mark.slow
def test_greedy_adversary_with_every_law(law: str, delay: float, period: float) -> None:
    checked(law, period, delay)


def fastest(cases: int, seed: int, *, true_delay: bool = False) -> np.ndarray:
    """Largest |v|/limit of hostile cases from inside; the true delay is that stated, or shorter."""
    draw, worst = np.random.default_rng(seed), np.zeros(2)
    for case in range(cases):
        period, delay = (0.001, 0.01, 0.04)[case % 3], (0.1, 0.5, 1.0, 1.3, 2.0)[case % 5]
        nbar = np.array([0.02, 0.03]) * (case // 2 % 2)
        wheels = {"actuator.tau_max": 20.0} if case % 4 == 3 else {}
        scenario = late(period, delay * period, **{"guard.nbar": nbar.tolist()}, **wheels)
        steps = draw.integers(0, round(10 * delay) + 1) if case % 3 == 1 else round(10 * delay)
        drive = hostile(draw, period * (delay if true_delay else steps / 10), nbar)
        inside = LIMITS * (1 - 2.0**-50) - delay * period * MOST / LIGHT
        start = inside * draw.choice([0.0, 1.0, draw.random()])
        worst = np.maximum(worst, drive.speeds(scenario, start, 150).max(axis=0) / LIMITS)
    return worst


@pytest.mark.slow
def test_hostile_robots_with_any_delay_up_to_the_stated_one() -> None:
    assert (fastest(15, 0) <= 1).all()


MUTATIONS = {
    "nothing under way is counted": (
        "wmr_ctrl.control.guard.delay.in_flight",
        lambda *_: InFlight(ca.SX(0), ca.SX(0)),
    ),
    "one percent is not counted": (
        "wmr_ctrl.control.guard.delay.in_flight",
        lambda *a: _scaled(in_flight(*a), 0.99),
    ),
    "commands are not capped": (
        "wmr_ctrl.control.guard.guard.largest_force",
        lambda _: ca.SX(1e30),
    ),
}


def _scaled(coming: InFlight, share: float) -> InFlight:
    return InFlight(share * coming.ahead, share * coming.back)


@pytest.mark.parametrize("name", MUTATIONS)
@pytest.mark.slow
def test_a_guard_without_one_of_its_parts_breaks(name: str, monkeypatch) -> None:
    part, other = MUTATIONS[name]
    monkeypatch.setattr(part, other)

    assert any((fastest(cases, 0, true_delay=True) > 1.001).any() for cases in (1, 9))


@pytest.mark.slow
def test_a_guard_that_is_not_told_of_the_delay_breaks() -> None:
    draw = np.random.default_rng(3)
    runs = [hostile(draw, 0.01, np.zeros(2)).speeds(late(0.01, 0.0), LIMITS, 100) for _ in range(8)]

    assert np.max(runs / LIMITS) > 1.01


@pytest.mark.parametrize("law", ["pid", "prox"])
@pytest.mark.parametrize("delay", [0.005, 0.02])
@pytest.mark.slow_but("0.005-pid")
def test_back_inside_within_the_delay_and_the_stated_samples(law: str, delay: float) -> None:
    changed = {"disturbance.truncate": 3.0, "clock.duration": 6.0, "actuator.delay": delay}
    run = simulate("outside-start", law, guard=True, overrides=changed)
    scenario = load_scenario("outside-start", {**ON, **changed})
    guard, period = settle(scenario, law).guard, scenario.clock.control
    gained, begun = early_speed(guard), math.ceil(delay / period)
    for i, name in enumerate(("v1", "omega")):
        u1, start = scenario.limits.v_u1[i], scenario.initial.velocity[i]
        beyond = start + gained[i] - u1
        most = math.ceil(beyond * guard.M_max[i] / (period * (guard.brake[i] - guard.dbar[i])))
        speeds = run[name]
        outside = speeds > u1
        assert outside[0]
        assert speeds.max() <= start + gained[i]
        assert (np.diff(speeds[begun:][outside[begun:]]) <= 0).all()
        assert not outside[begun + most :].any()
        assert speeds.min() >= -u1


@pytest.mark.slow
def test_bounds_broken_by_D_cost_D_times_period_and_delay() -> None:
    """|v| <= v_u1 + D (T + delay)/M_min; the adversary gets there."""
    excess = np.array([20.0, 5.0]) * (0.01 + 0.02) / LIGHT
    changed = {
        "guard.dbar": [40.0, 10.0],
        "guard.trust": True,
        "actuator.delay": 0.02,
        "clock.duration": 4.0,
    }
    run = simulate("paper-simulation-nominal", "smc", guard=True, overrides={**LIGHTEST, **changed})

    gap = np.array(run.monitor.max_abs_v) - LIMITS
    assert (gap <= excess + 1e-9).all()
    assert (gap > 0.5 * excess).all()


@pytest.mark.parametrize(("changed", "said"), [
    ({"guard.dbar": [600.0, 1.0], "actuator.delay": 0.04},
     r"alpha delay\), delay = 0\.04 s, is needed on axis 1.*1200 > 45 \* 100 \* 1/5 = 900 N.*"
     r"actuator\.delay <= 0\.027 s.*dbar\[1\] <= 449\.9 N.*of at least 60\.\d+ kg"),
    ({"guard.dbar": [60.0, 260.0], "actuator.delay": 0.01},
     r"axis 2.*actuator\.delay <= 0\.004 s, or with clock\.control <= 0\.004 s"),
    ({"guard.dbar": [2500.0, 1.0], "actuator.delay": 0.02}, r"It holds with guard\.dbar\[1\] <= "),
    ({"guard.alpha": 4.0, "actuator.delay": 0.2},
     r"axis 1.*delay <= 0\.124 s, or from guard\.alpha >= 5\.715"),
])  # fmt: skip
def test_what_cannot_be_met_is_refused(changed: dict[str, object], said: str) -> None:
    with pytest.raises(ScenarioError) as refused:
        guard_alone(settle(load_scenario("paper-simulation", {**ON, **changed}), None))

    assert re.search(said, str(refused.value)), str(refused.value)


def test_condition_is_the_necessary_one() -> None:
    """With alpha = 1/T it is 2 dbar (T + delay) <= M_min v_u1: accepted at the edge, not beyond."""
    edge = 45.0 / (2 * 0.05)
    for factor, possible in ((1 - 1e-9, True), (1 + 1e-9, False)):
        stated = {"guard.dbar": [factor * edge, 1.0], "guard.trust": True}
        changed = {**ON, **stated, "actuator.delay": 0.04}
        scenario = load_scenario("paper-simulation", changed)
        if possible:
            assert settle(scenario, None).guard.brake[0] >= edge * factor
        else:
            with pytest.raises(ScenarioError, match="axis 1"):
                settle(scenario, None)


@pytest.mark.parametrize(("stated", "possible"), [(0.013, 1.0), (0.012, 1.0), (0.014, 0.0)])
def test_a_longer_delay_than_the_graph_was_built_for_is_not_feasible(
    stated: float, possible: float
) -> None:
    item = guard_alone(
        settle(load_scenario("paper-simulation", {**ON, "actuator.delay": 0.013}), None)
    )
    names = [name for port in item.params for name in port.signal.elements]
    item_p = np.array(item.p0)
    item_p[names.index("actuator.delay")] = stated
    run = item.function("guard", [item.d])

    assert float(run([10.0, 1.0, 0.1, 0.1], item.x0, item_p)[4]) == possible
    assert evaluated(item, [10.0, 1.0, 0.1, 0.1], item.x0)[2][4] == 1.0


def test_usable_speed_counts_the_delay() -> None:
    """On a straight line that asks for more: v_use is the speed, T + delay in place of T."""
    wide = {"guard.M_min": [25.0, 2.7], "guard.dbar": [60.0, 10.0], "clock.control": 0.05}
    still = {"disturbance.std": 0.0, "robot.mu": 0.15, "actuator.tau_max": 40.0}
    changed = {**wide, **still, **ON, "clock.duration": 40.0, "actuator.delay": 0.05}
    friction = (0.15 * 50 * 9.81, 0.0)
    scenario = load_scenario("fast-reference", changed)
    expected = usable_speed(scenario, settle(scenario, "pid").guard, friction)[0]
    run = simulate("fast-reference", "pid", overrides=changed)

    assert expected == pytest.approx(1 - (73.575 + 60) * 0.1 / 25, abs=1e-9)
    assert run["v1"][-1] == pytest.approx(expected, rel=1e-3)


def test_without_delay_the_graph_has_no_further_parameter() -> None:
    item = guard_alone(settle(load_scenario("paper-simulation", ON), None))

    assert "actuator.delay" not in {port.signal.name for port in item.params}
