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
    "twist": (SCENARIO, ("stamped=false", "odometry=none"), ("Python", "C")),
    "watched": (SCENARIO, ("odometry=watched",), ("Python",)),
    "governor": (GOVERNED, ("odometry=watched",), ("C",)),
}
"""Scenario, settings, and nodes that are tried; the node in C has its settings compiled in."""


def JOBS():
    jobs = {}
    for kind, (scenario, settings, nodes) in KINDS.items():
        both = in_both("filter_kinds.py", scenario, (kind,), settings)
        jobs |= {f"{kind}, {node}": both[node] for node in nodes}
    return jobs


@pytest.mark.parametrize("node", ["Python", "C"])
def test_commands_without_stamps_pass_and_end_with_their_sender(report, node):
    """A controller that dies before the filter is a command that is missing."""
    found = report(f"twist, {node}")

    assert found["drives"]
    assert found["driven"] == [0.5, pytest.approx(0.3)]
    assert found["rests"]
    assert found["zero"] <= bar(found, 0.25 + 0.25)


def test_odometry_that_is_watched_may_be_missing(report):
    found = report("watched, Python")

    assert found["falls"] is None
    assert any("no-odometry" in text for text in found["said"])


def test_the_governor_uses_odometry_and_says_when_it_has_none(report):
    found = report("governor, C")

    # A busy machine's odometry is too old at times.
    assert any("unused" not in flags for flags in found["with"])
    assert all({"unused", "no-odometry"} <= set(flags) for flags in found["without"])
