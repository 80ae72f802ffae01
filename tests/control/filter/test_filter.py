"""The command filter: its limit against an adversary, the commands it admits, and its messages."""

import copy
import math
import pickle
import re
import warnings
from itertools import product

import numpy as np
import pytest

import wmr_ctrl
from benchmarks.filter_trials.adversary import Base, fastest
from benchmarks.filter_trials.compiled import WIDE_TURNS
from benchmarks.filter_trials.first_order import RIMS, WHEELS, WORLDS, told_of
from tests.tables import cases, changes
from wmr_ctrl import load_scenario
from wmr_ctrl.control.filter.channels import ROUNDING
from wmr_ctrl.control.filter.filter import filter_questions, filter_system
from wmr_ctrl.control.filter.governor_step import Governor
from wmr_ctrl.core.errors import ArgumentError, ScenarioError
from wmr_ctrl.theory.checks.velocity_base import usable_speed

STATED = changes("""
    filter.tau = [0.2, 0.3]
    filter.gain = [0.9, 1.1]
    filter.d = [0.05, 0.05]
    filter.odometry = [0.02, 0.02]
    limits.v_u1 = [1.0, 1.0]
    limits.v_u2 = [0.7, 0.7]
    clock.control = 0.05
""")
BROKEN = {
    "push": {"d": 0.0625}, "time constant": {"tau": (0.19, 0.3)}, "gain": {"gain": (0.9, 1.155)},
    "odometry": {"error": 0.05}, "delay": {"delay": (0.0, 0.01)}, "losses": {"losses": 1},
    "jitter": {"jitter": 0.005}, "second lag": {"second_lag": 0.005},
}  # fmt: skip
CLIP = (1 - 0.05) / 1.1


def scenario(kind="governor", **stated):
    changed = {f"filter.{name}": value for name, value in {"kind": kind, **stated}.items()}
    return load_scenario("paper-simulation", STATED | changed)


@pytest.mark.parametrize("number, heard", [(2, True), (9, True), (5, False), (9, False)])
def test_no_adversary_within_the_bounds_passes_the_limit(number, heard):
    world = WORLDS[number]
    worst = fastest(scenario(**world), Base(**world, heard=heard), trials=60, samples=120)
    assert 0.999 < worst.max() <= 1.0


@pytest.mark.parametrize("bound", BROKEN)
@pytest.mark.slow_but("push", "delay", "jitter")
def test_each_bound_broken_breaks_the_limit(bound):
    assert fastest(scenario(), Base(**BROKEN[bound]), trials=60).max() > 1.0


def test_the_clip_holds_behind_any_chain_that_never_overshoots():
    base = Base(second_lag=0.005, delay=(0.0, 0.2), losses=3, jitter=0.02)
    assert fastest(scenario("clip"), base, trials=60).max() <= 1.0


def test_at_rest_the_governor_admits_more_than_the_limit_for_a_sample():
    governor = wmr_ctrl.command_filter(scenario())
    kappa = 1 / math.expm1(0.05 / 0.2)
    hi = (1 - 0.05 + kappa * (1 - 0.02)) / 1.1
    assert governor.step((9.0, 0.0), (0.0, 0.0)).command[0] == pytest.approx(hi, rel=1e-6)


def test_axes_by_themselves_are_limited_by_themselves():
    sent = wmr_ctrl.command_filter(scenario(scale="axes")).step((9.0, 0.1)).command
    assert sent == (pytest.approx(CLIP, rel=1e-7), 0.1)


@pytest.mark.parametrize("dt, late", [(None, False), (0.05, False), (0.08, True), (0.01, True)])
def test_a_step_outside_its_jitter_is_told(dt, late):
    governor = wmr_ctrl.command_filter(scenario())
    made = governor.step((5.0, 0.0), (0.0, 0.0), dt=dt)
    assert ("late" in made.flags) == late


def test_a_command_within_the_limits_passes_to_the_bit():
    governor = wmr_ctrl.command_filter(scenario())
    made = governor.step((0.3, -0.2), (0.1, 0.0))
    assert (made.command, made.flags) == ((0.3, -0.2), ())


@pytest.mark.parametrize("asked", [(math.nan, 0.1), (0.1, math.inf), (-math.inf, math.nan)])
@pytest.mark.parametrize("kind", ["clip", "governor"])
def test_what_is_no_number_becomes_a_stop(kind, asked):
    made = wmr_ctrl.command_filter(scenario(kind)).step(asked)
    assert made.command == (0.0, 0.0)
    assert "refused" in made.flags


LOOPS = {
    "loop": "second-order", "frequency": (3.5, 4.5), "damping": (0.5, 0.7), "d": (0.02, 0.02),
    "tau": None, "odometry": None,
}  # fmt: skip


@pytest.mark.parametrize(
    "kind, stated",
    [("clip", {}), ("clip", LOOPS), ("clip", {**LOOPS, "slew": (0.25, 0.25)}), ("band", LOOPS)],
)
def test_filters_other_than_a_governor_do_as_well_whatever_odometry_says(kind, stated):
    asked = np.random.default_rng(0).uniform(-3, 3, (40, 2)).tolist()
    sent = []
    for measured in (None, (math.nan, 0.0), (5.0, -5.0)):
        limit = wmr_ctrl.command_filter(scenario(kind, **stated))
        sent.append([limit.step(tuple(pair), measured).command for pair in asked])

    assert sent[0] == sent[1] == sent[2]


@pytest.mark.parametrize("kind", ["clip", "governor"])
def test_a_last_command_is_safe_until_the_base_stops_by_itself(kind):
    """Commands cease now and then, and the base stops `hold` after the last one."""
    worst = fastest(scenario(kind, hold=0.3), Base(hold=0.3), trials=60, samples=120)

    assert 0.9 < worst.max() <= 1.0


@pytest.mark.parametrize("measured", [(math.nan, 0.0), (0.0, math.inf)])
def test_odometry_that_is_no_number_is_not_used(measured):
    made = wmr_ctrl.command_filter(scenario()).step((5.0, 0.0), measured)
    assert made.flags == ("limited", "unused")
    assert made.command[0] == pytest.approx(CLIP, rel=1e-7)


def test_odometry_that_contradicts_the_bounds_is_told_and_the_clip_acts():
    governor = wmr_ctrl.command_filter(scenario())
    governor.step((0.0, 0.0), (0.0, 0.0))
    made = governor.step((5.0, 0.0), (0.9, 0.0))
    assert "bounds-left" in made.flags
    assert made.command[0] == pytest.approx(CLIP, rel=1e-7)


@pytest.mark.parametrize("seed", range(4))
def test_on_the_rim_of_its_bounds_rounding_stops_no_base(seed):
    """Rounding stops no base with gain, push, time constant and odometry error at their bounds.

    The base moves by its exact solution, and the weakest base reaches the usable speed.
    """
    draw = np.random.default_rng(seed)
    tau, d = np.sort(draw.uniform(0.05, 0.5, 2)), draw.uniform(0, 0.1, 2)
    error, gain = draw.uniform(0, 0.05, 2) * (seed % 3 > 0), draw.uniform((0.7, 1), (1, 1.3))
    settings = scenario(
        tau=tuple(tau), gain=tuple(gain), d=tuple(d), odometry=tuple(error), scale="axes"
    )
    governor, T = wmr_ctrl.command_filter(settings), settings.clock.control
    weakest, sign = seed < 2, draw.choice([-1, 1])
    speed, kept = np.zeros(2), math.exp(-T / draw.choice(tau))
    for _ in range(400):
        made = governor.step((9.0, 9.0), speed + sign * error)
        assert "bounds-left" not in made.flags
        goal = np.array(made.command) * gain[1 - weakest] + (-d if weakest else d)
        speed = kept * speed + (1 - kept) * goal
        assert speed.max() <= 1.0
    assert not weakest or np.all(speed >= 0.999999 * np.array(usable_speed(settings)))


def test_the_limit_is_kept_away_from_by_the_rounding_alone():
    graph = Governor(scenario())
    limits = graph.system.function("limits", [graph.limits[0][0]])
    x = np.array(graph.system.x0)
    clip = float(limits(np.array([0.0, 0.0, 0.0, 0.0, -1.0, 0.0]), x, graph.system.p0))
    assert clip == pytest.approx(((1 - ROUNDING) - 0.05) / 1.1, rel=1e-15)


@pytest.mark.parametrize(
    "stated, words",
    cases(r"""
        filter.kind = none           | has no command filter
        filter.tau = [0.3, 0.2]      | wrong way round
        filter.gain = [0, 1]         | filter.gain
        filter.d = [1, 0]            | filter.d\[1\] = 1
        filter.jitter = 0.05         | filter.jitter
        filter.delay = [0, 5]        | span 100 control periods
        filter.losses = -1           | filter.losses
    """),
)
def test_what_cannot_be_met_is_refused_with_its_key(stated, words):
    governor = STATED | {"filter.kind": "governor"}
    with pytest.raises(ScenarioError, match=words):
        wmr_ctrl.command_filter(load_scenario("paper-simulation", governor | changes(stated)))
    with pytest.raises(ScenarioError, match=r"filter\.tau is missing"):
        scenario(tau=None)


@pytest.mark.parametrize("through", [copy.deepcopy, lambda item: pickle.loads(pickle.dumps(item))])
def test_a_copy_goes_on_where_the_filter_stands(through):
    """For example a copy that is sent to another process."""
    own = wmr_ctrl.command_filter(scenario("governor", delay=(0.0, 0.03)))
    own.step((5.0, 1.0), measured=(0.3, 0.1))
    other = through(own)
    for _ in range(3):
        assert own.step((5.0, -1.0)) == other.step((5.0, -1.0))


@pytest.mark.parametrize("kind", [np.float64, np.float32, np.int64])
def test_pairs_may_be_arrays(kind):
    asked, seen = np.array([1, 2], dtype=kind), np.array([0, 1], dtype=kind)
    found = wmr_ctrl.command_filter(scenario()).step(asked, seen)
    assert found == wmr_ctrl.command_filter(scenario()).step((1.0, 2.0), (0.0, 1.0))


@pytest.mark.parametrize(
    "asked",
    [np.zeros((2, 1)), np.array(1.0), np.array([True, False]), np.array(["1", "2"]),
     np.array([1j, 0]), np.zeros(3), {1.0, 2.0}, "12", (1.0, None), (1.0, 2.0, 3.0)],
)  # fmt: skip
def test_what_is_no_pair_is_refused_by_name(asked):
    with pytest.raises(ArgumentError, match="command"):
        wmr_ctrl.command_filter(scenario()).step(asked)


@pytest.mark.parametrize(
    "kind, stated, loops, keeps",
    [
        ("clip", WHEELS, "wheels", True),
        ("clip", WIDE_TURNS, "wheels", False),
        ("governor", WHEELS, "wheels", True),
        ("clip", RIMS, "alike", True),
        ("governor", RIMS, "alike", True),
        ("governor", RIMS, "body", False),
    ],
)
@pytest.mark.parametrize("scale", ["curvature", "turn", "drive"])
def test_wheels_are_limited_where_they_are_told_of(kind, stated, loops, keeps, scale):
    """Wheels with different loops keep their limits only if the filter has channels for wheels."""
    told = told_of(kind, Base(loops=loops), stated, scale)
    worst = fastest(told, Base(loops=loops), trials=60, samples=60).max()
    assert worst > 0.95
    assert (worst <= 1.0) == keeps


def test_priority_gives_one_axis_all_that_it_can_have():
    first = {"turn": 1, "drive": 0}
    stated = {name: scenario("clip", scale=name, wheel_speed=1.0, d=(0.0, 0.0)) for name in first}
    for name, axis in first.items():
        sent = wmr_ctrl.command_filter(stated[name]).step((9.0, 9.0)).command
        alone = [0.0, 0.0]
        alone[axis] = 9.0
        assert sent[axis] == wmr_ctrl.command_filter(stated[name]).step(alone).command[axis]
        assert sent[0] + stated[name].robot.l * sent[1] == pytest.approx(1 / 1.1, rel=1e-6)


@pytest.mark.parametrize("wheels", [{}, {"channels": "wheels"}])
@pytest.mark.parametrize("rim", [None, 0.9])
def test_parameters_that_nothing_can_keep_stop_the_base_and_are_told(wheels, rim):
    """A parameter that is NaN, negative or infinite gives a command of 0 and a flag.

    The minimum of two limits would hide a NaN in one of them, so both are checked.
    """
    system = filter_system(scenario(**wheels, wheel_speed=rim))
    step = system.function("step", [system.update, system.y])
    places = [name for item in system.params for name in item.signal.elements]
    for place, value in product(range(len(places)), (math.nan, -0.1, math.inf)):
        if wheels and places[place] == "filter.d[2]" and value < 0:
            continue  # of a rim the sum of both pushes counts
        p = np.array(system.p0)
        p[place] = value
        x, y = step([0.5, 0.1, 0.2, 0.0, 0.0, 0.05], system.x0, p)
        assert y.full().ravel().tolist() == [0.0, 0.0, 32.0], (places[place], value)
        assert np.isfinite(x.full()).all()


@pytest.mark.parametrize(
    "stated, words",
    cases(r"""
        filter.tau = [200, 300]              | filter.tau\[1\] = 200 .*0.2 s
        filter.age = 80; clock.control = 50  | 0.08 s
        limits.v_u1 = [1000, 1]              | 1 m/s
        filter.age = 2; filter.kind = clip   | Milliseconds\? 2 ms
        filter.hold = 500                    | Milliseconds\? 500 ms is 0.5 s
    """),
)
def test_numbers_in_another_unit_are_asked_about(stated, words):
    stated = STATED | changes(f"filter.kind = governor; clock.duration = 1000; {stated}")
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        wmr_ctrl.command_filter(load_scenario("paper-simulation", stated))
    said = " ".join(str(item.message) for item in heard)
    assert {item.filename for item in heard} == {__file__}
    assert re.search(words, said), said


def test_a_time_in_milliseconds_is_asked_about_once():
    governor = wmr_ctrl.command_filter(scenario())
    with pytest.warns(UserWarning, match=r"dt = 52 s.*Milliseconds\? 52 ms is 0.052 s") as heard:
        said = governor.step((0.5, 0.1), dt=52.0)
    assert ([item.filename for item in heard], said.flags) == ([__file__], ("unused", "late"))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for usual in (0.052, 4.0, 900.0):
            governor.step((0.5, 0.1), dt=usual)


def test_usual_numbers_are_not_asked_about():
    assert not [*filter_questions(scenario())]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        wmr_ctrl.command_filter(scenario())
