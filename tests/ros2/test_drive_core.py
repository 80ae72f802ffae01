"""Faults around the drive, as decisions of its core: the base rests, the reference waits."""

import math

import pytest

from tests.papers_robot import preset
from tests.ros2.worlds import MS, Clocked
from tests.tables import changes
from wmr_ctrl.control.filter.gate import GateSettings
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.ros2.clocks import BACK, FORTH, FROZEN
from wmr_ctrl.ros2.drive_core import (
    ARRIVED,
    CALM,
    JUMPED,
    MISSED,
    NEW_PATH,
    NO_ODOMETRY,
    NO_PATH,
    STOPPED,
    DriveCore,
    DriveSettings,
)

TICK = 20 * MS
FALL = 2.0
BASE = changes("""
limits.v_u1 = [1.0, 2.0]; clock.control = 0.02; base.kind = "velocity"; base.tau = [0.05, 0.05]
filter.kind = "clip"; filter.gain = [0.9, 1.1]; filter.d = [0.05, 0.05]; disturbance.std = 0.0
""")
CIRCLE = "reference.radius = 1.0; reference.rate = 0.3"
WAY = """
reference.kind = "waypoints"; reference.points = [[0.0, 0.0], [0.5, 0.0], [1.0, 0.1]]
reference.speed = 0.3
"""
GATE = GateSettings(odometry="required", command_timeout=0.1, fall=(FALL, 2 * FALL))


def core_of(*told, **settings):
    scenario = preset("paper-simulation", BASE, *told)
    return DriveCore(settle(scenario, "kanayama"), DriveSettings(gate=GATE, **settings))


@pytest.fixture(scope="module")
def built():
    return core_of(CIRCLE)


@pytest.fixture
def world(built):
    built.counts.clear()
    built.clocks.struct.counts[:] = [0, 0, 0]
    return World(built)


class World(Clocked):
    """A base that follows its command without delay, and its odometry."""

    pose, speed = (0.0, 0.0, 0.0), (0.0, 0.0)

    def pass_by(self, time=TICK):
        """Let time pass in which the base moves on."""
        x, y, yaw = self.pose
        h, (v, omega) = time * 1e-9, self.speed
        self.pose = x + h * v * math.cos(yaw), y + h * v * math.sin(yaw), yaw + h * omega
        self.wait(time)

    def message(self, stamp=None, frame="odom", child="base_link", spoil=None):
        x, y, yaw = self.pose
        numbers = [x, y, 0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2), *self.speed]
        for place, value in (spoil or {}).items():
            numbers[place] = value
        stamp = self.ros if stamp is None else stamp
        reason, gated = self.core.odometry(tuple(numbers), stamp, frame, child, self.now())
        return reason, self.take(gated)

    def tick(self):
        return self.take(self.core.tick(self.now()))

    def take(self, gated):
        self.speed = gated.command if gated else self.speed
        return gated

    def drive(self, count=100):
        """Valid samples, each with its tick."""
        for _ in range(count):
            self.pass_by()
            assert self.message()[0] == ""
            self.tick()
        return self.core.last

    def starve(self, count=60, refused=None):
        """Ticks without a valid message; returns the commands sent."""
        sent = []
        for _ in range(count):
            self.pass_by()
            if refused:
                assert self.message(**refused)[0]
            gated = self.tick()
            sent += [gated.command] if gated else []
        return sent


def test_before_odometry_zeros_are_sent_and_the_first_message_drives(world):
    assert world.starve(5) == [(0.0, 0.0)] * 5
    assert world.core.last.flags == (NO_ODOMETRY,)
    world.pass_by()
    _, gated = world.message()
    assert gated.command != (0.0, 0.0)


@pytest.mark.parametrize(
    "change, reason",
    [
        ({"frame": "map"}, "wrong frame"),
        ({"child": "laser"}, "wrong frame"),
        ({"stamp": 0}, "without a stamp"),
        ({"spoil": {5: 0.0, 4: 0.0}}, "not a rotation"),
        ({"spoil": {0: math.inf}}, "not a number"),
    ],
)
def test_odometry_that_does_not_count_ends_in_rest(world, change, reason):
    world.drive()
    v = world.core.last.command[0]
    assert world.message(**change) == (reason, None)
    sent = world.starve(refused=change)
    assert sent[0][0] < v
    assert sent[-1] == (0.0, 0.0)
    assert world.core.last.flags[-1] == NO_ODOMETRY


def test_without_odometry_the_ramp_begins_after_the_timeout_and_ends_in_zeros(world):
    v = world.drive().command[0]
    sent = world.starve()
    silent = 60 - len(sent)
    assert silent * TICK * 1e-9 <= GATE.odometry_timeout + 2 * TICK * 1e-9
    step = FALL * TICK * 1e-9
    expected = [max(v - step * k, 0.0) for k in range(1, len(sent) + 1)]
    assert [pair[0] for pair in sent] == pytest.approx(expected, abs=1e-9)


def test_the_reference_waits_and_the_law_begins_anew(world):
    world.drive()
    sample = world.core._sample
    world.starve()
    for still in (True, True, False):
        world.pass_by()
        _, gated = world.message()
        assert (gated.command == (0.0, 0.0)) is still
    assert world.core._sample == sample + 1
    assert max(map(abs, world.core.e)) < 0.2  # not by how far the circle would be by now
    world.drive(300)
    assert max(map(abs, world.core.e)) < 0.02


def test_a_pose_that_jumps_brakes_at_once(world):
    v = world.drive().command[0]
    world.pose = world.pose[0] + 1.0, *world.pose[1:]
    world.pass_by()
    _, gated = world.message()
    assert gated.command[0] == pytest.approx(v - FALL * TICK * 1e-9)
    assert gated.flags[-1] == JUMPED
    assert world.core.counts[JUMPED] == 1


def test_ros_time_that_goes_back_rests_and_goes_on_where_the_reference_stood(world):
    world.drive()
    sample, world.ros = world.core._sample, world.ros - 500_000 * MS
    world.drive(CALM - 1)
    assert world.core.held == BACK
    assert world.core._sample == sample
    world.drive(300)
    assert not world.core.held
    assert max(map(abs, world.core.e)) < 0.02


def test_ros_time_that_leaps_ahead_does_not_carry_the_reference_along(world):
    world.drive()
    sample, world.ros = world.core._sample, world.ros + 10_000 * MS
    world.drive(CALM)
    assert world.core.clocks.counts == {FORTH: 1}
    assert world.core.counts[NO_ODOMETRY] == 1
    assert world.core._sample == sample + 1


def test_a_process_that_stood_still_begins_anew(world):
    """The base held the last command meanwhile, until its own time-out; the node cannot prevent
    this.
    """
    world.drive()
    queued = world.ros
    world.pass_by(600 * MS)
    assert world.message(stamp=queued + 1)[0] == "too old"
    assert world.core.clocks.counts == {FROZEN: 1}
    assert world.tick().command[0] < world.core.setup.scenario.limits.v_u1[0]
    assert world.core.held == NO_ODOMETRY


def test_a_stop_is_zero_at_once_and_stays(world):
    world.drive()
    assert world.take(world.core.halt(True, world.now())).command == (0.0, 0.0)
    world.core.start()  # as when it is deactivated and activated again
    assert not world.core.reset()
    assert world.drive(10).command == (0.0, 0.0)
    world.core.halt(False, world.now())
    assert world.drive(10).command == (0.0, 0.0)
    assert STOPPED in world.core.last.flags
    assert world.core.reset()
    assert world.drive(10).command != (0.0, 0.0)


def test_a_base_faster_than_its_bounds_allow_is_stopped_until_a_reset(world):
    world.drive()
    world.pass_by()
    world.message(spoil={6: 1.2})
    assert "too-fast" in world.core.last.flags
    assert world.drive(60).command == (0.0, 0.0)
    assert world.core.reset()
    assert world.drive(10).command != (0.0, 0.0)


def test_the_oldest_odometry_of_a_sample_is_told(world):
    world.drive()
    world.core.oldest = 0.0
    world.pass_by()
    world.ros += 7 * MS
    world.message(stamp=world.ros - 7 * MS)
    assert world.core.oldest == pytest.approx(0.007)
    world.drive(1)
    assert world.core.oldest == pytest.approx(0.007)


def test_missed_periods_are_counted_and_time_stays_true(world):
    world.drive()
    before = world.core._sample
    world.pass_by(3 * TICK)
    _, gated = world.message()
    assert MISSED in gated.flags
    assert world.core.counts[MISSED] == 2
    assert world.core._sample == before + 3
    assert MISSED not in world.drive(1).flags


def test_a_timeout_in_which_no_sample_can_come_and_a_path_without_waypoints_are_refused():
    with pytest.raises(ScenarioError, match="waypoints"):
        core_of(CIRCLE, path=True)
    with pytest.raises(ScenarioError, match=r"odometry_timeout = 0\.1 s is too short"):
        core_of(CIRCLE, "clock.control = 0.1")


# -- a path ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def follower():
    return core_of(WAY, path=True)


PATH = [(0.0, 0.0), (0.5, 0.0), (1.0, 0.1), (1.5, 0.1)]


def test_a_path_is_driven_to_its_end(follower):
    world = World(follower)
    assert world.drive(20).command == (0.0, 0.0)
    assert world.core.held == NO_PATH
    assert follower.follow(PATH, "map") != ""
    assert follower.follow([*PATH, (math.nan, 0.0)], "odom") != ""
    assert world.drive(5).flags[-1] == NO_PATH
    assert follower.follow(PATH, "odom") == ""
    assert world.drive(900).flags[-1] == ARRIVED
    assert world.pose[:2] == pytest.approx(PATH[-1], abs=0.02)
    assert world.core.last.command == pytest.approx((0.0, 0.0), abs=0.02)


def test_a_new_path_begins_where_the_base_has_come_to_rest(follower):
    world = World(follower)
    follower.follow(PATH, "odom")
    assert world.drive(150).command[0] > 0.1
    follower.follow([(x, -y) for x, y in PATH], "odom")
    assert world.drive(1).flags[-1] == NEW_PATH
    speeds = [world.drive(1).command[0] for _ in range(30)]
    assert 0.0 in speeds
    assert world.core.held == ""


def test_a_path_that_cannot_be_driven_is_told(follower):
    world = World(follower)
    follower.follow([(0.0, 0.0), (0.0, 0.0)], "odom")
    assert world.drive(10).command == (0.0, 0.0)
    assert "reference.points" in follower.problem
    assert world.core.held == NO_PATH


# -- efforts ---------------------------------------------------------------------------------


def efforts(told=""):
    guarded = "guard.enabled = true; disturbance.truncate = 3.0"
    scenario = preset("paper-simulation", guarded, told)
    return DriveCore(settle(scenario, "mb"), DriveSettings(gate=GATE))


@pytest.fixture(scope="module")
def effort():
    return efforts()


def standing(core, **how):
    """The world of a base at rest, after a first sample."""
    world = World(core, **how)
    world.take = lambda gated: gated
    world.pass_by(10 * MS)
    assert world.message()[1].command != (0.0, 0.0)
    return world


@pytest.mark.parametrize("simulated", [True, False])
def test_torques_without_fresh_odometry_are_zero(effort, simulated):
    world = standing(effort, simulated=simulated)
    silent = 0
    while not world.tick():
        world.pass_by(5 * MS)
        silent += 5
    assert effort.last.command == (0.0, 0.0)
    assert 0 <= silent - (100 if simulated else 15) <= 5  # 1.5 periods: the guard counts on one
    assert effort.last.flags == (NO_ODOMETRY,)


def test_torques_under_way_are_waited_for():
    core = efforts("actuator.delay = 0.05")
    world = standing(core)
    core.halt(True, world.now())
    core.halt(False, world.now())
    core.reset()
    zeros = 0
    while world.message()[1] is None or core.last.command == (0.0, 0.0):
        world.pass_by(10 * MS)
        zeros += 1
    assert zeros == 6  # 50 ms of 10 ms each, and one of unlike clocks


def test_a_stop_of_torques_is_zero_torque_and_latched(effort):
    world = standing(effort)
    assert effort.halt(True, world.now()).command == (0.0, 0.0)
    effort.halt(False, world.now())
    for _ in range(5):
        world.pass_by(10 * MS)
        assert world.message()[1].command == (0.0, 0.0)
    assert effort.reset()
    world.pass_by(10 * MS)
    assert world.message()[1].command != (0.0, 0.0)
