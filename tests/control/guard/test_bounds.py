"""Numbers that the guard derives if a scenario omits them."""

import math
from dataclasses import replace

import casadi as ca
import pytest

from tests.tables import changes
from wmr_ctrl.control.guard.bounds import MODEL, assumption_sources, derived_guard, reach
from wmr_ctrl.control.guard.delay import Tails, delayed_push
from wmr_ctrl.control.guard.guard import bounds_of, ceiling, feasible
from wmr_ctrl.control.guard.price import early_speed, unbeatable_speed, usable_speed
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.effect import Bound
from wmr_ctrl.world.model.system import Parameters, stack, values
from wmr_ctrl.world.scenario import load_scenario

ON = {"guard.enabled": True}


def derived(**changed):
    return settle(load_scenario("paper-simulation-no-switch", {**ON, **changed}), None).guard


def test_a_slope_pulls_at_the_heaviest_robot_that_is_counted_on():
    slope, pull = {"slope.angle": 0.05}, 9.81 * math.sin(0.05)
    light, heavy = derived(**slope), derived(**slope, **changes("guard.M_max = [70.0, 9.0]"))

    assert light.dbar[0] - derived().dbar[0] == pytest.approx(1.1 * 50.0 * pull, rel=1e-9)
    assert heavy.dbar[0] - light.dbar[0] == pytest.approx((70.0 - 55.0) * pull, rel=1e-9)


TRUE = [
    changes("robot.m = 90.0; robot.I = 9.0; robot.mu = 0.3"),
    changes("robot.m = 20.0; robot.I = 2.0; robot.mu = 0.0"),
    changes("changes = [{t = 1.0, m = 90.0, I = 9.0, mu = 0.3}]"),
]
EFFECTS = changes("""
    slope.angle = 0.05
    slope.offset = 0.02
    resistance.rolling = [0.02, 0.01]
""")


@pytest.mark.parametrize("true", TRUE)
def test_no_number_follows_the_true_robot(true):
    """The guard's numbers follow from the believed robot, whichever robot is driven."""
    believed = {"model.m": 30.0, "model.I": 3.0, "model.mu": 0.05, **EFFECTS}
    guard = derived(**believed, **true)

    assert guard == derived(**believed)
    assert (guard.M_min, guard.M_max) == (pytest.approx((27, 2.7)), pytest.approx((33, 3.3)))


LATE = Bound(dbar=(20.0, 3.0), nbar=(0.05, 0.08), mass=(3.0, 0.2), age=(0.004, 0.002),
             window=(0.02, 0.01), delay=0.012, jitter=0.004, lag=(0.01, 0.03))  # fmt: skip


def late(**changed):
    """Scenario and numbers of a guard with everything that an effect can add."""
    scenario = load_scenario("far-start", {**ON, **changed})
    return scenario, derived_guard(scenario, LATE, math.inf)


@pytest.mark.parametrize("i", [0, 1])
def test_what_effects_add_to_a_mass_widens_what_is_counted(i):
    """The mass that effects add widens derived mass bounds equally on both sides.

    Stated mass bounds stay as they are.
    """
    scenario, guard = late()
    alone = derived_guard(scenario, replace(LATE, mass=(0.0, 0.0)), math.inf)
    _, stated = late(**changes("guard.M_min = [40.0, 4.0]; guard.M_max = [60.0, 6.5]"))

    assert guard.M_min[i] == pytest.approx(alone.M_min[i] - LATE.mass[i])
    assert guard.M_max[i] == pytest.approx(alone.M_max[i] + LATE.mass[i])
    assert (stated.M_min, stated.M_max) == ((40.0, 4.0), (60.0, 6.5))


@pytest.mark.parametrize("i", [0, 1])
def test_the_speed_that_no_guard_beats_counts_each_part(i):
    """v_u1 - nbar - (friction + dbar) (T + age + delay)/M_min, calculated here by hand."""
    scenario, guard = late()
    best, friction = unbeatable_speed(scenario, guard, (39.0, 2.0)), (39.0, 2.0)
    limit, mass = (1.0, 1.5)[i], (0.9 * 50.0 - 3.0, 0.9 * 5.4 - 0.2)[i]
    time = 0.01 + LATE.age[i] + 0.012

    lost = LATE.nbar[i] + (friction[i] + LATE.dbar[i]) * time / mass
    assert best[i] == pytest.approx(limit - lost, rel=1e-9)


@pytest.mark.parametrize(
    "tau_max, brake",
    [(0.5, (20.0, 3.0)), (3.0, (28.4, 7.9)), (8.0, (58.4, 25.4)), (1e3, (532.63158, 106.21875))],
)
def test_brakes_hold_against_pushes_and_share_what_else_the_wheels_give(tau_max, brake):
    """No axis brakes harder than its reach less its push."""
    scenario = load_scenario("far-start", {**ON, "guard.brake_share": 0.3})

    assert derived_guard(scenario, LATE, tau_max).brake == pytest.approx(brake, rel=1e-6)


@pytest.mark.parametrize("i", [0, 1])
def test_before_the_first_command_acts_a_push_has_delay_and_lag(i):
    _, guard = late()

    assert early_speed(guard)[i] == pytest.approx((0.012 + 0.03) * LATE.dbar[i] / guard.M_min[i])


def test_where_drives_vary_the_mixed_time_caps_what_brakes():
    """M_min (v_u1 - 2 nbar)/mixed, with an error so large that this is the smaller of the two
    caps.
    """
    noisy = replace(LATE, nbar=(0.49, 0.735))
    scenario, still = late()
    guard = derived_guard(scenario, noisy, math.inf)
    for i, limit in enumerate((1.0, 1.5)):
        mixed = LATE.age[i] + LATE.window[i] / 2 + 0.012 + 0.03
        capped = guard.M_min[i] * (limit - 2 * noisy.nbar[i]) / mixed

        assert reach(scenario, guard, i) == pytest.approx(capped, rel=1e-9)
        assert reach(scenario, guard, i) < 0.5 * reach(scenario, still, i)


def test_what_is_counted_adds_up_to_the_guard_s_numbers():
    """The effects and guard.d_model add up to each of the guard's numbers."""
    effects = changes("""
        encoder.counts = 4096.0
        actuator.delay = 0.02
        actuator.jitter = 0.01
        disturbance.push = [5.0, 1.0]
        guard.d_model = [7.0, 3.0]
        disturbance.truncate = 3.0
    """)
    setup = settle(load_scenario("far-start", {**ON, **effects}), None)
    known = assumption_sources(setup.scenario, setup.guard, setup.effects)

    assert set(known["dbar"].sources) == {"torque noise", "push", "guard.d_model"}
    for name in ("dbar", "nbar", "delay", "lag", "age", "window"):
        added = [pair for pair in known[name].sources.values() if pair is not None]
        total = tuple(sum(pair[i] for pair in added) for i in (0, 1))
        assert known[name].value == pytest.approx(total, abs=1e-15), name
    assert set(known["M_min"].sources) == {MODEL}
    assert known["delay"].value == pytest.approx((0.02, 0.03))


GRAPHED = {"sensor.velocity_window": 0.03, "actuator.delay": 0.013, "guard.dbar": [40.0, 8.0],
           "sensor.velocity_noise": [0.02, 0.03], "disturbance.std": 0.0, **ON}  # fmt: skip


def graphed(**changed):
    """Settings, both axes' bounds in the graph, and a function from symbols to their numbers."""
    setup = settle(load_scenario("paper-simulation-no-switch", {**GRAPHED, **changed}), None)
    p, late = Parameters(setup), setup.guard.lateness(setup.scenario.clock)
    axes = [bounds_of(p, late, setup.scenario.limits).axis(i) for i in (0, 1)]

    def numbers(symbols):
        names, given = stack(item.sym for item in p.ports), values(p.ports)
        return ca.Function("found", [names], [symbols])(given).full().ravel().tolist()

    return setup, late, axes, numbers


@pytest.mark.parametrize("changed", [{}, {"actuator.jitter": 0.004}, {"actuator.lag": 0.02}])
def test_reach_is_what_the_graph_brakes_with_and_what_holds_against(changed):
    setup, _, axes, numbers = graphed(**changed)
    held = ca.vertcat(*(b.cap + b.net for b in axes), *map(feasible, axes))
    first, second, *met = numbers(held)

    assert reach(setup.scenario, setup.guard, 0) == pytest.approx(first, rel=1e-12)
    assert reach(setup.scenario, setup.guard, 1) == pytest.approx(second, rel=1e-12)
    assert met == [1.0, 1.0]


@pytest.mark.parametrize("i", [0, 1])
def test_at_the_usable_speed_the_graph_s_ceiling_is_the_friction(i):
    """The ceiling equals the friction for a robot that has long driven at the usable speed.

    All commands in transit equal the friction, too.
    """
    setup, late, axes, numbers = graphed()
    friction = (39.24, 2.0)
    b, speed = axes[i], usable_speed(setup.scenario, setup.guard, friction)[i]
    sent = [ca.SX(ca.DM(friction))] * late[i].commands
    coming = delayed_push(sent, late[i], i, b, Tails("tail", late))
    (highest,) = numbers(ceiling(ca.SX(speed), b, coming))

    assert late[i].commands > 1
    assert highest == pytest.approx(friction[i], rel=1e-9)
