"""Which messages count."""

import math

import pytest

from wmr_ctrl.ros2.clocks import Moment
from wmr_ctrl.ros2.intake import Intake, is_rotation

MS = 1_000_000
NOW, STEADY = 1_000_000 * MS, 5_000 * MS


@pytest.fixture
def intake():
    return Intake(timeout=100 * MS, value=(0.0, 0.0), frame="base_link")


def take(intake, *, value=(0.3, 0.1), stamp=NOW, frame="base_link", simulated=False, steady=STEADY):
    return intake.take(value, stamp, frame, Moment(NOW, steady, simulated))


def age(intake, steady):
    return intake.age(Moment(NOW, steady))


@pytest.mark.parametrize(
    "changes, reason",
    [
        ({"value": (math.nan, 0.0)}, "not a number"),
        ({"value": (0.0, -math.inf)}, "not a number"),
        ({"frame": "map"}, "wrong frame"),
        ({"stamp": NOW + 60 * MS}, "from the future"),
        ({"stamp": NOW + 60 * MS, "simulated": True}, ""),
        ({"stamp": NOW + 110 * MS, "simulated": True}, "from the future"),
        ({"stamp": NOW - 110 * MS}, "too old"),
        ({"stamp": NOW - 10 * MS}, "repeated or out of order"),
        ({}, "repeated or out of order"),
        ({"stamp": NOW + 1}, ""),
        ({"stamp": 0}, ""),
        ({"stamp": NOW + 10 * MS, "frame": ""}, ""),
    ],
)
def test_a_second_message_counts_or_is_told_why_not(intake, changes, reason):
    assert take(intake) == ""
    assert take(intake, **changes) == reason
    assert intake.refused == ({reason: 1} if reason else {})
    assert intake.taken == (1 if reason else 2)


def test_where_a_frame_must_be_named_none_is_wrong():
    strict = Intake(timeout=100 * MS, value=(0.0, 0.0), frame="base_link", named=True)
    assert take(strict, frame="") == "wrong frame"
    assert take(strict) == ""


def test_age_is_that_of_what_the_message_tells(intake):
    assert age(intake, STEADY) == -1.0
    take(intake, stamp=NOW - 40 * MS)
    assert age(intake, STEADY + 20 * MS) == pytest.approx(0.06)
    take(intake, stamp=0, steady=STEADY + 1000 * MS)
    assert age(intake, STEADY + 1500 * MS) == pytest.approx(0.5)


def test_simulated_time_has_one_clock_and_a_message_is_new_when_it_arrives(intake):
    take(intake, stamp=NOW - 40 * MS, simulated=True)
    assert age(intake, STEADY) == 0.0


def test_after_a_jump_of_time_older_stamps_count(intake):
    take(intake)
    intake.forget()
    assert age(intake, STEADY) == -1.0
    assert take(intake, stamp=NOW - 90 * MS) == ""


def test_after_a_freeze_the_first_message_without_stamp_may_be_old(intake):
    intake.struct.thawed = 1  # as the filter's core sets it
    assert take(intake, stamp=0) == "queued while this process stood still"
    assert take(intake, stamp=0) == ""
    intake.struct.thawed = 1
    assert take(intake) == ""


def test_rotations():
    assert is_rotation(0, 0, math.sin(0.3), math.cos(0.3))
    assert not is_rotation(0, 0, 0, 0)
    assert not is_rotation(math.nan, 0, 0, 1)
