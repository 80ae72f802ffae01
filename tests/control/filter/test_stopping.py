"""A governor that is told limits and free ways: adversaries, and what each input does."""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
import pytest

from benchmarks.filter_trials.altered import ALTERED
from benchmarks.filter_trials.stopping import (
    FAMILIES,
    TEETH,
    Base,
    Drives,
    bitten,
    breaks,
    drives,
    mixed,
)
from tests.papers_robot import preset
from tests.tables import cases, changes
from wmr_ctrl.control.filter import CommandFilter
from wmr_ctrl.control.filter.governor import NEAR, Schedule
from wmr_ctrl.control.filter.stopping import whole_steps
from wmr_ctrl.core.errors import ArgumentError, ScenarioError
from wmr_ctrl.world.scenario import load_scenario

LATE = Base(delay=(0.0, 0.06), v=(1.0, 1.0))
PLAIN = changes("""
    filter.kind = governor
    filter.tau = [0.2, 0.3]
    filter.gain = [0.9, 1.1]
    filter.d = [0.05, 0.05]
    limits.v_u1 = [1.0, 1.0]
    limits.v_u2 = [0.7, 0.7]
    clock.control = 0.05
""")


def broken(found):
    return {name: int(item.sum()) for name, item in breaks(found).items() if item.any()}


@pytest.mark.parametrize("name", FAMILIES)
@pytest.mark.slow_but("0.1 to 0.15 s late", "two losses", "turning")
def test_drives_neither_touch_nor_stay(name):
    found = mixed(Drives(FAMILIES[name]), 100, 3)

    assert broken(found) == {}
    assert found["passed"].sum() > 10
    assert broken(drives(FAMILIES[name], 200, 4)) == {}


@pytest.mark.parametrize("name", TEETH)
@pytest.mark.slow_but("brake", "a period less than the time for a lowered limit")
def test_a_bound_that_does_not_hold_is_seen(name):
    assert broken(bitten(name, 500 if "apart" in name else 60, 5)) != {}


@pytest.mark.parametrize("name", ALTERED)
@pytest.mark.slow_but("a hold half as long", "both ends of a takeover, none between")
def test_a_wrong_formula_is_seen(name):
    altered = ALTERED[name]

    assert broken(altered.found(1200, 1)).get(altered.breaks, 0) > 0


@pytest.mark.parametrize("jitter, time, steps", [(0.0, 1.0, 21), (0.2, 0.99, 25)])
def test_rest_is_known_only_after_the_brake_has_closed(jitter, time, steps):
    plan = Schedule((2.0, 2.0), jitter=jitter)
    found = whole_steps(plan, ca.SX(0.05), ca.SX(time), NEAR)
    assert float(ca.evalf(found)) == steps
    assert float(ca.evalf(whole_steps(plan, ca.SX(0.05), ca.SX(1.0)))) <= steps


class Driven:
    """A base in Python, K and push constant, behind a filter; things ahead and behind."""

    def __init__(self, told: Base, *, ahead=1.0, behind=9.0, push=0.02):
        self.filter = CommandFilter(told.scenario())
        self.v, self.x = np.zeros(2), np.zeros(2)
        self.ahead, self.behind, self.push, self.T = ahead, behind, push, told.period

    def inputs(self):
        """Arguments of a step: odometry and the true ways."""
        free = self.ahead - self.x[0], self.behind + self.x[0]
        return {"measured": self.v.tolist(), "free": free, "dt": self.T}

    def moves(self, sent):
        """Let a command act for a period."""
        share = -math.expm1(-self.T / 0.25)
        self.x += self.T * self.v
        self.v += share * (np.array(sent) + self.push * np.array([1.0, 0.0]) - self.v)


def twins(told, count, seed=0):
    """A drive, and at each step the filter's memory, command asked for, and arguments."""
    base, draw = Driven(told), np.random.default_rng(seed)
    asked = (1.0, 0.0)
    for _ in range(count):
        if draw.random() < 0.1:
            asked = (draw.choice([3.0, -3.0, 0.3, -0.3, 0.0]), draw.choice([0.0, 0.0, 0.4]))
        given = base.inputs()
        limits = tuple((-draw.uniform(0.2, 1.2), draw.uniform(0.2, 1.2)) for _ in range(2))
        given["limits"] = limits
        memory = base.filter._x.copy()
        sent = base.filter.step(asked, **given).command
        yield base, memory, asked, given, sent
        base.moves(sent)


def again(filtered, memory, asked, given):
    filtered._x = memory.copy()
    return filtered.step(asked, **given).command


def not_larger(new, old):
    """Whether no command is larger, but for the margin for roundings, a share of the limits."""
    return all(abs(a) <= abs(b) + 2e-8 for a, b in zip(new, old, strict=True))


@pytest.mark.parametrize("axes", [(0,), (1,), (0, 1)])
def test_the_mirrored_drive_is_sent_the_mirrored_commands(axes):
    other = CommandFilter(LATE.scenario())
    signs = [-1.0 if i in axes else 1.0 for i in (0, 1)]
    for _, _, asked, given, sent in twins(LATE, 400):
        limits = [(-b, -a) if i in axes else (a, b) for i, (a, b) in enumerate(given["limits"])]
        free = given["free"][::-1] if 0 in axes else given["free"]
        measured = [s * v for s, v in zip(signs, given["measured"], strict=True)]
        flipped = {"limits": limits, "free": free, "dt": given["dt"], "measured": measured}
        command = [s * r for s, r in zip(signs, asked, strict=True)]
        mirrored = other.step(command, **flipped).command
        assert [s * u for s, u in zip(signs, mirrored, strict=True)] == list(sent)


LESS = {
    "free": lambda given: {"free": tuple(item - 0.1 for item in given["free"])},
    "limits": lambda given: {"limits": tuple((0.8 * a, 0.8 * b) for a, b in given["limits"])},
    "turn": lambda given: {"turn": (0.2, 0.2)},
}


def holds(filtered, memory):
    """Whether a request waits: it passes once its pull, which depends on limits, adds up."""
    names = [item.signal for item in filtered.system.state]
    at = sum(item.size for item in names[: [item.name for item in names].index("waited")])
    return memory[at : at + 4].any()


@pytest.mark.parametrize("less", LESS)
def test_less_way_or_a_lower_limit_never_sends_more(less):
    other, compared = CommandFilter(LATE.scenario()), 0
    for base, memory, asked, given, sent in twins(LATE, 300, 1):
        if not holds(base.filter, memory):
            assert not_larger(again(other, memory, asked, {**given, **LESS[less](given)}), sent)
            compared += 1
    assert compared > 150


WORSE = {
    "tau": (0.15, 0.4), "gain": (0.8, 1.2), "push": (0.08, 0.06), "odometry": (0.03, 0.03),
    "error": 0.05, "rest": 1.5, "v": (0.8, 0.8),
}  # fmt: skip


@pytest.mark.parametrize("name", WORSE)
def test_worse_bounds_never_send_more(name):
    told = Base(delay=(0.0, 0.06), v=(1.0, 1.0), leave=0)
    worse = CommandFilter(Base(**{**told.__dict__, name: WORSE[name]}).scenario())
    for base, memory, asked, given, sent in twins(told, 300, 2):
        if not holds(base.filter, memory):
            assert not_larger(again(worse, memory, asked, given), sent)


NO_NUMBERS = (math.nan, math.inf, -math.inf, -1.0)
ODD = {
    "command": [{"command": (item, 0.1)} for item in NO_NUMBERS[:3]],
    "measured": [{"measured": None}, *({"measured": (item, 0.0)} for item in NO_NUMBERS[:3])],
    "age": [{"age": item} for item in (*NO_NUMBERS, 0.3)],
    "dt": [{"dt": item} for item in (*NO_NUMBERS, 0.0, 0.2)],
    "limits": [{"limits": ((-item, item), (-1.0, 1.0))} for item in (math.nan, -1.0, 0.0)],
    "free": [{"free": None}, *({"free": (item, item)} for item in (math.nan, -math.inf, -1.0, 0))],
    "free_age": [{"free_age": item} for item in NO_NUMBERS],
    "turn": [{"turn": (item, item)} for item in (math.nan, -1.0, 0.0)],
}


@pytest.mark.filterwarnings("ignore:dt = inf")
@pytest.mark.parametrize("name", ODD)
def test_an_input_that_is_odd_or_missing_never_sends_more(name):
    told = Base(delay=(0.0, 0.06), v=(1.0, 1.0), free_age=0.2)
    other, compared = CommandFilter(told.scenario()), 0
    for base, memory, asked, given, sent in twins(told, 150, 3):
        if holds(base.filter, memory):
            continue
        for change in ODD[name]:
            odd = {**given, **change}
            command = odd.pop("command", asked)
            assert not_larger(again(other, memory, command, odd), sent), change
            compared += 1
    assert compared > 200


def step(given, stated=None):
    """Step a filter that is told limits and ways, or one of a scenario, with arguments."""
    scenario = LATE.scenario() if stated is None else load_scenario("paper-simulation", stated)
    return CommandFilter(scenario).step((0, 0), **given)


@pytest.mark.parametrize(
    "given, words",
    [
        ({"limits": ((-1, 1), (-1, 1))}, "filter.changing"),
        ({"free": (1, 1)}, "filter.free_error"),
    ],
)
def test_what_a_filter_does_not_ask_for_is_refused(given, words):
    with pytest.raises(ArgumentError, match=words):
        step(given, PLAIN)


@pytest.mark.parametrize(
    "given, words",
    [
        ({"limits": ((-1, 1),)}, "limits has 1 pairs"),
        ({"limits": ((-1, 1, 2), (-1, 1))}, "limits has 3 numbers"),
        ({"free": (1, 1, 1)}, "free has 3 numbers"),
        ({"free": (1, 1), "turn": (1,)}, "turn has 1 number"),
    ],
)
def test_arguments_of_a_wrong_length_are_refused(given, words):
    with pytest.raises(ArgumentError, match=words):
        step(given)


TOLD = {**PLAIN, "filter.free_error": 0.02, "filter.rest": 1.0}


@pytest.mark.parametrize(
    "changed, words",
    cases("""
        filter.nearing = 0.3                   | filter.leave keeps a distance
        filter.delay = [[0, 0.1], [0, 0.2]]    | filter.delay differs
        filter.channels = wheels               | filter.channels
        filter.wheel_speed = 1                 | filter.wheel_speed
        filter.kind = clip                     | filter.kind = "clip"
    """),
)
def test_what_is_not_certified_is_refused(changed, words):
    with pytest.raises(ScenarioError, match=words):
        preset("paper-simulation", TOLD, changed)


@pytest.mark.parametrize(
    "key, changed, words",
    cases("""
        filter.rest        | filter.nearing = 0                         | filter.rest is missing
        filter.rest        | filter.d = [0, 0]; filter.nearing = 0.3    | filter.rest is missing
        filter.free_error  | filter.nearing = 0.3                       | no distance is told
    """),
)
def test_what_a_stop_counts_on_is_asked_for(key, changed, words):
    with pytest.raises(ScenarioError, match=words):
        load_scenario("paper-simulation", TOLD | {key: None} | changes(changed))
