"""Free distances that the filter node finds in scans, by its core in C."""

import math
from dataclasses import replace
from functools import cache
from tomllib import loads

import casadi as ca
import numpy as np
import pytest

from tests.papers_robot import preset
from tests.ros2.lasers import DEGREE, FAR, LDS_01, RPLIDAR, WIDE, walls
from tests.ros2.worlds import MS
from tests.tables import cases, changes
from wmr_ctrl.control.filter.gate import GateSettings
from wmr_ctrl.control.filter.stop_numbers import smallest_window
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.signals import LARGEST
from wmr_ctrl.ros2.clocks import Moment
from wmr_ctrl.ros2.filter_core import FilterCore
from wmr_ctrl.ros2.sight import SightSettings, remedy
from wmr_ctrl.world.scenario import load_scenario
from wmr_ctrl.world.sight import way_to_point

CHANGING = changes("""
limits.v_u1 = [0.5, 1.0]; limits.v_u2 = [0.4, 0.8]; clock.control = 0.05; base.kind = "velocity"
filter.kind = "governor"; filter.gain = [0.95, 1.05]; filter.tau = [0.1, 0.2]
filter.d = [0.03, 0.02]; filter.changing = true
""")
FREE = "filter.free_error = 0.02; filter.free_age = 0.25; filter.rest = 0.5"
STATED = {**CHANGING, **changes(FREE)}
RADIUS, LOOK = 0.2, 0.3
OPEN = walls()
STANDS = Moment(10**15, 7 * 10**9)


SCENARIO = load_scenario("paper-simulation", STATED)


@cache
def compiled(**settings):
    """A core that is compiled once for settings."""
    given = {"scans": ("scan",), "radius": RADIUS, "look": LOOK, **settings}
    return FilterCore(SCENARIO, GateSettings(odometry="none"), "", SightSettings(**given))


def core_of(*lasers, **settings):
    poses = tuple(float(number) for laser in lasers for number in laser.pose)
    names = tuple(f"scan{k}" for k in range(len(lasers)))
    core = compiled(scans=names, scan_pose=poses, **settings)
    core.start()
    return core


def free_of(core, *lasers, seen=OPEN, command=(0.0, 0.0)):
    """Free distances [m] of a step after one scan by each laser."""
    core.start()
    for k, laser in enumerate(lasers):
        assert core.scan(k, laser.numbers, laser.scan(seen), STANDS.ros, STANDS) == ""
    core.command(command, STANDS.ros, "", STANDS)
    core.tick(STANDS)
    return core.free


def only(distance, at, width=DEGREE / 2):
    """Scan with a single object, at an angle, within a width on either side."""
    return lambda x, y, angle: (
        distance if abs(math.remainder(angle - at, math.tau)) <= width else FAR
    )


def points_of(laser, ranges):
    """Points of a scan in the base's frame, with the arithmetic of C."""
    x, y, yaw = laser.pose
    held = np.array(ranges, np.float32).astype(float)
    held = np.where(held == np.inf, laser.most, held)
    for angle, r in zip(laser.angles(), held, strict=True):
        yield x + r * math.cos(yaw + angle), y + r * math.sin(yaw + angle)


def nearest_way(points, window, sense):
    """Least distance to points by the graph itself."""
    place, sides, radius = ca.SX.sym("place", 2), ca.SX.sym("sides", 2), ca.SX.sym("radius")
    way = way_to_point((place[0], place[1]), (sides[0], sides[1]), radius, sense)
    graph = ca.Function("way", [place, sides, radius], [way])
    return min(float(graph(list(point), window, RADIUS)) for point in points)


@pytest.mark.parametrize("laser", [LDS_01, RPLIDAR], ids=["LDS-01", "RPLIDAR"])
def test_free_distances_have_the_bits_of_the_graph(laser):
    placed = replace(laser, pose=(0.05, -0.02, 0.4))
    room = walls((1.0, 0.2, 1.3), (-1.0, 0.0, 0.9), (0.1, 1.0, 0.7), (0.0, -1.0, 0.3))
    free = free_of(core_of(placed), placed, seen=room)
    points = list(points_of(placed, placed.scan(room)))

    # Nothing is near, so that the window is the one that was asked for.
    assert free[2:] == (LOOK, LOOK)
    assert free[:2] == tuple(nearest_way(points, [LOOK, LOOK], sense) for sense in (1, -1))


def test_what_does_not_return_is_as_far_as_the_laser_sees():
    far = RPLIDAR.most - RADIUS

    assert free_of(core_of(RPLIDAR), RPLIDAR)[:2] == pytest.approx((far, far), abs=1e-3)


@pytest.mark.parametrize("silence", [0.0, math.nan, LDS_01.most + 1], ids=["0", "NaN", "beyond"])
def test_silence_is_blind_unless_it_is_stated_as_far(silence):
    """The laser sends something other than infinity if nothing returns."""
    laser, wall = replace(LDS_01, silence=silence), walls((1.0, 0.0, 0.4))
    blind, far = core_of(laser), core_of(laser, no_return="range_max")

    assert free_of(blind, laser, seen=wall)[1] <= 0
    assert blind.sights[0].blind == sum(not 0 < r <= laser.most for r in laser.scan(wall))
    ends = 0.4 - RADIUS, laser.most - RADIUS
    assert free_of(far, laser, seen=wall)[:2] == pytest.approx(ends, abs=1e-3)
    assert far.sights[0].blind == 0


@pytest.mark.parametrize("near", [0.05, -1.0, -math.inf], ids=["near", "negative", "-inf"])
@pytest.mark.parametrize("no_return", ["blind", "range_max"])
def test_below_the_least_range_is_0_m(near, no_return):
    core = core_of(RPLIDAR, no_return=no_return)
    ahead, behind, *_ = free_of(core, RPLIDAR, seen=only(near, 0.0))

    assert -0.001 < ahead <= 0 < behind


def test_a_beam_across_the_window_blocks_neither_side_unless_something_is_there():
    """The beam is at a right angle and longer than the disc's radius."""
    assert min(free_of(core_of(RPLIDAR), RPLIDAR, seen=only(0.3, math.pi / 2))[:2]) > 5


@pytest.mark.parametrize(
    "omega, sides",
    [(0.5, (LOOK + 0.45, LOOK)), (-0.5, (LOOK, LOOK + 0.45)), (1e9, (1.5, LOOK))],
)
def test_window_is_wider_where_the_command_turns_to_and_never_a_quarter(omega, sides):
    wall = walls((0.0, 1.0, 0.45))

    assert free_of(core_of(RPLIDAR), RPLIDAR, seen=wall, command=(0.2, omega))[2:] == sides


def test_any_heading_is_free_where_nothing_is_nearer_than_a_stop_takes():
    """Then a late step closes no window."""
    core = core_of(RPLIDAR)
    near, far = (free_of(core, RPLIDAR, seen=walls((1.0, 0.0, c))) for c in (0.35, 0.6))

    assert near[2:] == (LOOK, LOOK)
    assert far[2:] == (LARGEST, LARGEST)
    assert far[0] == far[1] == pytest.approx(0.6 - RADIUS, abs=1e-3)


def test_a_laser_never_lets_the_base_where_it_does_not_see():
    """A view of half a turn allows neither direction, since an edge of a turning disc leaves the
    view.
    """
    core, half = core_of(WIDE), replace(RPLIDAR, first=-math.pi / 2, beams=181)
    ahead, behind, *_ = free_of(core, WIDE)

    assert core.never == ("behind",)
    assert ahead == pytest.approx(WIDE.most - RADIUS, abs=1e-3)
    assert -0.001 < behind <= 0
    free_of(core_of(half), half)
    assert core.never == ("ahead", "behind")


def test_two_lasers_at_opposite_corners_see_all():
    front = replace(WIDE, pose=(0.1, 0.1, math.pi / 4))
    rear = replace(WIDE, pose=(-0.1, -0.1, -3 * math.pi / 4))
    core = core_of(front, rear)
    assert core.scan(0, front.numbers, front.scan(OPEN), STANDS.ros, STANDS) == ""
    assert core.never == ()  # not before each was heard
    free = free_of(core, front, rear)

    assert core.never == ()
    assert min(free[:2]) > 20


def test_two_lasers_side_by_side_are_both_blind_behind():
    core = core_of(WIDE, WIDE)

    assert free_of(core, WIDE, WIDE)[1] <= 0
    assert core.never == ("behind",)


def test_an_own_part_is_in_the_way_unless_its_angles_are_ignored():
    """A pole is 0.15 m behind the laser, within the disc."""
    pole = only(0.16, math.pi, width=0.1)
    seeing, ignoring = core_of(RPLIDAR), core_of(RPLIDAR, ignore=(3.0, 3.3))

    assert free_of(seeing, RPLIDAR, seen=pole)[1] < 0
    assert seeing.sights[0].nearest == pytest.approx(0.16)
    assert abs(math.remainder(seeing.sights[0].nearest_at - math.pi, math.tau)) < 0.11
    assert free_of(ignoring, RPLIDAR, seen=pole)[1] > 10
    assert ignoring.sights[0].nearest == RPLIDAR.most


def test_angles_that_are_ignored_need_no_beam():
    core = core_of(WIDE, ignore=(2.3, 4.0))
    free = free_of(core, WIDE)

    assert core.never == ()
    assert min(free[:2]) > 20


def test_a_laser_that_counts_clockwise_sees_the_same():
    room = walls((1.0, 0.2, 1.3), (-1.0, 0.4, 0.9))
    mirrored = replace(WIDE, first=-WIDE.first, step=-WIDE.step)
    ways, again = (free_of(core_of(one), one, seen=room) for one in (WIDE, mirrored))

    assert again == pytest.approx(ways, abs=1e-4)


# -- messages that do not count --------------------------------------------------------------


@pytest.mark.parametrize(
    "numbers, count",
    [
        ("0 0 0.1 3.5", 10),
        ("nan 0.0175 0.1 3.5", 360),
        ("0 0.0175 0.1 inf", 360),
        ("0 0.0175 nan 3.5", 360),
        ("0 0.0175 0.1 3.5", 0),
        ("0 0.001 0.1 3.5", 4097),
    ],
    ids=["no step", "no angle", "no largest range", "no least range", "no beam", "too many"],
)
def test_messages_that_cannot_be_used_are_refused(numbers, count):
    core = core_of(RPLIDAR)
    reason = core.scan(0, tuple(map(float, numbers.split())), [1.0] * count, STANDS.ros, STANDS)

    assert reason == "of a size or with angles that cannot be used"
    assert core.frees[0].refused[reason] >= 1


def test_a_scan_that_is_old_or_repeated_does_not_count():
    core, scan = core_of(RPLIDAR), RPLIDAR.scan(OPEN)
    assert core.scan(0, RPLIDAR.numbers, scan, STANDS.ros - 300 * MS, STANDS) == "too old"
    assert "no-distance" in core.tick(STANDS).flags
    assert core.scan(0, RPLIDAR.numbers, scan, STANDS.ros, STANDS) == ""
    later = Moment(STANDS.ros + 100 * MS, STANDS.steady + 100 * MS)

    repeated = core.scan(0, RPLIDAR.numbers, scan, STANDS.ros, later)
    assert repeated == "repeated or out of order"


def test_without_one_of_two_lasers_no_distance_is_told():
    rear = replace(RPLIDAR, pose=(-0.1, 0.0, math.pi))
    core = core_of(RPLIDAR, rear)
    core.scan(0, RPLIDAR.numbers, RPLIDAR.scan(OPEN), STANDS.ros, STANDS)
    assert "no-distance" in core.tick(STANDS).flags
    core.scan(1, rear.numbers, rear.scan(OPEN), STANDS.ros, STANDS)
    assert "no-distance" not in core.tick(STANDS).flags


def test_the_oldest_of_two_scans_counts():
    """A scan that is too old stops the base, which may have driven since then."""
    rear, flags = replace(RPLIDAR, pose=(-0.1, 0.0, math.pi)), []
    for old in (0, 1):
        core = core_of(RPLIDAR, rear)
        for k, laser in enumerate((RPLIDAR, rear)):
            stamp = STANDS.ros - (200 * MS if k == old else 0)
            assert core.scan(k, laser.numbers, laser.scan(OPEN), stamp, STANDS) == ""
        later = Moment(STANDS.ros + 100 * MS, STANDS.steady + 100 * MS)
        core.tick(later)
        flags.append("no-distance" in core.last.flags)

    assert flags == [True, True]


# -- settings that are refused -----------------------------------------------------------------


@pytest.mark.parametrize(
    "told, said",
    cases("""
        radius = 0.0 | the disc must hold the robot
        scan_pose = [0.3, 0.0, 0.0] | the disc must hold the robot
        scan_pose = [0.0, 0.0] | give three
        scans = ["a", "b", "c", "d", "e"]; scan_pose = [0,0,0,0,0,0,0,0,0,0,0,0,0,0,0] | may be 4
        look = 0.005 | through which a push turns the base
        look = 1.6 | look = 1.6 rad must be from
        ignore = [0.1] | odd number
    """),
)
def test_settings_that_cannot_be_are_a_sentence(told, said):
    given = loads(told.replace("; ", "\n"))
    with pytest.raises(ArgumentError, match=said):
        SightSettings(**{"scans": ("scan",), "radius": RADIUS, **given}).check(SCENARIO)


@pytest.mark.parametrize(
    "told, said",
    cases("""
        scans = ["scan"] | asks for no distances
        limit_timeout = 1.0 | filter.changing = true
        speed_limit = "speed_limit" | filter.changing = true
    """),
)
def test_settings_that_the_scenario_does_not_use_are_refused(told, said):
    clip = "filter.kind = 'clip'; filter.gain = [1.0, 1.0]; filter.d = [0.0, 0.0]"
    with pytest.raises(ArgumentError, match=said):
        SightSettings(**loads(told)).check(preset("paper-simulation", clip))


def test_look_is_at_least_what_a_push_turns_through():
    least, with_hold = smallest_window(SCENARIO)
    SightSettings(scans=("scan",), radius=RADIUS, look=least).check(SCENARIO)

    assert 0 < least < with_hold


def test_who_does_not_push_needs_no_hold():
    assert remedy(preset("paper-simulation", STATED, "filter.d = [0.0, 0.0]")) == "near: back off"
    assert remedy(SCENARIO).startswith("near: back off, hold it for 0.")
