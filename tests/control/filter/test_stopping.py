"""A governor with limits and free distances as inputs: adversaries, and the effect of each
input.
"""

import math
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from benchmarks.filter_trials.altered import ALTERED
from benchmarks.filter_trials.stopping import (
    FAMILIES,
    RAMPS,
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
@pytest.mark.slow_but("0.1 to 0.15 s late", "a loss, at once", "turning")
def test_drives_neither_touch_nor_stay(name):
    found = mixed(Drives(FAMILIES[name]), 100, 3)

    assert broken(found) == {}
    assert found["passed"].sum() > 10
    assert broken(drives(FAMILIES[name], 200, 4)) == {}


@pytest.mark.parametrize(
    "base, behind, asked",
    [
        (replace(LATE, error=0.5, v=(1.0, 0.05)), math.inf, (0.0, 0.5)),
        (replace(LATE, leave=20, v=(1.0, 0.05)), math.inf, (0.0, 0.5)),
        (replace(LATE, push=(0.0, 0.0), v=(1.0, 0.0)), math.inf, (0.0, 0.5)),
        (replace(RAMPS["slow"], push=(0.0, 0.0), v=(1.0, 0.0)), math.inf, (0.0, 0.5)),
        (replace(LATE, losses=3, jitter=0.5, tau=(0.05, 0.05), rest=0.0), 0.0, (1.0, 0.0)),
    ],
)
def test_what_is_free_lets_a_base_go_however_much_it_keeps_or_must_hold(base, behind, asked):
    told = {"measured": (0.0, 0.0), "free": (math.inf, behind), "dt": base.period}
    step = CommandFilter(base.scenario()).step
    assert any(step(asked, **told).command != (0.0, 0.0) for _ in range(150))


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


def test_a_brake_behind_a_dead_band_keeps_the_limit():
    """A base that stops instantly, also after commands that its firmware treats as 0."""
    told = PLAIN | changes("filter.d = [0.1, 0.1]; filter.rest = 0")
    governor, v = CommandFilter(load_scenario("paper-simulation", told)), 0.0
    for asked in (1.0,) * 60 + (0.04,) + (-9.0,) * 4:
        u = governor.step((asked, 0.0)).command[0]
        v = 1.1 * u + math.exp(-0.05 / 0.2) * (v - 1.1 * u) if abs(u) > 0.05 else 0.0
        assert abs(v) <= 1


@pytest.mark.parametrize(
    "own, asked, limit",
    [
        ("filter.rest = 0.05", (0.0, 9.0), 1.0),
        ("filter.rest = 0; filter.tau = [0.05, 0.3]; limits.v_max = [0.06, 1]", (0.055,), 0.06),
    ],
)
def test_a_brake_that_closes_as_a_command_takes_over_keeps_the_limit(own, asked, limit):
    """The last command meets a base that its brake stops at the sample, or as a command of 0."""
    told = PLAIN | changes(f"filter.odometry = [0, 0]; {own}")
    scenario = load_scenario("paper-simulation", told)
    step, v, u = CommandFilter(scenario).step, 0.0, 0.0
    share = -math.expm1(-0.05 / scenario.filter.intervals("tau")[0][0])
    for item in (-9.0,) * 60 + asked:
        v += share * (u - v)
        u = step((item, 0.0), measured=(v, 0.0)).command[0]
    assert 0 < share * (1.1 * u + 0.05) <= limit


def test_limits_that_may_change_leave_no_less_than_the_clip():
    """Without odometry, and with delays that vary by a period, so that k2 is nearly infinite."""
    own = "filter.changing = true; filter.delay = [0, 0.05]"
    step = CommandFilter(load_scenario("paper-simulation", PLAIN | changes(own))).step
    assert min(step((9.0, 0.0)).command[0] for _ in range(60)) > 0.95 / 1.1 - 1e-7


@pytest.mark.parametrize("jitter", [0.0, 0.2])
def test_the_slowest_base_lands_on_a_lowered_limit_in_the_shortest_period(jitter):
    own = PLAIN | changes(f"filter.changing = true; filter.jitter = {0.05 * jitter}")
    step, low = CommandFilter(load_scenario("paper-simulation", own)).step, [(-0.9, 0.9)] * 2
    v, sent = 1.0, [step((9.0, 0.0)).command[0] for _ in range(200)][-1]
    assert 1.1 * sent + 0.05 == pytest.approx(v)
    target = 1.1 * step((9.0, 0.0), limits=low).command[0] + 0.05
    assert target + math.exp(-0.05 * (1 - jitter) / 0.3) * (v - target) == pytest.approx(0.9)


def test_a_brake_that_late_turning_keeps_open_keeps_the_limit():
    """Commands of v act at once, those of omega 0.4 s later; a push drives v on meanwhile."""
    own = "filter.d = [0.2, 0.2]; filter.rest = 0.1; filter.delay = [[0, 0], [0.4, 0.4]]"
    governor, v = CommandFilter(load_scenario("paper-simulation", PLAIN | changes(own))), 0.2
    for asked in [(0.0, 0.5)] * 12 + [(0.0, 0.0)] * 6 + [(9.0, 0.0)] * 2:
        u = governor.step(asked).command[0]
        v = 1.1 * u + 0.2 + math.exp(-0.05 / 0.2) * (v - 1.1 * u - 0.2)
        assert v <= 1


def twins(told, count, seed=0):
    """Drive a base with constant gain, push and obstacles ahead and behind; yield every step.

    A step is the filter, its memory, the requested command, further arguments, the command sent.
    """
    filtered, draw = CommandFilter(told.scenario()), np.random.default_rng(seed)
    v, x, asked = np.zeros(2), 0.0, (1.0, 0.0)
    for _ in range(count):
        if draw.random() < 0.1:
            asked = (draw.choice([3.0, -3.0, 0.3, -0.3, 0.0]), draw.choice([0.0, 0.0, 0.4]))
        limits = tuple((-draw.uniform(0.2, 1.2), draw.uniform(0.2, 1.2)) for _ in range(2))
        given = {
            "measured": v.tolist(), "free": (1.0 - x, 9.0 + x), "dt": told.period, "limits": limits
        }  # fmt: skip
        memory = filtered._x.copy()
        sent = filtered.step(asked, **given).command
        yield filtered, memory, asked, given, sent
        x += told.period * v[0]
        v += -math.expm1(-told.period / 0.25) * (np.add(sent, (0.02, 0.0)) - v)


@pytest.mark.parametrize("signs", [(-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)])
def test_the_mirrored_drive_is_sent_the_mirrored_commands(signs):
    other = CommandFilter(LATE.scenario())
    for _, _, asked, given, sent in twins(LATE, 400):
        free = given["free"][:: int(signs[0])]
        limits = [
            sorted(s * np.array(ends)) for s, ends in zip(signs, given["limits"], strict=True)
        ]
        flipped = {
            **given,
            "free": free,
            "limits": limits,
            "measured": signs * np.array(given["measured"]),
        }
        mirrored = other.step(np.multiply(signs, asked), **flipped).command
        assert tuple(np.multiply(signs, mirrored)) == sent


def holds(filtered, memory):
    """True if a request waits in memory.  It passes when its summed pull is large enough."""
    names = [item.signal for item in filtered.system.state]
    at = sum(item.size for item in names[: [item.name for item in names].index("waited")])
    return memory[at : at + 4].any()


NO_NUMBERS = (math.nan, math.inf, -math.inf, -1.0)
NO_MORE = {
    "less way": lambda given: [{"free": np.subtract(given["free"], 0.1).tolist()}],
    "lower limits": lambda given: [{"limits": (0.8 * np.array(given["limits"])).tolist()}],
    "less turn": lambda _: [{"turn": (0.2, 0.2)}],
    "command": lambda _: [{"command": (item, 0.1)} for item in NO_NUMBERS[:3]],
    "measured": lambda _: [
        {"measured": None}, *({"measured": (item, 0.0)} for item in NO_NUMBERS[:3])],
    "age": lambda _: [{"age": item} for item in (*NO_NUMBERS, 0.3)],
    "dt": lambda _: [{"dt": item} for item in (*NO_NUMBERS, 0.0, 0.2)],
    "limits": lambda _: [{"limits": ((-x, x), (-1.0, 1.0))} for x in (math.nan, -1.0, 0.0)],
    "free": lambda _: [
        {"free": None}, *({"free": (item, item)} for item in (math.nan, -math.inf, -1.0, 0))],
    "free_age": lambda _: [{"free_age": item} for item in NO_NUMBERS],
    "turn": lambda _: [{"turn": (item, item)} for item in (math.nan, -1.0, 0.0)],
}  # fmt: skip
"""Inputs that are worse than those given, odd, or missing."""
WORSE = {
    "tau": (0.15, 0.4), "gain": (0.8, 1.2), "push": (0.08, 0.06), "odometry": (0.03, 0.03),
    "error": 0.05, "rest": 1.5, "v": (0.8, 0.8),
}  # fmt: skip


@pytest.mark.filterwarnings("ignore:dt = inf")
@pytest.mark.parametrize("name", [*NO_MORE, *WORSE])
def test_an_input_or_a_bound_that_is_worse_never_sends_more(name):
    """Worse inputs or bounds never enlarge a command, except by the rounding margin."""
    told = replace(LATE, free_age=0.2) if name in NO_MORE else replace(LATE, leave=0)
    other, compared = (
        CommandFilter(
            replace(told, **{key: WORSE[key] for key in [name] if key in WORSE}).scenario()
        ),
        0,
    )
    for filtered, memory, asked, given, sent in twins(told, 150, 3):
        if holds(filtered, memory):
            continue
        for change in NO_MORE.get(name, lambda _: [{}])(given):
            odd = {"command": asked, **given, **change}
            other._x = memory.copy()
            found = other.step(odd.pop("command"), **odd).command
            assert np.isfinite(other._x).all(), change  # else the package keeps an old memory
            assert all(abs(a) <= abs(b) + 2e-8 for a, b in zip(found, sent, strict=True)), change
            compared += 1
    assert compared > 50


@pytest.mark.parametrize(
    "given, words",
    [
        ({"limits": ((-1, 1),)}, "limits has 1 pairs"),
        ({"limits": ((-1, 1, 2), (-1, 1))}, "limits has 3 numbers"),
        ({"free": (1, 1, 1)}, "free has 3 numbers"),
        ({"free": (1, 1), "turn": (1,)}, "turn has 1 number"),
        ({"limits": ((-1, 1), (-1, 1))}, "filter.changing"),
        ({"free": (1, 1)}, "filter.free_error"),
        ({"turn": (1, math.inf)}, "filter.free_error"),
    ],
)
def test_arguments_of_a_wrong_length_or_that_no_key_asks_for_are_refused(given, words):
    plain = words.startswith("filter")
    limit = CommandFilter(load_scenario("paper-simulation", PLAIN) if plain else LATE.scenario())
    with pytest.raises(ArgumentError, match=words):
        limit.step((0, 0), **given)


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
