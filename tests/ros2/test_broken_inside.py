"""An exception in a callback ends in a zero and a line of the log, never in a dead node."""

from __future__ import annotations

import pytest

from tests.ros2.conftest import OVER_DDS, report_of
from tests.ros2.test_drive_node import CIRCLE

pytestmark = [pytest.mark.slow, OVER_DDS]


@pytest.mark.parametrize("name", ["drive", "filter"])
def test_an_exception_is_a_zero_and_a_line_of_the_log(ros, environment, tmp_path, name):
    seen = report_of("broken_inside.py", CIRCLE, ros, environment, tmp_path, name)

    assert seen.pop("alive")
    for called, found in seen.items():
        assert found["told"], (called, found)  # in the log, and as an ERROR of the diagnostics
        assert "broken inside" in found["log"][0]
        assert found["drives on"], called
        if called != "send":
            assert found["zero"], called
    assert seen["halt"]["stays"]
    assert "nor could a zero be sent" in seen["send"]["log"][0]
    assert seen["send"]["sent"] == 0
    assert seen["reset"]["answer"] == [False, "it failed: see the log"]
