"""An exception in a callback leads to a zero and a line of the log, never to a dead node."""

import pytest

from tests.ros2.conftest import OVER_DDS, Job
from tests.ros2.test_drive_node import CIRCLE

pytestmark = [pytest.mark.slow, OVER_DDS]


NAMES = ("drive", "filter")


def JOBS():
    return {f"broken inside, {name}": Job("broken_inside.py", CIRCLE, (name,)) for name in NAMES}


@pytest.mark.parametrize("name", NAMES)
def test_an_exception_is_a_zero_and_a_line_of_the_log(report, name):
    seen = dict(report(f"broken inside, {name}"))

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
