"""Bounds of v and of omega stated separately: each axis gets the commands it would get alone."""

import numpy as np
import pytest

from tests.control.filter.test_filter import STATED, scenario
from tests.papers_robot import preset
from tests.tables import cases, changes
from wmr_ctrl import simulate
from wmr_ctrl.control.filter import command_filter
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.theory.checks.velocity_base import filter_facts
from wmr_ctrl.world.scenario import override

APART = {"tau": ((0.1, 0.15), (0.4, 0.6)), "gain": ((0.95, 1.05), (0.8, 1.5))}
LATE = {"delay": ((0.02, 0.02), (0.02, 0.2)), "losses": 1, "jitter": 0.004, "age": 0.08}
SWUNG = {
    "loop": "second-order", "damping": ((0.5, 0.6), (0.3, 0.9)), "tau": None, "odometry": None,
    "frequency": ((4.0, 5.0), (2.9, 3.6)), "gain": ((0.9, 1.1), (0.8, 1.5)),
}  # fmt: skip
MOWER = {
    "loop": ("first-order", "second-order"), "damping": (0.4, 1.2), "tau": None, "odometry": None,
    "frequency": (3.0, 4.0), "gain": ((0.95, 1.05), (0.9, 1.1)),
}  # fmt: skip
PI = {"mass": (50.0, 65.0), "inertia": (3.0, 4.5), "kp": (135.0, 165.0), "ki": (270.0, 330.0)}
PI_TURNS = {
    **MOWER, **PI, "loop": ("first-order", "pi"), "damping": None, "gain": ((0.95, 1.05), (1, 1)),
    "push": (0.0, 0.4), "d": (0.05, 0.01),
}  # fmt: skip
PI_DRIVES = {
    **MOWER, **PI, "loop": ("pi", "second-order"), "gain": ((1, 1), (0.9, 1.1)),
    "push": (10.0, 0.0), "d": (0.0, 0.05), "friction": (0.0, 20.0),
}  # fmt: skip
CASES = {
    "clip": ("clip", APART),
    "governor": ("governor", APART),
    "governor, late": ("governor", APART | LATE),
    "clip of linear loops": ("clip", SWUNG),
    "clip of a mower": ("clip", MOWER),
    "clip of a PI loop beside a first-order one": ("clip", PI_TURNS),
    "clip of a PI loop beside a second-order one": ("clip", PI_DRIVES),
    "band of a PI loop beside a second-order one": ("band", PI_DRIVES),
    "clip of slow commands": ("clip", SWUNG | {"slew": (0.1, 0.1), "delay": LATE["delay"]}),
    "band": ("band", SWUNG | {"delay": ((0.0, 0.0), (0.1, 0.1))}),
}


AXES = np.eye(2)


def alone(stated, axis):
    """Return the bounds stated for one axis, used for both axes."""
    return {
        name: value[axis] if isinstance(value, tuple) and not isinstance(value[0], float) else value
        for name, value in stated.items()
    }


@pytest.mark.parametrize("name", CASES)
@pytest.mark.slow_but(*CASES.keys() - {"clip of slow commands"})
def test_each_axis_is_sent_what_it_is_sent_where_both_are_like_it(name):
    kind, stated = CASES[name]
    apart = command_filter(scenario(kind, **stated, scale="axes"))
    own = [command_filter(scenario(kind, **alone(stated, i), scale="axes")) for i in (0, 1)]
    rng, v, gone = np.random.default_rng(0), np.zeros(2), -np.expm1(-0.05 / np.array([0.14, 0.5]))
    for k in range(60):
        asked = rng.uniform(-3, 3, 2) if k % 7 else np.zeros(2)
        heard = name == "governor" and k % 3
        sent = apart.step(asked, v if heard else None).command
        for i, item in enumerate(own):  # the other axis rests, inside whatever bounds
            assert item.step(asked * AXES[i], v * AXES[i] if heard else None).command[i] == sent[i]
        v += gone * (sent - v)


CLIP = STATED | {"filter.kind": "clip"}


@pytest.mark.parametrize("name", ["tau", "gain", "delay", "damping", "frequency", "loop"])
@pytest.mark.parametrize("key, own", [("channels", "wheels"), ("wheel_speed", 0.8)])
def test_wheels_take_none_that_differ(name, key, own):
    value = ("first-order", "second-order") if name == "loop" else ((0.5, 0.6), (0.5, 0.7))
    with pytest.raises(ScenarioError, match=rf"^filter\.{name} is stated for v .* filter\.{key}"):
        scenario("clip", **{"damping": (0.5, 0.6), name: value, key: own})


MIXED = 'filter.loop = ["first-order", "second-order"]'


@pytest.mark.parametrize(
    "stated, words",
    cases(rf"""
        filter.gain = [[0.9, 1.1]]              | one for both axes, or two
        filter.gain = [[0.9, 1.1], [1.1, 0.9]]  | Write \[0\.9, 1\.1\]
        filter.gain = [[0.9, 1.1], 1.1]         | filter\.gain\[2\] = 1\.1 must be an array of 2
        filter.gain = [0.9, 1.1, 1.2]           | or two such, of v and of omega
        filter.loop = ["pi", "linear"]          | filter\.loop\[2\] = "linear" is not known
        filter.tau = [[0.1, 0.2], [1e-7, 0.2]]  | filter\.tau = \[1e-07, 0\.2\] spans
        {MIXED}                                 | filter\.damping is missing
        {MIXED}; filter.kind = band; filter.damping = [0.4, 0.5]      | band
        {MIXED}; filter.damping = [[0.4, 0.5], [1e-3, 1]] | omega to .* State filter\.damping\[2\]
    """),
)
def test_what_does_not_fit_is_refused_with_its_place(stated, words):
    with pytest.raises(ScenarioError, match=words):
        command_filter(preset("paper-simulation", CLIP, stated))


BASE = changes("""
    base = {kind = "velocity", tau = [0.14, 0.5], gain = [1.0, 1.2]}
    robot.mu = 0
    disturbance.std = 0
    changes = []
""")


@pytest.mark.parametrize(
    "key, value", [("tau", (0.3, 0.14)), ("gain", (1.2, 1.0)), ("tau", (0.14, 0.3))]
)
def test_a_run_is_held_against_the_bounds_of_its_axis(key, value):
    fits = override(scenario("governor", **APART, odometry=None), BASE)
    settle(fits, "kanayama")
    with pytest.raises(ScenarioError, match=rf"base\.{key}\[\d\] = .* is outside filter\.{key} = "):
        settle(override(fits, {f"base.{key}": value}), "kanayama")


def test_check_tells_each_axis_by_its_own_bounds():
    facts = filter_facts(settle(override(scenario("clip", **APART), BASE), "kanayama"))
    sent = [0.95 * gain for gain in (0.95 / 1.05, 0.8 / 1.5)]
    assert facts.gain == 1.5
    assert facts.usable_speed == pytest.approx([speed - 0.05 for speed in sent], abs=1e-6)
    assert facts.gain_cost == pytest.approx([speed / 101 for speed in sent], abs=1e-6)
    assert facts.delay_cost == (0.0, 0.0)


CUTTER = changes("""
    robot.l = 0.2
    robot.mu = 0
    disturbance.std = 0
    changes = []
    clock.duration = 8
    initial.velocity = [0.2, 0]
    initial.pose = [-2.0, -2.0, -0.7]
    base.kind = velocity
    base.loop = ["first-order", "second-order"]
    base.damping = [1.0, 0.45]
    base.frequency = [9.0, 3.5]
    base.gain = [1.0, 1.0]
""")


def assert_refused(scenario, table):
    """Assert that each change of a scenario is refused with these words."""
    for text, words in (case.values for case in cases(table)):
        with pytest.raises(ScenarioError, match=words):
            settle(override(scenario, changes(text)), "kanayama")


def test_one_axis_may_swing_while_the_other_does_not():
    run = simulate(override(scenario("clip", **MOWER), CUTTER), "kanayama")
    assert run.monitor.violations == 0
    assert run["clip_active"].any()
    assert_refused(
        override(scenario("clip", **MOWER), CUTTER),
        r"""
            initial.velocity = [0.2, 0.1]                 | at rest at the start
            base.damping = [1.0, 0.39]                    | base\.damping\[2\] = 0\.39 is outside
            base.loop = ["second-order", "second-order"]  | for speeds that never exceed
            base.loop = first-order                       | filter\.loop = "second-order" does not
        """,
    )


ROBOT = CUTTER | changes("robot.m = 60; robot.I = 3.5; base.kp = 150; base.ki = 300")


@pytest.mark.parametrize(
    "stated, loop",
    [(PI_TURNS, ("first-order", "pi")), (PI_DRIVES, ("pi", "second-order"))],
)
def test_a_pi_loop_may_drive_one_axis_beside_another_loop(stated, loop):
    own = ROBOT | {"base.loop": loop, "initial.velocity": (0.0, 0.0)}
    made = override(scenario("clip", **stated), own)
    run = simulate(made, "kanayama")
    assert run.monitor.violations == 0
    assert run["clip_active"].any()
    axis = loop.index("pi")
    mass, unit = (("m", "mass"), ("I", "inertia"))[axis]
    own, other = (20 * AXES[axis]).tolist(), (20 * AXES[1 - axis]).tolist()
    assert_refused(
        made,
        rf"""
            robot.{mass} = 70                       | robot\.{mass} = 70 .* outside filter\.{unit}
            base.kp = 100                           | base\.kp = 100 N\.s/m is outside
            base.loop = ["{loop[1]}", "{loop[0]}"]  | does not fit
            initial.velocity = {own}                | at rest at the start
            disturbance.push = {own}                | filter\.push\[{axis + 1}\] = .* is less
            disturbance.push = {other}              | filter\.d\[{2 - axis}\] = .* is less
            base.quantum = 0.2                      | base\.quantum
            actuator.tau_max = 50                   | may wind up
        """,
    )
