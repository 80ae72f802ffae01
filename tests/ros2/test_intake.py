"""Which messages count."""

from __future__ import annotations

import math

import pytest

from wmr_ctrl.ros2.intake import Intake, is_rotation

NOW, STEADY = 1000.0, 5.0


@pytest.fixture
def intake():
    return Intake(timeout=0.1, frame="base_link")


def take(intake, *, value=(0.3, 0.1), stamp=NOW, frame="base_link", now=NOW, steady=STEADY):
    return intake.take(value, stamp, frame, now, steady)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"value": (math.nan, 0.0)}, "not a number"),
        ({"value": (0.0, -math.inf)}, "not a number"),
        ({"frame": "map"}, "wrong frame"),
        ({"stamp": NOW + 0.06}, "from the future"),
        ({"stamp": NOW - 0.11}, "too old"),
        ({"stamp": NOW - 0.01}, "repeated or out of order"),
        ({}, "repeated or out of order"),
        ({"stamp": NOW + 0.02}, ""),
        ({"stamp": 0.0}, ""),
        ({"stamp": NOW + 0.01, "frame": ""}, ""),
    ],
)
def test_a_second_message_counts_or_is_told_why_not(intake, changes, reason):
    assert take(intake) == ""
    assert take(intake, **changes) == reason
    assert intake.refused == ({reason: 1} if reason else {})
    assert intake.taken == (1 if reason else 2)


def test_age_is_that_of_what_the_message_tells(intake):
    assert intake.age(STEADY) == -1.0
    take(intake, stamp=NOW - 0.04)
    assert intake.age(STEADY + 0.02) == pytest.approx(0.06)
    take(intake, stamp=0.0, steady=STEADY + 1)
    assert intake.age(STEADY + 1.5) == pytest.approx(0.5)


def test_after_a_jump_of_time_older_stamps_count(intake):
    take(intake)
    intake.forget()
    assert intake.age(STEADY) == -1.0
    assert take(intake, stamp=3.0, now=3.0) == ""


def test_rotations():
    assert is_rotation(0, 0, math.sin(0.3), math.cos(0.3))
    assert not is_rotation(0, 0, 0, 0)
    assert not is_rotation(math.nan, 0, 0, 1)
