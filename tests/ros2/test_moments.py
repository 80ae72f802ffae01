"""Thresholds for jumps of the clocks between two moments, and of the pose between two messages."""

import math
import re

import pytest

from tests.papers_robot import preset
from tests.ros2.test_drive_core import CIRCLE, core_of
from tests.ros2.worlds import MS
from tests.tables import cases
from wmr_ctrl.control.filter.gate import GateSettings
from wmr_ctrl.ros2.clocks import Clocks, Moment, longest_pause
from wmr_ctrl.ros2.filter_core import core_files


@pytest.mark.parametrize(
    "ros, steady, happened",
    cases("""
        20 | 20 | -
        -9 | 20 | -
        -11 | 20 | time-back
        520 | 20 | -
        521 | 20 | time-forth
        100 | 100 | -
        101 | 101 | frozen
        700 | 101 | time-forth frozen
    """),
)
def test_time_goes_back_by_10_ms_leaps_by_500_and_stands_still_for_the_longest_pause(
    ros, steady, happened
):
    clocks = Clocks(100 * MS)
    clocks.see(Moment(10_000 * MS, 5_000 * MS))
    now = Moment((10_000 + int(ros)) * MS, (5_000 + int(steady)) * MS)

    assert clocks.see(now) == tuple(happened.strip("-").split())


@pytest.mark.parametrize("period, pause", [(0.02, 100), (0.04, 100), (0.1, 250)])
def test_a_pause_of_two_and_a_half_periods_is_no_freeze(period, pause):
    assert longest_pause(0.1, period) == pause * MS


def test_times_of_a_filter_are_its_own_settings():
    clip = "filter.kind = 'clip'; filter.gain = [0.9, 1.1]; filter.d = [0.05, 0.05]"
    scenario = preset("paper-simulation", clip, "clock.control = 0.02")
    settings = GateSettings(command_timeout=0.3, odometry_timeout=0.2)
    text = "\n".join(core_files(scenario, settings).values())
    times = dict(re.findall(r"#define WMR_([A-Z_]+) INT64_C\((\d+)\)", text))

    assert {name: int(time) / MS for name, time in times.items()} == {
        "PERIOD": 20, "COMMAND_TIMEOUT": 300, "ODOMETRY_TIMEOUT": 200, "LONGEST": 300,
    }  # fmt: skip


@pytest.fixture(scope="module")
def core():
    return core_of(CIRCLE, jump=(0.1, 0.2))


@pytest.mark.parametrize(
    "way, turn, leaps",
    [
        (0.139, 0.0, False),
        (0.141, 0.0, True),
        (-0.141, 0.0, True),
        (0.0, 0.259, False),
        (0.0, 0.261, True),
        (0.0, -0.261, True),
        (0.0, 2 * math.pi, False),
    ],
)
def test_a_pose_leaps_beyond_twice_the_larger_speed_and_the_slack(core, way, turn, leaps):
    """Twice the larger speeds (1 m/s, 1.5 rad/s) over 20 ms: 40 mm and 60 mrad, plus the slack."""
    before = (3.0, 4.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.2)
    after = (3.0 + 0.6 * way, 4.0 + 0.8 * way, 0.0, 0.0)
    after += (math.sin(turn / 2), math.cos(turn / 2), 0.4, -1.5)

    assert core._leaps(before, after, 0.02) is leaps
