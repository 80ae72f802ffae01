"""Commands without stamps, odometry that is watched or used, with the filter in Python and in C."""

import pytest

from tests.ros2.conftest import OVER_DDS, bar, in_both
from tests.ros2.test_node import SCENARIO

GOVERNED = (
    SCENARIO.replace('"clip"', '"governor"')
    + """
tau = [0.05, 0.1]
odometry = [0.02, 0.02]
jitter = 0.015
age = 0.05
"""
)
pytestmark = [pytest.mark.slow, OVER_DDS]


KINDS = {
    "twist": (SCENARIO, ("stamped=false", "odometry=none")),
    "governor": (GOVERNED, ("odometry=watched",)),
}
"""Scenario and settings; the node in C has its settings compiled in."""


def JOBS():
    jobs = {}
    for kind, (scenario, settings) in KINDS.items():
        both = in_both("filter_kinds.py", scenario, (kind,), settings)
        jobs |= {f"{kind}, {node}": job for node, job in both.items()}
    return jobs


@pytest.mark.parametrize("node", ["Python", "C"])
def test_commands_without_stamps_pass_and_end_with_their_sender(report, node):
    """If a controller dies before the filter, commands are reported missing."""
    found = report(f"twist, {node}")

    assert found["drives"]
    assert found["driven"] == [0.5, pytest.approx(0.3)]
    assert found["rests"]
    assert found["zero"] <= bar(found, 0.25 + 0.25)


@pytest.mark.parametrize("node", ["Python", "C"])
def test_odometry_that_is_watched_may_be_missing_and_the_governor_says_so(report, node):
    """It drives in either case."""
    found = report(f"governor, {node}")

    # A busy machine's odometry is too old at times.
    assert any("unused" not in flags for flags in found["with"])
    assert all({"unused", "no-odometry"} <= set(flags) for flags in found["without"])
    assert found["without"]
    assert found["drives"]
