"""Limits and free ways of the filter node as decisions of its core: edge cases, each by itself."""

import math

import pytest

from tests.ros2.lasers import RPLIDAR, walls
from tests.ros2.test_scans import RADIUS, STATED
from wmr_ctrl.control.filter.gate import GateSettings
from wmr_ctrl.ros2.clocks import Moment
from wmr_ctrl.ros2.compiled_system import Gate
from wmr_ctrl.ros2.filter_core import FilterCore
from wmr_ctrl.ros2.sight import SightSettings
from wmr_ctrl.world.scenario import load_scenario

MS = 1_000_000
TICK = 50 * MS
FREE = (math.inf, math.inf, 0.5, 0.5)
AT_ONCE = {"rise": (1e6, 1e6), "fall": (1e6, 1e6)}
TURNED = (0.0, 0.0, 0.0, 1.0)


def built(changes=(), odometry="none", **sight):
    settings = GateSettings(odometry=odometry, **AT_ONCE)
    stated = load_scenario("paper-simulation", {**STATED, **dict(changes)})
    return FilterCore(stated, settings, "", SightSettings(**sight))


CORES = {
    "free": built(),
    "limits": built({"filter.free_error": None, "filter.rest": None}),
    "silent": built({"filter.free_error": None, "filter.rest": None}, limit_timeout=0.5),
    "seeing": built(scans=("scan",), radius=RADIUS),
    "odometry": built({"filter.odometry": [0.02, 0.02]}, "watched"),
}


class World:
    """A core, clocks that a test moves, and a sender of commands."""

    def __init__(self, core):
        self.core = core
        self.ros, self.steady = 10**15, 7 * 10**9
        core.start()

    @property
    def now(self):
        return Moment(self.ros, self.steady)

    def go(self, count=40, v=0.5, omega=0.0, free=FREE, tick=TICK):
        """Speeds that are sent; ``free`` is told at each step, if there is any."""
        sent = []
        for _ in range(count):
            self.ros, self.steady = self.ros + tick, self.steady + tick
            self.core.see(self.now)
            if free is not None:
                assert self.core.hear_free(free, self.now) == ""
            assert self.core.command((v, omega), self.ros, "", self.now)[0] == ""
            sent.append(self.core.tick(self.now).command[0])
        return sent

    @property
    def flags(self):
        return set(self.core.last.flags)


@pytest.fixture
def free():
    return World(CORES["free"])


@pytest.fixture
def limits():
    world = World(CORES["limits"])
    yield world
    begin(world.core)


def begin(core):
    """Limits stay in force over a start: forget them."""
    for k in range(4):
        core._core.limited[k] = 0


FULL = 0.44
"""Speed [m/s] that the filter reaches where nothing limits it but the limit itself."""


# -- free ways ---------------------------------------------------------------------------------


@pytest.mark.parametrize("ahead", [0.0, -1.0, -math.inf])
def test_no_way_ahead_is_a_stop_at_once(free, ahead):
    assert free.go()[-1] > FULL
    sent = free.go(3, free=(ahead, *FREE[1:]))

    assert sent == [0.0] * 3
    assert "near" in free.flags
    assert "no-distance" not in free.flags


def test_infinite_ways_limit_no_command(free):
    assert free.go()[-1] > FULL
    assert free.flags <= {"limited", "unused"}


def test_a_way_that_is_no_number_is_not_told_and_the_others_are(free):
    """The last one is carried on, less the way since then."""
    free.go(free=(3.0, *FREE[1:]))
    speeds = free.go(200, free=(math.nan, *FREE[1:]))

    assert speeds[0] > FULL
    assert speeds[-1] < 0.01
    assert 1.5 < 0.05 * sum(speeds) < 3.0


@pytest.mark.parametrize("count", [0, 3, 5])
def test_other_than_four_ways_are_refused(free, count):
    assert "cannot be used" in free.core.hear_free([1.0] * count, free.now)


def test_ways_that_are_not_told_shrink_until_the_base_stands_before_them(free):
    free.go(free=(2.0, *FREE[1:]))
    speeds = free.go(200, free=None)

    assert speeds[0] > FULL
    assert speeds[-1] == 0.0
    assert 1.0 < 0.05 * sum(speeds) < 2.0
    assert {"no-distance", "near"} <= free.flags


def test_never_told_is_a_stop(free):
    assert free.go(5, free=None) == [0.0] * 5
    assert {"no-distance", "near"} <= free.flags


def test_ways_count_for_free_age_and_no_longer(free):
    free.go()
    flags = []
    for _ in range(7):
        free.go(1, free=None)
        flags.append("no-distance" in free.flags)

    assert flags == [False] * 5 + [True] * 2  # free_age is five periods


def test_ways_that_waited_while_the_process_stood_still_are_refused(free):
    free.go()
    free.ros, free.steady = free.ros + 600 * MS, free.steady + 600 * MS
    free.core.see(free.now)

    assert "queued" in free.core.hear_free(FREE, free.now)


def test_a_thing_that_is_nearer_than_the_stopping_way_is_a_stop_at_once(free):
    free.go()

    assert free.go(1, free=(0.05, *FREE[1:])) == [0.0]


def test_a_stop_for_what_is_in_the_way_is_not_ramped():
    slow = GateSettings(odometry="none", fall=(0.1, 0.1))
    world = World(FilterCore(load_scenario("paper-simulation", STATED), slow, ""))
    assert world.go(60)[-1] > FULL

    assert world.go(1, free=(0.05, *FREE[1:])) == [0.0]


def test_the_base_stands_before_a_wall_and_backs_off(free):
    """Ahead is told as it is for a base that follows its command at once."""
    left = 1.0
    for _ in range(300):
        (speed,) = free.go(1, free=(left, *FREE[1:]))
        left -= 0.05 * speed
    assert 0.02 < left < 0.15  # error, push and one release
    speeds = free.go(40, v=-0.3, free=(left, *FREE[1:]))
    assert speeds[-1] < -0.29


def test_a_step_that_is_late_promises_nothing_and_shrinks_the_way(free):
    free.go(free=(3.0, *FREE[1:]))
    free.go(1, free=None, tick=4 * TICK)

    assert "late" in free.flags
    assert free.go(1, free=None)[0] <= FULL + 0.05


def test_a_clock_that_stands_is_no_reason_to_go_faster(free):
    free.go(free=(0.4, *FREE[1:]))
    moving = free.core.last.command[0]
    free.core.tick(free.now)  # once more, at the same time

    assert free.core.last.command[0] <= moving
    assert "late" in free.flags


def test_lost_odometry_stops_no_later():
    """Odometry of a base that stands says how far it may still go."""
    sent = {}
    for seen in (True, False):
        world = World(CORES["odometry"])
        for _ in range(10):
            if seen:
                world.core.measure((0.0, 0.0), TURNED, world.ros + 1, "", world.now)
            speeds = world.go(1, free=(0.25, *FREE[1:]))
        sent[seen] = speeds[-1]

    assert 0 < sent[False] <= sent[True]


# -- limits ------------------------------------------------------------------------------------


def test_a_lower_limit_brings_the_base_inside_and_a_higher_one_acts_at_once(limits):
    assert limits.go(free=None)[-1] > FULL
    limits.core.limit("v_max", (0.2, 1.0), limits.now)
    slowing = limits.go(20, free=None)
    assert "slowing" not in limits.flags
    assert slowing[0] < 0.2
    assert 0.1 < slowing[-1] <= 0.2
    limits.core.limit("v_max", (9.0, 9.0), limits.now)
    assert limits.go(1, free=None)[0] > 0.2
    assert limits.go(20, free=None)[-1] == limits.go(1, free=None)[0] > FULL


@pytest.mark.parametrize(
    "topic, said",
    [
        *(("v_max", (limit, 1.0)) for limit in (0.0, 0.01, -1.0, -math.inf, math.nan)),
        *(("speed", said) for said in ((math.nan, 0.0), (-1.0, 0.0), (-10.0, 1.0))),
    ],
)
def test_a_limit_below_the_push_or_without_sense_is_a_stop(limits, topic, said):
    """With a flag where it is no number."""
    limits.go(free=None)
    limits.core.limit(topic, said, limits.now)

    assert limits.go(40, free=None)[-1] == 0.0
    assert ("limit-refused" in limits.flags) is math.isnan(said[0])


def test_a_limit_backwards_leaves_the_way_ahead(limits):
    limits.core.limit("v_min", (-0.1, -1.0), limits.now)

    assert limits.go(free=None)[-1] > FULL
    assert -0.1 <= limits.go(60, v=-0.5, free=None)[-1] < -0.02


def test_without_enable_it_stops_and_goes_on_with_it_without_a_reset(limits):
    limits.go(free=None)
    limits.core.limit("enable", (0.0, 0.0), limits.now)
    assert limits.go(20, free=None)[-1] == 0.0
    assert "limit-refused" not in limits.flags
    limits.core.limit("enable", (1.0, 0.0), limits.now)
    assert limits.go(30, free=None)[-1] > FULL


@pytest.mark.parametrize(
    "said, most",
    [
        ((40.0, 1.0), 0.2),
        ((0.3, 0.0), 0.3),
        ((7.0, 0.0), 0.5),
        ((0.0, 1.0), 0.5),
        ((0.0, 0.0), 0.5),
    ],
    ids=["percent", "speed", "beyond", "no percentage", "no limit"],
)
@pytest.mark.parametrize("way", [1, -1])
def test_a_speed_limit_cuts_both_ways(limits, said, most, way):
    limits.core.limit("speed", said, limits.now)
    largest = max(abs(v) for v in limits.go(60, v=0.5 * way, free=None))

    assert 0.7 * most < largest <= most


def test_a_speed_limit_clamps_and_does_not_scale(limits):
    limits.core.limit("speed", (50.0, 1.0), limits.now)

    assert limits.go(40, v=0.15, free=None)[-1] == 0.15


def test_the_lowest_of_several_limits_counts(limits):
    limits.core.limit("v_max", (0.3, 1.0), limits.now)
    limits.core.limit("speed", (0.2, 0.0), limits.now)
    assert 0.15 < limits.go(60, free=None)[-1] <= 0.2
    limits.core.limit("v_max", (0.1, 1.0), limits.now)
    assert limits.go(60, free=None)[-1] <= 0.1


def test_limits_stay_in_force_over_a_start(limits):
    limits.core.limit("v_max", (0.2, 1.0), limits.now)
    limits.core.start()

    assert limits.go(60, free=None)[-1] <= 0.2


def test_limits_that_end_are_a_stop_with_a_flag_until_they_come_again():
    world = World(CORES["silent"])
    begin(world.core)
    assert world.go(5, free=None) == [0.0] * 5  # before any came
    assert "limit-refused" in world.flags
    world.core.limit("v_max", (0.5, 1.0), world.now)
    assert world.go(10, free=None)[-1] > 0
    assert world.go(10, free=None)[-1] == 0.0
    assert "limit-refused" in world.flags
    world.core.limit("v_max", (0.5, 1.0), world.now)
    assert world.go(10, free=None)[-1] > 0


def test_other_limits_that_were_told_once_must_go_on_but_a_speed_limit():
    world = World(CORES["silent"])
    begin(world.core)
    speeds = {}
    for topic in ("enable", "speed"):
        begin(world.core)
        world.core.limit(topic, (1.0, 0.0), world.now)
        for _ in range(4):
            world.core.limit("v_max", (0.5, 1.0), world.now)
            speeds[topic] = world.go(8, free=None)[-1]

    assert speeds["enable"] == 0.0
    assert speeds["speed"] > FULL  # it comes when it changes


def test_the_smaller_one_of_limit_and_way_counts(free):
    free.core.limit("v_max", (0.2, 1.0), free.now)
    assert 0.1 < free.go(40)[-1] <= 0.2
    assert 0 < free.go(10, free=(0.07, *FREE[1:]))[-1] < 0.1
    begin(free.core)


# -- a step again ------------------------------------------------------------------------------


def in_a_passage(v, omega, ahead=0.05, count=120):
    """A base between walls 40 mm beside it and another one ahead [m]; (sent, free) a step."""
    beside = RADIUS + 0.04
    room = walls((0.0, 1.0, beside), (0.0, -1.0, beside), (1.0, 0.0, RADIUS + ahead))
    world, x, steps = World(CORES["seeing"]), 0.0, []
    for _ in range(count):
        world.ros, world.steady = world.ros + TICK, world.steady + TICK
        world.core.see(world.now)
        ranges = RPLIDAR.scan(room, (x, 0.0, 0.0))
        assert world.core.scan(0, RPLIDAR.numbers, ranges, world.ros, world.now) == ""
        world.core.command((v, omega), world.ros, "", world.now)
        sent = world.core.tick(world.now)
        x += 0.05 * sent.command[0]
        steps.append((sent, world.core.free))
    return steps


def test_where_the_window_is_in_the_way_it_looks_straight_on():
    """Back, between walls that a wide window counts as behind."""
    steps = in_a_passage(-0.4, 0.0)

    assert any(free[2] < 0.1 for _, free in steps)
    assert steps[-1][0].command[0] < -0.05


def test_so_near_that_it_must_be_held_the_base_backs_off():
    """By a hold, which the smallest window must have room for."""
    steps = in_a_passage(-0.3, 0.0, ahead=0.02)
    sent = [gated.command[0] for gated, _ in steps]

    assert sent[:5] == [0.0] * 5
    assert sent[-1] == -0.3


def test_a_turn_that_is_in_the_way_is_left_out():
    """To turn on the spot is refused, and to drive straight back is not."""
    steps = in_a_passage(-0.1, 0.9)
    straight = [sent for sent, free in steps if free[2] < 0.1]

    assert straight
    assert all(sent.command[1] == 0 for sent in straight)


def test_what_is_sent_is_the_gate_s_answer_to_what_is_told():
    """Bit for bit, limits and age included."""
    settings = GateSettings(odometry="none", **AT_ONCE)
    gate, world = Gate(load_scenario("paper-simulation", STATED), settings), World(CORES["free"])
    world.core.limit("v_max", (0.3, 0.7), world.now)
    told = (-0.5, 0.3, -1.0, 0.7, 0.6, math.inf, 0.4, 0.5, 0.0)
    for k in range(100):
        if k == 50:
            world.core.limit("v_max", (0.15, 0.7), world.now)
            told = (-0.5, 0.15, *told[2:])
        world.go(1, omega=0.2, free=told[4:8])
        assert world.core.last == gate.step((0.5, 0.2), 0.0, told=told)
    begin(world.core)
