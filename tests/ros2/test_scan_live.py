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
    "scan": ("odometry=none", 'scans=["scan"]', "radius=0.25", "limit_timeout=1.0"),
    "free": ("odometry=none",),
}
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
def test_a_scan_that_is_stamped_too_late_is_none(report, node):
    found = report(f"scan live, {node}")["late"]

    assert found["after"] > 0.5
    assert int(found["details"]["scans too old"]) > 0


def test_a_wall_that_is_near_is_a_stop_that_says_how_to_leave(seen):
    found = seen["near"]

    assert found["after"] < 0.5
    assert any("near: back off, hold it for 0." in text for text in found["said"])
    assert seen["back"]


@pytest.mark.parametrize("node", ["Python", "C"])
def test_a_laser_that_is_blind_ahead_is_a_stop(report, node):
    found = report(f"scan live, {node}")["blind"]

    assert found["after"] < 0.5
    assert int(found["details"]["scan blind beams"]) > 60
    assert found["details"]["scan nearest beam"].startswith("10.000 m at ")


def test_limits_that_fall_and_rise(seen):
    assert seen["lower"]
    assert seen["both"]
    assert seen["higher"]
    assert seen["below the push"]
    assert seen["disabled"]


@pytest.mark.parametrize("node", ["Python", "C"])
@pytest.mark.parametrize("way", ["none", "negative", "infinite"])
def test_no_way_ahead_is_a_stop(report, node, way):
    assert report(f"free live, {node}")[way]["after"] < 0.5


@pytest.mark.parametrize("node", ["Python", "C"])
def test_a_way_without_end_limits_nothing_and_one_that_is_no_number_is_not_told(report, node):
    found = report(f"free live, {node}")

    assert found["open"] is None
    assert 0.5 < found["no number"]["after"] < 8


@pytest.mark.parametrize("node", ["Python", "C"])
def test_turning_on_the_spot_before_a_wall_is_refused(report, node):
    found = report(f"free live, {node}")

    assert found["turned"] == 0
    assert any("near" in text for text in found["turning"]["said"])


@pytest.mark.parametrize("node", ["Python", "C"])
def test_a_process_that_stood_still_sends_no_more_and_drives_again(report, node):
    found = report(f"scan live, {node}")["frozen"]

    assert found["largest"] <= 0.5
    assert found["again"]


def test_limits_that_must_go_on(report):
    found = report("scan live, Python")

    assert found["enabled"]
    assert 0.8 < found["silent"]["after"] < 3
    assert any("limit-refused" in text for text in found["silent"]["said"])
    assert found["again"]


def test_limits_of_nav2_clamp(report):
    found = report("scan live, Python")

    assert found["speed"]
    assert found["percent"]
    assert found["none"]


def test_it_ends_with_a_last_zero(seen):
    assert seen["interrupt"] == [[0.0, 0.0], 0]
