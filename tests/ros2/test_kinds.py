"""Commands without stamps, odometry that is watched or used, with the filter in Python and in C."""

from __future__ import annotations

import pytest

from tests.ros2.conftest import OVER_DDS, bar, built_node, report_of
from tests.ros2.test_node import SCENARIO
from wmr_ctrl.scenario import load_scenario

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


@pytest.fixture(params=["Python", "C"])
def kind(request, ros, environment, tmp_path):
    """What a script reports of a kind, whose settings the node in C has compiled in."""

    def report(name, scenario, settings):
        node = []
        if request.param == "C":
            path = tmp_path / "mine.toml"
            path.write_text(scenario, encoding="utf-8")
            node = [str(built_node(load_scenario(path), settings, ros, tmp_path / "c"))]
        return report_of("filter_kinds.py", scenario, ros, environment, tmp_path, name, *node)

    return report


def test_commands_without_stamps_pass_and_end_with_their_sender(kind):
    """A controller that dies before the filter is a command that is missing."""
    found = kind("twist", SCENARIO, ["stamped=false", "odometry=none"])

    assert found["drives"]
    assert found["driven"] == [0.5, pytest.approx(0.3)]
    assert found["rests"]
    assert found["zero"] <= bar(found, 0.25 + 0.25)


def test_odometry_that_is_watched_may_be_missing(kind):
    found = kind("watched", SCENARIO, ["odometry=watched"])

    assert found["falls"] is None
    assert "no-odometry" in found["said"]


def test_the_governor_uses_odometry_and_says_when_it_has_none(kind):
    found = kind("governor", GOVERNED, ["odometry=watched"])

    # A busy machine's odometry is too old at times.
    assert any("unused" not in flags for flags in found["with"])
    assert all({"unused", "no-odometry"} <= set(flags) for flags in found["without"])
