"""A laser and limits that fail, over DDS, with the filter in Python and in C."""

import pytest

from tests.ros2.conftest import OVER_DDS, in_both

SCENARIO = """
extends = "paper-simulation"
[base]
kind = "velocity"
[limits]
v_u1 = [1.0, 0.2]
v_u2 = [0.7, 0.15]
[clock]
control = 0.05
[filter]
kind = "governor"
tau = [0.05, 0.1]
gain = [0.95, 1.05]
d = [0.03, 0.02]
jitter = 0.025
changing = true
free_error = 0.02
free_age = 0.25
rest = 0.4
"""
COMPILED = {
    "scan": (
        "odometry=none", 'scans=["scan"]', "radius=0.25", "limit_timeout=1.0",
        "scan_pose=[0.0, 0.0, 3.14159265]",
    ),
    "free": ("odometry=none",),
}  # fmt: skip
pytestmark = [pytest.mark.slow, OVER_DDS]


def JOBS():
    jobs = {}
    for kind, settings in COMPILED.items():
        both = in_both("scan_live.py", SCENARIO, (kind,), settings)
        jobs |= {f"{kind} live, {node}": job for node, job in both.items()}
    return jobs


@pytest.fixture(params=["Python", "C"])
def node(request):
    return request.param


@pytest.fixture(params=["scan", "free"])
def kind(request):
    return request.param


@pytest.fixture
def seen(report, kind, node):
    return report(f"{kind} live, {node}")


def test_without_a_distance_the_base_stands_before_what_was_told(seen):
    found = seen["stops"]

    assert 0.5 < found["after"] < 8  # 1.25 m at 0.5 m/s, or slower where a step is late
    assert any("no-distance" in text for text in found["said"])


@pytest.mark.parametrize("node", ["Python", "C"])
def test_a_scan_that_is_late_is_none_and_a_laser_that_is_blind_ahead_is_a_stop(report, node):
    late, blind = (report(f"scan live, {node}")[name] for name in ("late", "blind"))

    assert late["after"] > 0.5
    assert int(late["details"]["scans too old"]) > 0
    assert blind["after"] < 0.5
    assert int(blind["details"]["scan blind beams"]) > 60
    assert blind["details"]["scan nearest beam"].startswith("10.000 m at ")


def test_a_wall_that_is_near_is_a_stop_that_says_how_to_leave(seen):
    found = seen["near"]

    assert found["after"] < 0.5
    assert any("near: back off, hold it for 0." in text for text in found["said"])
    assert seen["back"]


def test_limits_that_fall_and_rise(seen):
    assert all(seen[name] for name in ("lower", "both", "higher", "below the push", "disabled"))


@pytest.mark.parametrize("node", ["Python", "C"])
def test_no_way_ahead_is_a_stop_one_without_end_limits_nothing_and_no_number_is_not_told(
    report, node
):
    found = report(f"free live, {node}")

    assert all(found[way]["after"] < 0.5 for way in ("none", "negative", "infinite"))
    assert found["open"] is None
    assert 0.5 < found["no number"]["after"] < 8
    assert found["turned"] == 0  # on the spot before a wall
    assert any("near" in text for text in found["turning"]["said"])


@pytest.mark.parametrize("node", ["Python", "C"])
def test_a_process_that_stood_still_sends_no_more_and_drives_again(report, node):
    found = report(f"scan live, {node}")["frozen"]

    assert found["largest"] <= 0.5
    assert found["again"]


def test_limits_that_must_go_on_and_those_of_nav2_clamp(report):
    found = report("scan live, Python")

    assert all(found[name] for name in ("enabled", "again", "speed", "percent", "none"))
    assert 0.8 < found["silent"]["after"] < 3
    assert any("limit-refused" in text for text in found["silent"]["said"])
