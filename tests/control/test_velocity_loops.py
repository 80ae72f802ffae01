"""Speed loops of second order, and axes whose loops differ."""

import math

import casadi as ca
import numpy as np
import pytest

import wmr_ctrl
from tests.papers_robot import preset
from tests.tables import cases, changes
from wmr_ctrl.cli.check_sentences import idle_keys
from wmr_ctrl.control.filter.held_loop import push_speeds
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.effect import Bound
from wmr_ctrl.world.model.dynamics import plant, rk4_step
from wmr_ctrl.world.scenario import loads_scenario, override
from wmr_ctrl.world.scenario.toml_io import to_toml
from wmr_ctrl.world.speed_loops import SPEED_LOOP

SECOND = changes("""
    base.kind = velocity
    base.loop = second-order
    base.frequency = [6.0, 9.0]
    base.damping = [0.4, 1.3]
    base.gain = [1.1, 0.9]
    guard.enabled = false
    robot.mu = 0.0
    clock.control = 0.05
    clock.duration = 6.0
    changes = []
""")
DRIVEN = ("x", "y", "v1", "omega")


def base(text=""):
    return preset("paper-simulation-noise-free", SECOND, text)


def driven(scenario, commands, push=(0.0, 0.0)):
    """Velocities (n, 2) after each plant step under commands (n, 2), from the graphs themselves."""
    loop, robot = SPEED_LOOP.system(scenario), plant(scenario)
    act = loop.function("act", [loop.update, loop.y])
    h = ca.SX.sym("h")
    step = ca.Function("step", [robot.u, robot.x, robot.p, h], [rk4_step(robot, h)])
    x, own, speeds = np.zeros(5), np.array(loop.x0), []
    for command in commands:
        own, torque = act([*command, x[3], x[4]], own, loop.p0)
        moved = step(ca.vertcat(torque, 0, 0, *push), x, robot.p0, scenario.clock.plant)
        x = moved.full().ravel()
        speeds.append(x[3:])
    return np.array(speeds)


@pytest.mark.slow_but("0.6")
@pytest.mark.parametrize("damping", [0.3, 0.6, 1.5])
def test_pushes_on_a_second_order_loop_lead_no_farther_than_is_counted(damping):
    """The worst push changes its sign with its effect, and nearly reaches the bound."""
    scenario, h, w = base(f"base.damping = {damping}"), 0.001, 6.0
    mass = scenario.robot.m
    shares = driven(scenario, np.zeros((4000, 2)), (1.0, 0.0))[:, 0] * mass  # of a steady push
    effect = np.diff(shares, prepend=0.0)  # of the push in one step
    reached = np.abs(effect).sum()
    turn = math.pi * damping / math.sqrt(max(1 - damping**2, 1e-9))
    peak = 1 / math.tanh(turn / 2) if damping < 1 else 1.0
    told = push_speeds(scenario, Bound(dbar=(mass, 0.0)))[0] * peak
    assert reached <= told
    assert reached == pytest.approx(told, abs=1.5 * h * peak)
    assert shares[-1] == pytest.approx(2 * damping / w, rel=5e-3)


MIXED = {
    "pi and second": 'base.loop = ["pi", "second-order"]; base.kp = 150; base.ki = 300',
    "first and pi": 'base.loop = ["first-order", "pi"]; base.kp = 150; base.ki = 300',
    "second": "base.loop = second-order",
}


@pytest.mark.parametrize("name", MIXED)
def test_each_axis_follows_by_its_own_loop(name):
    """An axis moves as in a base where both axes have its loop, if no wheel torque saturates."""
    mixed = base(MIXED[name])
    commands = np.repeat(np.random.default_rng(4).uniform(-1, 1, (10, 2)), 40, axis=0)
    speeds = driven(mixed, commands)
    for axis, own in enumerate(mixed.base.loop):
        alike = driven(override(mixed, {"base.loop": own}), commands)
        assert speeds[:, axis] == pytest.approx(alike[:, axis], abs=1e-9), own


@pytest.mark.slow_but("pi and second")
@pytest.mark.parametrize("name", MIXED)
def test_engines_and_lanes_agree(name):
    scenario = override(base(MIXED[name]), {"actuator.tau_max": 20.0})
    native, numpy = (wmr_ctrl.simulate(scenario, "prox", engine=e) for e in ("native", "numpy"))
    for column in DRIVEN:
        assert native[column] == pytest.approx(numpy[column], abs=1e-9), column
    table = wmr_ctrl.simulate_many(scenario, "prox", seeds=range(4), figures=["position_rms"])
    assert table["position_rms"] == pytest.approx([native.summary()["position_rms"]["all"]] * 4)


def test_a_value_for_both_axes_or_one_for_each():
    alike = base("base.frequency = 7.0; base.damping = 0.5; base.loop = second-order")
    assert alike == base("base.frequency = [7.0, 7.0]; base.damping = [0.5, 0.5]")
    assert alike.base.loop == ("second-order", "second-order")
    mixed = base('base.loop = ["first-order", "pi"]; base.tau = 0.3 s')
    assert loads_scenario(to_toml(mixed), mixed.name) == mixed
    assert mixed.base.tau == (0.3, 0.3)


@pytest.mark.parametrize(
    "wrong, words",
    cases(r"""
        base.loop = third              | base\.loop = "third" is not known
        base.loop = ["pi"]             | base\.loop .* must be one for both, or an array of 2
        base.loop = ["pi", "third"]    | base\.loop\[2\] = "third" is not known
        base.tau = [0.1, 0.2, 0.3]     | base\.tau .* one for both, or an array of 2 numbers
        base.frequency = 0.0           | base\.frequency = 0\.0 must be above 0
    """),
)
def test_bad_loops_are_refused_by_name(wrong, words):
    with pytest.raises(ScenarioError, match=words):
        override(base(), changes(wrong))


def test_keys_of_another_loop_do_nothing():
    """Keys of another loop are listed as idle, so a file that extends another may keep them."""
    extended = base("base.tau = 0.7; base.kp = 9.0")
    assert {"base.tau", "base.kp"} <= {*idle_keys(extended)}
    assert not {"base.gain", "base.frequency", "base.damping"} & {*idle_keys(extended)}
    mixed = base('base.tau = 0.7; base.kp = 9; base.loop = ["first-order", "second-order"]')
    assert "base.tau" not in idle_keys(mixed)
    assert "base.kp" in idle_keys(mixed)


FILTERED = changes("""
    filter.kind = clip
    filter.loop = second-order
    filter.gain = [0.8, 1.2]
    filter.damping = [0.35, 1.4]
    filter.frequency = [5.0, 10.0]
""")


@pytest.mark.parametrize(
    "changed, words",
    cases(r"""
        base.frequency = 4                    | base\.frequency\[1\] = 4 rad/s is outside
        base.damping = [0.3, 1]               | base\.damping\[1\] = 0\.3 is outside
        base.gain = 1.3                       | base\.gain\[1\] = 1\.3 is outside
        disturbance.push = [2, 0]             | filter\.d\[1\] = 0 m/s is less
        robot.mu = 0.01                       | filter\.d\[1\] = 0 m/s is less
        initial.velocity = [0.2, 0]           | at rest at the start
        actuator.tau_max = 20                 | Leave tau_max out
        base.loop = ["second-order", "pi"]    | base\.loop = \["second-order", "pi"\]
    """),
)
def test_a_second_order_base_outside_the_stated_family_is_refused(changed, words):
    own = {"initial.velocity": [0, 0], **FILTERED, **changes(changed)}
    with pytest.raises(ScenarioError, match=words):
        settle(override(base(), own), "kanayama")
