"""Bases that take velocities: speed loops, the adapter of torque laws, the filter in runs."""

import math
import re
from importlib import import_module
from itertools import count
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import wmr_ctrl
from tests.control.bases import GOVERNED, VELOCITY, based
from tests.tables import cases, changes
from wmr_ctrl.cli.check_sentences import filter_lines, promise
from wmr_ctrl.control.filter.held_loop import push_speeds
from wmr_ctrl.control.filter.hypotheses import broken_hypotheses, most_torque
from wmr_ctrl.control.outside import check_takes_torques
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ArgumentError, ScenarioError
from wmr_ctrl.theory.checks import filter_facts
from wmr_ctrl.theory.checks.sending import loop_of
from wmr_ctrl.theory.checks.velocity_base import rise_times, usable_speed, velocity_base
from wmr_ctrl.theory.linear.nonlinear import loop_nlsys
from wmr_ctrl.world.effect import Bound
from wmr_ctrl.world.resistance import rolling_against
from wmr_ctrl.world.scenario import override

ROOT = Path(__file__).parents[2]


def test_the_adapter_gives_a_torque_law_the_motion_that_it_asks_for():
    """The adapter makes prox drive as on a base that takes torques, for known time constants."""
    fast = {"clock.control": 0.01, "base": {"kind": "velocity", "tau": [0.2, 0.2]}}
    velocity = wmr_ctrl.simulate(based({**VELOCITY, **fast}), "prox")
    torque = wmr_ctrl.simulate(based({**VELOCITY, **fast, "base": {}}), "prox")
    for name in ("x", "y", "v1", "omega"):
        assert velocity[name] == pytest.approx(torque[name], abs=0.02), name


def test_a_push_ends_at_the_speed_that_is_counted_and_the_filter_keeps_the_limit_then():
    """The worst gain and the largest stated push, at the limit: to 1e-4 of it."""
    reach = -0.001 / math.expm1(-0.001 / 0.2)
    d = [reach * 10.0 / 50.0, reach * 1.0 / 5.4]
    text = """
        base = {kind = "velocity", tau = [0.2, 0.2], gain = [1.1, 1.1]}
        initial.pose = [-4.0, -4.0, -0.7]
        disturbance.push = [10, 1]
        gains.kanayama.share = 1
    """
    far = {**GOVERNED, **changes(text), "filter.d": d}
    for kind in ("clip", "governor"):
        run = wmr_ctrl.simulate(based(far, {"filter.kind": kind}), "kanayama")
        assert (run.monitor.violations, run.monitor.d_least) == (0, None)
        assert run.monitor.max_abs_v[0] == pytest.approx(1.0, abs=1e-4)
    with pytest.raises(ScenarioError, match=r"filter\.d\[1\]"):
        settle(based(far, {"filter.d": [0.999 * d[0], d[1]]}), "kanayama")


@pytest.mark.slow
def test_figures_tell_how_often_the_filter_acted_with_and_without_a_log():
    scenario = based(GOVERNED, "initial.pose = [-4.0, -4.0, -0.7]; gains.kanayama.share = 1.0")
    run = wmr_ctrl.simulate(scenario, "kanayama")
    sent = np.stack([run["v_command"], run["omega_command"]])
    asked = np.stack([run["v_asked[1]"], run["v_asked[2]"]])
    shares = (sent != asked).mean(axis=1).tolist()

    assert 0 < shares[0] < 1
    assert run.summary()["filter_share"] == pytest.approx(shares)
    assert run.summary()["guard_share"] == [0.0, 0.0]
    table = wmr_ctrl.simulate_many(scenario, "kanayama", seeds=[0])
    assert [table[f"filter_share{axis}"][0] for axis in (1, 2)] == pytest.approx(shares)
    assert table["guard_share1"][0] == 0.0


OVERSHOOTING = VELOCITY | changes("""
    base = {kind = "velocity", loop = "pi"}
    robot.mu = 0
    initial.pose = [-2.0, -2.0, -0.7]
    clock.duration = 12
    filter.kind = clip
    filter.loop = pi
    filter.mass = [45.0, 55.0]
    filter.inertia = [5.0, 6.0]
    filter.kp = [140.0, 160.0]
    filter.ki = [280.0, 320.0]
""")


@pytest.mark.parametrize(
    "changed, words",
    cases("""
        base.kp = 170                       | outside filter.kp
        robot.m = 60                        | outside filter.mass
        actuator.tau_max = 20               | Leave tau_max out if commands stay low enough
        disturbance.push = [3, 0]           | filter.push[1]
        robot.mu = 0.1                      | filter.push[1]
        initial.velocity = [0, 0.3]         | at rest at the start
        resistance.rolling = [0.01, 0.01]   | filter.push[1]
        resistance.viscous = [30, 0]        | outside filter.friction = [0, 0]
        resistance.viscous = [0, 0.5]       | outside filter.friction robot.l^2
        filter.friction = [5, 20]           | resistance.viscous[1] = 0 N.s/m is outside
        base.loop = first-order             | does not fit the base of this run
        changes = [{t = 3.0, m = 54.0}]     | `changes = []` takes out
    """),
)
def test_a_pi_base_outside_the_stated_family_is_refused(changed, words):
    with pytest.raises(ScenarioError, match=re.escape(words)):
        settle(based(OVERSHOOTING, changed), "kanayama")


def test_a_refusal_names_both_axes_at_once():
    with pytest.raises(ScenarioError, match=r"filter\.d\[1\] = 1\.05.* filter\.d\[2\] = 2\.05"):
        wmr_ctrl.command_filter(based(GOVERNED, "filter.d = [1.05, 2.05]"))
    with pytest.raises(ScenarioError, match=r"base\.tau\[1\] = 9 s.* base\.tau\[2\] = 9 s"):
        settle(based(GOVERNED, "base.tau = [9.0, 9.0]"), "kanayama")


def broken(changes):
    """Return the hypotheses of a trusted filter that its base breaks, as one text."""
    setup = settle(override(based(changes), {"filter.trust": True}), "kanayama")
    return " ".join(broken_hypotheses(setup.scenario, setup.bound))


@pytest.mark.parametrize("share, said", [(0.99, False), (1.01, True)])
def test_ground_that_slows_a_turn_counts_by_the_arm_of_the_wheels(share, said):
    """Viscous friction has the arm squared; rolling resistance adds to the push of unequal
    wheels.
    """
    own = OVERSHOOTING | changes("filter.friction = [0, 20]; filter.push = [100, 100]")
    slowed = {**own, "resistance.viscous": [1.0, share * 20 * 0.25**2]}
    assert ("outside filter.friction robot.l^2" in broken(slowed)) is said
    rolled = {**own, "resistance.rolling": [0.02, 0.01]}
    setup = settle(based(rolled, "filter.trust = true"), "kanayama")
    most = setup.bound.dbar[1] + rolling_against(setup.scenario)[1]
    less = {**rolled, "filter.push": [100.0, share * most]}
    assert ("The base may be pushed by" in broken(less)) is not said


def test_what_slows_a_base_adds_to_what_pushes_it_on_both_axes():
    """Resistance adds to the pushes on both axes.

    A governor reports both in one sentence per axis; for a clip, only pushes count.
    """
    ground = changes("resistance.rolling = [0.02, 0.01]; filter.d = [1e-6, 1e-6]")
    text, clipped = broken({**GOVERNED, **ground}), broken({**CLIPPED, **ground})
    pushed = [float(x) for x in re.findall(r"push the base on by (\S+) ", clipped)]
    slowed = [float(x) for x in re.findall(r"slow the base by up to (\S+) ", text)]
    assert "push the base on by" not in text
    assert [b / a for a, b in zip(pushed, slowed, strict=True)] == pytest.approx([3, 3], rel=2e-3)


def test_no_wheel_is_asked_for_more_than_a_jump_from_limit_to_limit_takes():
    """The largest wheel torque is for a jump from limit to limit on both axes, against friction.

    It is computed for the first plant step.
    """
    scenario = based(GOVERNED)
    robot, h = scenario.robot, scenario.clock.plant
    change = [2 * V * (1 - math.exp(-h / tau)) / h
              for V, tau in zip(scenario.limits.v_u1, scenario.base.tau, strict=True)]  # fmt: skip
    forces = robot.m * change[0] + robot.mu * robot.m * robot.g, robot.I * change[1]
    wheels = np.linalg.solve(np.array([[1, 1], [robot.l, -robot.l]]) / robot.r, forces)
    assert most_torque(scenario) == pytest.approx(np.abs(wheels).max(), rel=1e-9)


def test_usable_speed_is_the_closed_form_without_delay():
    scenario = based(GOVERNED)
    facts = filter_facts(settle(scenario, "kanayama"))
    assert facts is not None
    kappa = 1 / math.expm1(0.05 / 0.2)
    k = 0.9 / 1.1
    expected = [k * (V + kappa * (V - 2 * 0.01)) / (1 + kappa * k) for V in (1.0, 2.0)]
    assert facts.usable_speed == pytest.approx(expected, rel=1e-6)
    later = filter_facts(settle(based(GOVERNED, "filter.delay = [0.0, 0.001]"), "kanayama"))
    left = [now - then for now, then in zip(facts.usable_speed, later.usable_speed, strict=True)]
    assert facts.delay_cost == pytest.approx(left, rel=1e-9)
    assert min(left) > 0
    clip = VELOCITY | changes("filter.kind = clip; filter.gain = [0.9, 1.1]")
    memoryless = filter_facts(settle(based(clip), "kanayama"))
    assert memoryless.usable_speed == pytest.approx((k, 2 * k), rel=1e-6)
    assert rise_times(based(clip)) == pytest.approx([0.05 * 0.9 * 1.1] * 2, rel=1e-6)


def test_pushes_count_for_the_lightest_robot_of_a_run_and_errors_by_the_gain():
    pushed, off = Bound(dbar=(2.0, 1.0)), Bound(command=(0.1, 0.2))
    alone = push_speeds(based(VELOCITY), pushed)
    robot = based(VELOCITY).robot
    for share, most in ((0.5, 2.0), (3.0, 1.0)):
        other = based(
            VELOCITY, {"changes": [{"t": 1.0, "m": share * robot.m, "I": share * robot.I}]}
        )
        assert push_speeds(other, pushed) == pytest.approx([most * speed for speed in alone])
        assert push_speeds(other, off) == pytest.approx((1.05 * 0.1, 0.95 * 0.2))
    assert min(alone) > 0


@pytest.mark.parametrize("stated", [VELOCITY, GOVERNED], ids=["no filter", "governor"])
def test_what_takes_torques_alone_names_all_that_has_to_change(stated):
    with pytest.raises(ScenarioError, match="packages only for robots that take wheel") as refused:
        check_takes_torques(based(stated), "packages")
    remedy = str(refused.value).partition("Use one")[2]
    told = dict(re.findall(r'((?:base|filter)\.kind) = "(\w+)"', remedy))

    assert told == {"base.kind": "torque"} | ({"filter.kind": "none"} if stated is GOVERNED else {})
    check_takes_torques(override(based(stated), told), "packages")


def test_commands_that_grow_evenly_rise_in_the_time_that_they_take(monkeypatch):
    """The rise time is to nine tenths of the limits, also between two samples."""
    sent = (SimpleNamespace(command=(0.7 * 0.05 * k, 0.9 * 0.05 * k)) for k in count(1))
    ramp = SimpleNamespace(step=lambda _: next(sent))
    module = import_module(rise_times.__module__)  # the package has a function of its name
    monkeypatch.setattr(module, "CommandFilter", lambda _: ramp)

    assert rise_times(based(GOVERNED)) == pytest.approx([0.9 * 1.0 / 0.7, 0.9 * 2.0 / 0.9])


@pytest.mark.parametrize("noise, told", [("", True), ("disturbance.truncate = 3", False)])
def test_check_says_where_noise_keeps_a_limit_with_a_probability_only(noise, told):
    noisy = CLIPPED | changes("filter.d = [0.3, 0.8]; disturbance.std = 0.5") | changes(noise)
    warnings = velocity_base(loop_of(settle(based(noisy), "kanayama")))
    assert ("disturbance.truncate" in [item.key for item in warnings]) == told


def test_check_promises_no_limit_that_a_start_breaks():
    text = promise(settle(based(CLIPPED, "initial.velocity = [1.1, 0.0]"), "kanayama"))
    assert "guaranteed for starts within them alone" in text
    assert "alone" not in promise(settle(based(CLIPPED), "kanayama"))


def test_check_counts_on_no_odometry_that_is_too_old_to_be_used():
    """The usable speed is computed without odometry that is too old to be used.

    Odometry within ``filter.age`` is reported as usual.
    """
    late = {**GOVERNED, "sensor.velocity_age": 0.1}
    deaf = settle(based(late, "filter.age = 0.05"), "kanayama")
    alone = settle(based(GOVERNED, {"filter.odometry": None}), "kanayama")
    assert usable_speed(deaf.scenario) == usable_speed(alone.scenario)
    assert "odometry" not in " ".join(filter_lines(deaf))
    (warning,) = (item for item in velocity_base(loop_of(deaf)) if item.key == "filter.age")
    assert "Raise filter.age to 0.1 s" in warning.sentence
    hearing = settle(based(late, "filter.age = 0.1"), "kanayama")
    assert usable_speed(hearing.scenario) > usable_speed(alone.scenario)
    assert "with odometry in every step" in " ".join(filter_lines(hearing))


@pytest.mark.parametrize("wheels", ["filter.channels = wheels", "filter.wheel_speed = 0.8"])
@pytest.mark.parametrize("kind", ["clip", "governor"])
def test_check_says_what_a_filter_of_wheels_leaves(kind, wheels):
    text = f"""
        filter.kind = {kind}
        filter.d = [0.05, 0.02]
        base.tau = [0.2, 0.2]
        base.gain = [1.0, 1.0]
        robot.mu = 0
        {wheels}
    """
    scenario = based(GOVERNED, text)
    facts = filter_facts(settle(scenario, "kanayama"))
    l = scenario.robot.l
    rim = min(1.0, 2.0 * l) if "channels" in wheels else 0.8
    ahead = 0.9 * min(1.0 - 0.05, rim - 0.05 - l * 0.02) / 1.1 - 0.05
    turning = 0.9 * min(2.0 - 0.02, (rim - 0.05 - l * 0.02) / l) / 1.1 - 0.02
    assert facts.usable_speed == pytest.approx((ahead, turning), rel=1e-6)


def overshooting(kind, text=""):
    """Setup and facts of a base whose loops overshoot."""
    setup = settle(based(OVERSHOOTING, {"filter.kind": kind, **changes(text)}), "kanayama")
    return setup, filter_facts(setup), " ".join(filter_lines(setup))


def test_check_says_what_a_clip_of_loops_that_overshoot_leaves():
    _, facts, told = overshooting("clip")
    shares = np.array(facts.usable_speed) / (1.0, 2.0)
    assert "linear loops" in facts.statement
    assert facts.delay_cost == (0.0, 0.0)
    assert 0.5 < shares.min() <= shares.max() <= 1.0
    assert shares.max() > 1 / facts.gain > shares.min() - 1e-6
    assert facts.gain_cost == pytest.approx([0.0099 * s for s in facts.usable_speed], rel=2e-3)
    assert min(facts.overshoot) > 0.1
    assert "millisecond of delay costs" in told
    taken = facts.overshoot_cost / shares
    assert 0.01 < taken.min() <= taken.max() < 0.06


@pytest.mark.slow
def test_check_says_what_a_band_leaves_and_how_soon():
    setup, facts, told = overshooting("band")
    shares = np.array(facts.usable_speed) / (1.0, 2.0)
    assert 0.98 < shares.min() <= shares.max() <= 1.0
    assert min(facts.overshoot) > 0.1
    assert "a constant delay costs nothing" in told
    assert 0.3 < min(facts.rise) < max(facts.rise) < 4.0
    step = wmr_ctrl.command_filter(override(setup.scenario, {"filter.scale": "axes"}))
    sent = [0.0, *(step.step((10.0, 20.0)).command[0] for _ in range(100))]
    times = setup.scenario.clock.control * np.arange(101)
    assert facts.rise[0] == pytest.approx(np.interp(0.9, sent, times), rel=1e-9)
    assert 0.0 < min(facts.rise_cost) < max(facts.rise_cost) < 0.5
    taken = facts.overshoot_cost / shares
    assert -1e-6 < taken.min() <= taken.max() < 0.06


@pytest.mark.parametrize(
    "changed, words",
    cases("""
        base.loop = pi                              | never exceed their command
        base.tau = [0.19, 0.2]                      | outside filter.tau               | slow
        base.gain = [1.11, 1]                       | outside filter.gain
        base.gain = [1, 0.89]                       | outside filter.gain              | slow
        base.delay = 0.01                           | outside filter.delay
        disturbance.push = [5, 0]                   | filter.d[1]                      | slow
        filter.channels = wheels                    | the loops of v and omega differ  | slow
        filter.wheel_speed = 0.8                    | the loops of v and omega differ  | slow
        resistance.rolling = [0.1, 0.1]             | slow the base by up to           | slow
        resistance.viscous = [0, 2]                 | slow the base by up to           | slow
        actuator.tau_max = 20                       | slower than first order          | slow
        base.timeout = 0.04                         | the base stops before the next command
        actuator.traction = true                    | actuator.traction limits tau_max | slow
        base.decel = [1, 1]                         | base.decel: the base ramps       | slow
        actuator.lag = 0.01                         | behind the speed loop            | slow
        sensor.velocity_noise = [0.02, 0]           | filter.odometry[1]               | slow
        sensor.velocity_window = 0.1                | a mean over some time            | slow
        encoder.counts = 20; encoder.method = time  | a mean over some time            | slow
    """),
)
def test_what_the_theorem_does_not_cover_is_refused_unless_trusted(changed, words):
    broken = based(GOVERNED, changed)
    with pytest.raises(ScenarioError, match=re.escape(words)):
        settle(broken, "kanayama")
    trusted = override(broken, {"filter.trust": True})
    facts = filter_facts(settle(trusted, "kanayama"))
    assert any(words in sentence for sentence in facts.broken)


CLIPPED = VELOCITY | changes("""
    clock.duration = 2
    filter.kind = clip
    filter.gain = [0.9, 1.1]
    filter.d = [0.1, 0.1]
""")


@pytest.mark.parametrize("pushed", [[20.0, 0.0], [0.0, 1.9]])
def test_a_clip_counts_on_motors_that_hold_against_pushes(pushed):
    """Weak ones are refused; the torque that is named is enough, and never reached."""
    weak = based(CLIPPED, {"disturbance.push": pushed, "actuator.tau_max": 0.1, "robot.mu": 0.0})
    with pytest.raises(ScenarioError, match=r"actuator\.tau_max = 0\.1 N\.m: a wheel") as error:
        settle(weak, "kanayama")
    named = float(str(error.value).split("Raise it to ")[1].split(" N.m")[0])
    settle(override(weak, {"actuator.tau_max": named}), "kanayama")
    strong = override(weak, {"actuator.tau_max": math.inf})
    run = wmr_ctrl.simulate(strong, "kanayama", engine="numpy")
    assert max(np.abs(run[side]).max() for side in ("tau_right", "tau_left")) < named
    settle(override(weak, {"disturbance.push": [0.0, 0.0]}), "kanayama")


@pytest.mark.parametrize(
    "changed, key",
    cases("""
        base.accel = [1, 9]                       | none
        base.decel = [1, 9]                       | base.decel
        base.accel = [2, 8]; base.decel = [1, 4]  | base.accel
        base.accel = [1, 6]; base.decel = [1, 6]  | base.accel
        base.accel = [1, 4]; base.jerk = [9, 9]   | base.jerk
        actuator.tau_max = 0.5                    | actuator.tau_max
        base.accel = [1, 4]                       | none
        base.accel = [1, 4]; base.decel = [1, 9]  | none
        base.accel = [1, 2]; base.decel = [0.5, 4] | none
    """),
)
def test_a_limit_of_wheels_speeds_is_refused_where_one_axis_is_held_back(changed, key):
    """The limit on wheel speeds holds if each axis stops at least as fast as the other starts.

    Rates of omega are compared at a wheel, 0.25 m out.
    """
    alike = changes("filter.wheel_speed = 0.8; base.tau = [0.2, 0.2]; robot.mu = 0")
    stated = based(CLIPPED | alike, changed)
    if key == "none":
        settle(stated, "kanayama")
        return
    with pytest.raises(ScenarioError, match=f"{key} may hold back one of v and omega") as refused:
        settle(stated, "kanayama")
    soon = re.search(r"or state base\.decel = (\[.*\]) or more", str(refused.value))
    if soon:
        settle(override(stated, {"base.decel": soon[1]}), "kanayama")
    assert bool(soon) is (key in ("base.accel", "base.decel") and "base.accel" in changed)


@pytest.mark.parametrize(
    "changed, key",
    cases("""
        guard.enabled = true                                | base.kind
        gains.kanayama.delay = 0.05; base.delay = 0.05      | base.kind
        actuator.delay = 0.01                               | actuator.delay
        actuator.jitter = 0.01                              | actuator.jitter
    """),
)
def test_what_a_velocity_base_cannot_have_is_refused_by_name(changed, key):
    with pytest.raises(ScenarioError, match=key):
        settle(based(VELOCITY, changed), "kanayama")
    with pytest.raises((ScenarioError, ArgumentError), match=r'base\.kind = "velocity"'):
        loop_nlsys(based(VELOCITY), "kanayama")


@pytest.mark.parametrize(
    "changed",
    cases("""
        base.losses = 1
        base.losses = 1; base.timeout = 0.06
        base.timeout = 0.04
        base.deadband = [0.02, 0.02]
        base.quantum = [0.01, 0.01]
        base.accel = [1.0, 2.0]
        base.jerk = [5.0, 5.0]
        base.w_max = 12
        actuator.tau_max = 20
        changes = [{t = 2.0, m = 52.0}]
        actuator.lag = 0.02
    """),
)
def test_what_the_band_leaves_open_is_refused_by_name(changed):
    with pytest.raises(ScenarioError, match="nothing here"):
        settle(based(OVERSHOOTING, {"filter.kind": "band", **changes(changed)}), "kanayama")
