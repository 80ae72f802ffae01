"""Intake of messages: accepted and refused ones."""

import math

import pytest

from tests.ros2.worlds import MS
from tests.tables import cases
from wmr_ctrl.ros2.clocks import Moment
from wmr_ctrl.ros2.intake import Intake, is_rotation

NOW, STEADY = 1_000_000 * MS, 5_000 * MS


@pytest.fixture
def intake():
    return Intake(timeout=100 * MS, value=(0.0, 0.0), frame="base_link")


def take(intake, *, value=(0.3, 0.1), stamp=NOW, frame="base_link", simulated=False, steady=STEADY):
    return intake.take(value, stamp, frame, Moment(NOW, steady, simulated))


def age(intake, steady):
    return intake.age(Moment(NOW, steady))


@pytest.mark.parametrize(
    "v, later, frame, clock, reason",
    cases("""
        nan | 10 | base_link | real | not a number
        -inf | 10 | base_link | real | not a number
        0.3 | 10 | map | real | wrong frame
        0.3 | 60 | base_link | real | from the future
        0.3 | 60 | base_link | simulated | -
        0.3 | 110 | base_link | simulated | from the future
        0.3 | -110 | base_link | real | too old
        0.3 | -10 | base_link | real | repeated or out of order
        0.3 | 0 | base_link | real | repeated or out of order
        0.3 | 0.000001 | base_link | real | -
        0.3 | none | base_link | real | -
        0.3 | 10 | - | real | -
    """),
)
def test_a_second_message_counts_or_is_told_why_not(intake, v, later, frame, clock, reason):
    """The second message has a stamp later by this time [ms], or none."""
    stamp = 0 if later == "none" else NOW + round(float(later) * MS)
    given = {"value": (0.1, float(v)), "stamp": stamp, "frame": frame.strip("-")}
    reason = reason.strip("-")
    assert take(intake) == ""
    assert take(intake, **given, simulated=clock == "simulated") == reason
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
