"""Limits and free distances of the filter node as decisions of its core: single edge cases."""

import math
from functools import cache

import pytest

from tests.papers_robot import preset
from tests.ros2.lasers import RPLIDAR, walls
from tests.ros2.test_scans import CHANGING, RADIUS, STATED
from tests.ros2.worlds import MS, World
from wmr_ctrl.control.filter.gate import GateSettings
from wmr_ctrl.ros2.compiled_system import Gate
from wmr_ctrl.ros2.filter_core import FilterCore
from wmr_ctrl.ros2.sight import SightSettings

AT_ONCE = GateSettings(odometry="none", rise=(1e6, 1e6), fall=(1e6, 1e6))
FULL = 0.44
"""Speed [m/s] that the filter reaches if only the limit restricts it."""


@cache
def core_of(told, **sight):
    scenario = preset("paper-simulation", CHANGING if told == "limits" else STATED)
    return FilterCore(scenario, AT_ONCE, "", SightSettings(**sight))


@pytest.fixture
def free():
    return World(core_of("ways"), ahead=math.inf)


@pytest.fixture
def limits():
    return World(core_of("limits"))


@pytest.fixture
def silent():
    return World(core_of("limits", limit_timeout=0.5))


# -- free distances -----------------------------------------------------------------------------


@pytest.mark.parametrize("ahead", [0.0, -1.0, -math.inf])
def test_no_way_ahead_is_a_stop_at_once(free, ahead):
    assert free.go()[-1] > FULL
    free.ahead = ahead

    assert free.go(3) == [0.0] * 3
    assert "near" in free.flags
    assert "no-distance" not in free.flags


def test_a_way_that_is_no_number_is_not_told_and_the_others_are(free):
    """The last distance is used instead, less the distance driven since then."""
    free.ahead = 3.0
    free.go()
    free.ahead = math.nan
    speeds = free.go(200)

    assert speeds[0] > FULL
    assert speeds[-1] < 0.01
    assert 1.5 < 0.05 * sum(speeds) < 3.0


@pytest.mark.parametrize("count", [0, 3, 5])
def test_other_than_four_ways_are_refused(free, count):
    assert "cannot be used" in free.core.hear_free([1.0] * count, free.now())


def test_ways_that_are_not_told_shrink_until_the_base_stands_before_them(free):
    free.ahead = None
    assert free.go(5) == [0.0] * 5  # never told
    assert {"no-distance", "near"} <= free.flags
    free.ahead = 2.0
    free.go()
    free.ahead = None
    speeds = free.go(200)

    assert speeds[0] > FULL
    assert speeds[-1] == 0.0
    assert 1.0 < 0.05 * sum(speeds) < 2.0
    assert {"no-distance", "near"} <= free.flags


def test_ways_count_for_free_age_and_no_longer(free):
    free.go()
    free.ahead = None
    flags = [free.go(1) and "no-distance" in free.flags for _ in range(7)]

    assert flags == [False] * 5 + [True] * 2  # free_age is five periods


def test_ways_that_waited_while_the_process_stood_still_are_refused(free):
    free.go()
    free.wait(600 * MS)

    assert "queued" in free.core.hear_free((math.inf,) * 4, free.now())


def test_a_stop_for_what_is_in_the_way_is_not_ramped():
    slow = GateSettings(odometry="none", fall=(0.1, 0.1))
    world = World(FilterCore(preset("paper-simulation", STATED), slow, ""), ahead=math.inf)
    assert world.go(60)[-1] > FULL
    world.ahead = 0.05

    assert world.go(1) == [0.0]


def test_the_base_stands_before_a_wall_and_backs_off(free):
    """The free distance ahead is exact for a base that follows its command immediately."""
    free.ahead = 1.0
    for _ in range(300):
        free.ahead -= 0.05 * free.go(1)[0]
    assert 0.02 < free.ahead < 0.15  # error, push and one release
    assert free.go(40, v=-0.3)[-1] < -0.29


def test_a_step_that_is_late_promises_nothing_and_shrinks_the_way(free):
    free.ahead = 3.0
    free.go()
    free.ahead = None
    free.go(1, periods=4)

    assert "late" in free.flags
    assert free.go(1)[0] <= FULL + 0.05


def test_a_clock_that_stands_is_no_reason_to_go_faster(free):
    free.ahead = 0.4
    moving = free.go()[-1]
    free.core.tick(free.now())  # once more, at the same time

    assert free.core.last.command[0] <= moving
    assert "late" in free.flags


# -- limits ------------------------------------------------------------------------------------


def test_a_lower_limit_brings_the_base_inside_and_a_higher_one_acts_at_once(limits):
    assert limits.go()[-1] > FULL
    limits.limit("v_max", 0.2, 1.0)
    slowing = limits.go(20)
    assert "slowing" not in limits.flags
    assert slowing[0] < 0.2
    assert 0.1 < slowing[-1] <= 0.2
    limits.limit("v_max", 9.0, 9.0)
    assert limits.go(1)[0] > 0.2
    assert limits.go(20)[-1] == limits.go(1)[0] > FULL


@pytest.mark.parametrize(
    "topic, said",
    [
        *(("v_max", (limit, 1.0)) for limit in (0.0, 0.01, -1.0, -math.inf, math.nan)),
        *(("speed", said) for said in ((math.nan, 0.0), (-1.0, 0.0), (-10.0, 1.0))),
    ],
)
def test_a_limit_below_the_push_or_without_sense_is_a_stop(limits, topic, said):
    """The flag ``limit-refused`` is set if the value is NaN."""
    limits.go()
    limits.limit(topic, *said)

    assert limits.go()[-1] == 0.0
    assert ("limit-refused" in limits.flags) is math.isnan(said[0])


def test_a_limit_backwards_leaves_the_way_ahead(limits):
    limits.limit("v_min", -0.1, -1.0)

    assert limits.go()[-1] > FULL
    assert -0.1 <= limits.go(60, v=-0.5)[-1] < -0.02


def test_without_enable_it_stops_and_goes_on_with_it_without_a_reset(limits):
    limits.go()
    limits.limit("enable", 0.0, 0.0)
    assert limits.go(20)[-1] == 0.0
    assert "limit-refused" not in limits.flags
    limits.limit("enable", 1.0, 0.0)
    assert limits.go(30)[-1] > FULL


@pytest.mark.parametrize(
    "said, most",
    [((40, 1), 0.2), ((0.3, 0), 0.3), ((7, 0), 0.5), ((0, 1), 0.5), ((0, 0), 0.5)],
    ids=["percent", "speed", "beyond", "no percentage", "no limit"],
)
@pytest.mark.parametrize("way", [1, -1])
def test_a_speed_limit_cuts_both_ways_and_does_not_scale(limits, said, most, way):
    limits.limit("speed", *said)

    assert 0.7 * most < max(abs(v) for v in limits.go(60, v=0.5 * way)) <= most
    assert limits.go(v=0.15 * way)[-1] == 0.15 * way


def test_the_lowest_of_several_limits_counts_also_over_a_start(limits):
    limits.limit("v_max", 0.3, 1.0)
    limits.limit("speed", 0.2, 0.0)
    assert 0.15 < limits.go(60)[-1] <= 0.2
    limits.limit("v_max", 0.1, 1.0)
    assert limits.go(60)[-1] <= 0.1
    limits.core.start()
    assert limits.go(60)[-1] <= 0.1


def test_limits_that_end_are_a_stop_with_a_flag_until_they_come_again(silent):
    assert silent.go(5) == [0.0] * 5  # before any came
    for _ in range(2):
        assert "limit-refused" in silent.flags
        silent.limit("v_max", 0.5, 1.0)
        assert silent.go(10)[-1] > 0
        assert silent.go(10)[-1] == 0.0


@pytest.mark.parametrize("topic, goes_on", [("enable", False), ("speed", True)])
def test_other_limits_that_were_told_once_must_go_on_but_a_speed_limit(silent, topic, goes_on):
    """A speed limit is sent only when it changes."""
    silent.limit(topic, 1.0, 0.0)
    for _ in range(4):
        silent.limit("v_max", 0.5, 1.0)
        speed = silent.go(8)[-1]

    assert speed > FULL if goes_on else speed == 0.0


def test_the_smaller_one_of_limit_and_way_counts(free):
    free.limit("v_max", 0.2, 1.0)
    assert 0.1 < free.go()[-1] <= 0.2
    free.ahead = 0.07
    assert 0 < free.go(10)[-1] < 0.1


# -- a step again ------------------------------------------------------------------------------


def in_a_passage(v, omega, ahead=0.05):
    """A base between walls 40 mm beside it and another one ahead [m]; (sent, free) for each
    step.
    """
    beside = RADIUS + 0.04
    room = walls((0.0, 1.0, beside), (0.0, -1.0, beside), (1.0, 0.0, RADIUS + ahead))
    world, x, steps = World(core_of("ways", scans=("scan",), radius=RADIUS)), 0.0, []
    for _ in range(120):
        world.wait(50 * MS)
        ranges = RPLIDAR.scan(room, (x, 0.0, 0.0))
        assert world.core.scan(0, RPLIDAR.numbers, ranges, world.ros, world.now()) == ""
        world.command(world.ros, v, omega)
        sent = world.core.tick(world.now())
        x += 0.05 * sent.command[0]
        steps.append((sent.command, world.core.free))
    return steps


def test_where_the_window_is_in_the_way_it_looks_straight_on():
    """The base moves back between walls that a wide window would treat as behind it."""
    steps = in_a_passage(-0.4, 0.0)

    assert any(free[2] < 0.1 for _, free in steps)
    assert steps[-1][0][0] < -0.05


def test_so_near_that_it_must_be_held_the_base_backs_off():
    """The filter holds the base at zero first; the smallest window has room for this hold."""
    sent = [command[0] for command, _ in in_a_passage(-0.3, 0.0, ahead=0.02)]

    assert sent[:5] == [0.0] * 5
    assert sent[-1] == -0.3


def test_a_turn_that_is_in_the_way_is_left_out():
    """Turning on the spot is refused, driving straight back is not."""
    straight = [omega for (_, omega), free in in_a_passage(-0.1, 0.9) if free[2] < 0.1]

    assert straight
    assert not any(straight)


def test_what_is_sent_is_the_gate_s_answer_to_what_is_told(free):
    """Bit for bit, including limits and ages."""
    gate = Gate(preset("paper-simulation", STATED), AT_ONCE)
    free.ahead = 0.6
    for k in range(100):
        most = 0.3 if k < 50 else 0.15
        free.limit("v_max", most, 0.7)
        free.go(1, omega=0.2)
        told = (-0.5, most, -1.0, 0.7, 0.6, math.inf, 0.5, 0.5, 0.0)
        assert free.core.last == gate.step((0.5, 0.2), 0.0, told=told)
