"""Settings that cannot be met are refused, with the inequality, the numbers and a remedy."""

import math
import re

import pytest

from tests.tables import cases, changes
from wmr_ctrl.control.controller import guard
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.control.guard.refusals import feasible_guard
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.effect import Bound
from wmr_ctrl.world.scenario import load_scenario

ON = {"guard.enabled": True}


@pytest.mark.parametrize(
    "changed, said",
    cases(r"""
        guard.dbar = [2500, 1]  | 2 \(dbar - f_min\) <= M_min alpha.*axis 1.*5000 > 45 \* 100
        guard.dbar = [60, 400]  | axis 2.*clock\.control <= .*guard\.dbar\[2\] <=
        clock.control = 0.5; guard.M_min = [25, 2.7]   | clock\.control <= 0\.208 s
        guard.alpha = 1         | axis 1.*guard\.alpha >= 2\.667 1/s
        guard.alpha = 101       | alpha T <= 1.*Lower it to 100
        guard.nbar = [0.6, 0]   | 2 nbar <= v_u1.*it is 1\.2, and
        actuator.tau_max = 5    | dbar\[1\] \+ dbar\[2\]/l.*120 > 100 N.*tau_max >= 6 N m
        guard.brake = [50, 20]  | guard\.brake\[1\] = 50.*at least.*60
        guard.brake = [90, 30]; actuator.tau_max = 10  | brake\[1\] \+ brake\[2\]/l.*210
        guard.M_min = [80, 8]   | guard\.M_min\[1\] = 80.* must be at most
        guard.M_min = [80, 8]; guard.M_max = [70, 9]   | M_min\[1\].*at most
        guard.f_speed = [1, 0]  | f_speed\[1\].*below limits
        guard.map = clip        | guard\.map.*linear-first, rotation-first
        guard.dbar = [1.0]      | guard\.dbar.*array of 2
        guard.dbar = [600, 1]; actuator.delay = 0.04   | alpha delay\), delay = 0\.04 s, is needed
        guard.dbar = [600, 1]; actuator.delay = 0.04   | axis 1.*1200 > 45 \* 100 \* 1/5 = 900 N
        guard.dbar = [600, 1]; actuator.delay = 0.04   | actuator\.delay <= 0\.027 s.* 449\.9 N
        guard.dbar = [600, 1]; actuator.delay = 0.04   | of at least 60\.\d+ kg
        guard.dbar = [60, 260]; actuator.delay = 0.01  | axis 2.*\.delay <= 0\.004 s, .* <= 0\.004 s
        guard.dbar = [2500, 1]; actuator.delay = 0.02  | It holds with guard\.dbar\[1\] <=
        guard.alpha = 4; actuator.delay = 0.2          | axis 1.*<= 0\.124 s, .*alpha >= 5\.715
    """),
)
def test_what_cannot_be_met_is_refused(changed, said):
    with pytest.raises(ScenarioError, match=said):
        guard(settle(scenario_of("paper-simulation", ON | changes(changed)), None))


@pytest.mark.parametrize("beyond", [1.0, 1.1])
def test_a_command_may_take_over_one_period_late_and_no_later(beyond):
    """J <= T, also at the edge."""
    scenario = load_scenario("far-start", ON)
    bound = Bound(delay=0.03, jitter=0.01 * beyond)
    if beyond == 1.0:
        assert feasible_guard(scenario, bound, math.inf).jitter == pytest.approx(0.01)
        return
    with pytest.raises(ScenarioError, match=r"varies by 0\.011 s, more than clock\.control"):
        feasible_guard(scenario, bound, math.inf)


@pytest.mark.parametrize("late", [{"age": (0.01, 0.0)}, {"window": (0.01, 0.0)}])
def test_a_moving_start_needs_a_velocity_that_is_not_late(late):
    """A moving start is refused where the velocity of the same axis is late.

    The velocity of the other axis may be late.
    """
    moving, turning = (
        load_scenario("far-start", {**ON, "initial.velocity": start})
        for start in ([0.5, 0], [0, 1])
    )
    with pytest.raises(ScenarioError, match=r"initial\.velocity\[1\] = 0\.5.*Start at rest"):
        feasible_guard(moving, Bound(**late), math.inf)
    assert feasible_guard(turning, Bound(**late), math.inf)


def reads_the_limit(share):
    """Return a bound on pushes that includes a share of the wheels' largest force."""
    return lambda scenario: Bound(
        dbar=(60.0 + share * 2 * scenario.actuator.tau_max / scenario.robot.r, 15.0)
    )


@pytest.mark.parametrize("share", [0.0, 0.02, 0.5, 0.9])
@pytest.mark.slow_but("0.0", "0.5")
def test_the_torque_that_is_enough_is_enough_though_bounds_read_it(share):
    def settled(limit):
        scenario = scenario_of("far-start", {"actuator.tau_max": limit})
        return feasible_guard(scenario, bound(scenario), limit, bound)

    bound = reads_the_limit(share)
    with pytest.raises(ScenarioError) as refused:
        settled(1.0)
    (said,) = re.findall(r"tau_max >= (\S+) N m", str(refused.value))

    assert float(said) == pytest.approx(6.0 / (1.0 - share), rel=2e-3)
    assert settled(float(said)).dbar[0] >= 60.0
    with pytest.raises(ScenarioError, match="cannot hold the robot"):
        settled(0.998 * float(said))


@pytest.mark.parametrize("share", [0.97, 1.0, 2.0])
def test_a_torque_limit_is_not_proposed_where_none_is_enough(share):
    """At 0.97 there is one that the wheels need, but dbar is too large for the period there."""
    bound, scenario = reads_the_limit(share), scenario_of("far-start", {"actuator.tau_max": 4.0})

    with pytest.raises(ScenarioError, match=r"No tau_max is enough: .* with tau_max") as told:
        feasible_guard(scenario, bound(scenario), 4.0, bound)
    assert "tau_max >=" not in str(told.value)


def test_defaults_follow_from_the_scenario():
    scenario = load_scenario("paper-simulation-no-switch", ON)
    setup = settle(scenario, None)
    settled = setup.guard

    assert settled.M_min == pytest.approx((45.0, 4.86))
    assert settled.M_max == pytest.approx((55.0, 5.94))
    assert setup.bound.dbar == pytest.approx((60.0, 15.0))
    assert settled.dbar == pytest.approx((60.0, 15.0))
    assert settled.nbar == (0.0, 0.0)
    assert settled.alpha == pytest.approx(100.0)
    assert settled.brake == pytest.approx((45.0 * 100 - 60, 4.86 * 100 * 1.5 - 15))
    given = load_scenario("paper-simulation", {**ON, "guard.M_min": [30.0, 3.0]})
    assert settle(given, None).guard.M_min == (30.0, 3.0)


@pytest.mark.parametrize(
    "changed",
    [
        "disturbance.std = 6",
        "guard.dbar = [300, 100]",
        "guard.dbar = [2500, 1]",
        "actuator.lag = 0.3",
        "actuator.delay = 0.3",
        "guard.alpha = 1; clock.control = 0.05",
        "guard.alpha = 1.7; clock.control = 0.05; guard.dbar = [130, 15]",
    ],
)
def test_every_number_that_is_proposed_is_enough_as_it_is_printed(changed):
    """Every proposed number suffices as printed, for every key.

    Numbers about the scenario itself (sum of pushes, mass of the robot) suffice as well.
    """

    def told(more):
        try:
            settle(scenario_of("safe-experiment", ON | changes(changed) | more), "prox")
        except ScenarioError as error:
            return str(error)
        return ""

    text = told({})
    axis = int(re.search(r"on axis (\d)", text)[1])
    number = r"([\d.e+-]+\d)"
    keys = re.findall(rf"(guard\.dbar\[\d\]|guard\.alpha) [<>]= {number}", text)
    remedies = [{key: float(value)} for key, value in keys]
    off = changes(f"{changed}; guard.enabled = false")
    derived = settle(scenario_of("safe-experiment", off), "prox")
    for name, value in [
        *(("dbar", value) for value in re.findall(rf"add up to at most {number}", text)),
        *(("M_min", value) for value in re.findall(rf"robot of at least {number}", text)),
    ]:
        whole = list(derived.guard.dbar if name == "dbar" else derived.guard.M_min)
        whole[axis - 1] = float(value)
        remedies.append({f"guard.{name}": whole, "guard.trust": True})
        remedies[-1] |= changes("guard.M_max = [1e3, 1e3]") if name == "M_min" else {}
    for row in re.findall(r"with guard\.M_min = (\[.*?\]) or more", text):
        remedies.append({"guard.M_min": row})
    left, right = re.search(r"but (\S+) > (?:.* = )?(\S+) N", text).groups()

    assert len(remedies) >= 2
    assert left != right
    for more in remedies:
        again = told(more)
        assert f"limits.v_u1[{axis}]" not in again, (more, again)


@pytest.mark.parametrize(
    "late, said, spared",
    cases("""
        actuator.delay = {}; actuator.jitter = 0          | actuator.delay          | 0
        actuator.delay = {}; actuator.jitter = 0.005      | actuator.delay + jitter | 0.005
        guard.delay = [{0}, {0}]; actuator.jitter = 0     | guard.delay[2]          | 0
    """),
)
def test_the_delay_that_is_said_to_be_short_enough_is(late, said, spared):
    """The longest delay that the message names is accepted.

    It includes all delays of a command, in whole plant steps. A stated ``guard.delay`` comes first.
    """

    def settled(delay):
        given = changes(late.format(round(delay - float(spared), 9)))
        guard(settle(scenario_of("robot-10ms", given), None))

    with pytest.raises(ScenarioError) as refused:
        settled(0.1)
    name, most = re.search(r"It holds with (\S.*?) <= (\S+) s", str(refused.value)).groups()

    assert name == said
    settled(float(most))
