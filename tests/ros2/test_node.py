"""The node over real DDS, in a separate environment made from wheels; elsewhere NOT RUN."""

import subprocess
import sys

import pytest

from tests.ros2.conftest import OVER_DDS, TICK, Job, bar, in_both

SCENARIO = """
extends = "paper-simulation"
[limits]
v_u1 = [1.0, 2.0]
v_u2 = [0.7, 1.4]
[clock]
control = 0.02
[filter]
kind = "clip"
gain = [0.9, 1.1]
d = [0.05, 0.05]
"""
pytestmark = [pytest.mark.slow, OVER_DDS]


def JOBS():
    jobs = {}
    for name, script, settings in (
        ("faults", "filter_faults.py", ("odometry=required",)),
        ("life", "filter_live.py", ("odometry=none",)),
    ):
        both = in_both(script, SCENARIO, (), settings)
        jobs |= {f"{name}, {node}": job for node, job in both.items()}
    jobs["interrupted"] = Job("interrupted.py", SCENARIO)
    jobs["useless, Python"] = Job("useless.py", SCENARIO)
    jobs["useless, C"] = Job("useless.py", SCENARIO, (), ("discovery_time=60.0",))
    return jobs


@pytest.fixture(params=["Python", "C"])
def node(request):
    return request.param


@pytest.fixture
def seen(report, node):
    return report(f"faults, {node}")


@pytest.fixture
def live(report, node):
    return report(f"life, {node}")


def drives_on(found):
    return found["falls"] is None and found["last"] == pytest.approx([0.5, 0.3])


def test_a_sound_command_passes_also_at_best_effort_and_what_is_out_of_order_is_ignored(seen):
    assert drives_on(seen["sound"])
    assert drives_on(seen["command"]["best effort"])
    assert drives_on(seen["command"]["out of order"])
    assert drives_on(seen["odometry"]["out of order"])
    assert seen["odometry"]["out of order"]["refused"] > 5


COMES_TO_REST = [
    *(("command", name, 0.25)
      for name in ("missing", "NaN", "infinite", "old", "ahead", "repeated", "in map")),
    *(("odometry", name, 0.1)
      for name in ("missing", "NaN", "no rotation", "of a laser", "old", "repeated")),
]  # fmt: skip
"""Faults of commands and odometry, and their time-outs [s]."""


@pytest.mark.parametrize("what, fault, timeout", COMES_TO_REST)
def test_without_what_counts_the_base_comes_to_rest(seen, what, fault, timeout):
    found = seen[what][fault]

    assert found["there"]  # zeros go on, for silence is death, and the reason was told
    assert found["falls"] <= bar(found, timeout)
    assert found["zero"] <= bar(found, timeout + 0.25)  # 0.5 m/s at 2 m/s2


def test_a_refusal_names_the_frame_that_came_and_the_one_that_is_wanted(report):
    said = report("faults, Python")["odometry"]["of a laser"]["said"]

    assert any("it is 'laser', wanted is 'base_link'" in text for text in said), said


def test_a_wild_command_is_brought_inside_and_keeps_its_curvature(seen):
    v, omega = seen["command"]["wild"]["last"]

    assert v == pytest.approx(0.95 / 1.1, rel=1e-6)
    assert omega / v == pytest.approx(0.6)


def test_a_base_that_is_too_fast_and_a_stop_are_zero_at_once_until_a_reset(seen):
    assert seen["too fast"]["falls"] <= bar(seen["too fast"], 0.0)
    assert any("stopped, too-fast" in text for text in seen["too fast"]["said"])
    assert seen["latched"] == [[0.0, 0.0], True]
    assert seen["stop"]["zero"] <= bar(seen["stop"], 0.0)
    assert not seen["reset while stopped"]
    assert seen["stopped"] == [[0.0, 0.0], True]
    assert seen["drives again"]


@pytest.mark.parametrize("way", ["", "simulated"])
def test_who_is_interrupted_sends_a_last_zero(seen, live, way):
    assert (live[way] if way else seen)["interrupt"] == [[0.0, 0.0], 0]


def test_an_interrupt_at_a_bad_moment_ends_it_with_a_last_zero(report):
    """Moments: in a destructor, which drops it; twice; in a long call; in a transition; at the
    end.
    """
    found = {name: item for name, item in report("interrupted").items() if "Broken" not in name}

    assert found.pop("AtConfigure") == [0, 0]  # nothing was sent, nor looked around to the end
    assert len(found) == 5
    assert set(map(str, found.values())) == {"[0, [0.0, 0.0], 3]"}, found


def test_diagnostics_say_who_else_is_there_and_where_all_is_well(live):
    """A rival is found on the remapped topic."""
    found = live["space"]

    assert any("/base/cmd_vel" in text and "/robot1/outside" in text for text in found["rival"])
    assert found["rival after"] < bar(found, 2.0)  # looked for each second; one may miss it
    assert "driving" in found["well"]
    assert any("another QoS" in text and "reaches it" in text for text in found["deaf"])
    assert any("twist_mux" in text for text in found["two senders"])
    assert any("other-parts" in text for text in found["other parts"])


@pytest.mark.parametrize("step", ["Configure", "Activate"])
def test_an_exception_in_a_transition_is_told_and_ends_it(report, step):
    """The node reports the error, since rclpy says nothing."""
    code, sent, told = report("interrupted")[f"BrokenAt{step}"]

    assert (code, sent) == (2, 0)
    assert f"on_{step.lower()}: RuntimeError('broken')" in told


def test_the_share_of_commands_has_a_range(live):
    if "scaled" not in live["space"]:
        pytest.skip("the node in C has no parameters")
    assert live["space"]["scale 7"] is False
    assert live["space"]["scale 0.25"] is True
    assert live["space"]["scaled"] == 0.125


def test_configured_with_another_scenario_it_keeps_to_those_limits(report):
    assert report("life, Python")["space"]["slower"] == pytest.approx((0.5 - 0.05) / 1.1)


def falls_to_rest(speeds, before=0.5):
    """True if speeds [m/s] fall to 0 by the ramp of 2 m/s2 at 50 Hz, some ticks early or late."""
    steps = [a - b for a, b in zip([before, *speeds], speeds, strict=False)]
    return all(0 <= step <= 2 * TICK * 1.01 for step in steps) and speeds[-1] == 0


def test_a_frozen_process_is_silent_and_then_comes_to_rest_by_the_ramp(live):
    assert live["space"]["while frozen"] == 0
    assert falls_to_rest(live["space"]["thawed"])


def test_a_killed_process_is_silent_and_begins_with_zeros(live):
    assert live["space"]["after the kill"] == 0
    assert live["space"]["next life"] == 0.0


def test_simulated_time_that_stops_ends_in_rest_and_one_that_jumps_does_not(live):
    found = live["simulated"]
    assert falls_to_rest(found["stopped"]["speeds"])
    assert found["stopped"]["speeds"].count(0.5) <= bar(found["stopped"], 0.25) / TICK
    assert found["back"]
    assert found["ahead"]


def test_without_ros_a_sentence_says_so():
    done = subprocess.run(
        [sys.executable, "-m", "wmr_ctrl.ros2", "filter"],
        capture_output=True,
        text=True,
        check=False,
    )

    assert done.returncode == 2
    assert "ROS 2 was not found" in done.stderr


@pytest.mark.parametrize(
    "other, said",
    [
        ("type", "as geometry_msgs/msg/Twist, where this node has geometry_msgs/msg/TwistStamped"),
        ("rival", "other publishers on /rival/cmd_vel: "),
        ("stop", "another QoS"),
        ("odometry", "where this node has nav_msgs/msg/Odometry"),
    ],
)
def test_who_makes_it_useless_is_a_sentence_at_configure(report, node, other, said):
    """Commands or odometry of another type, a second publisher, and a stop that is not received."""
    code, cried = report(f"useless, {node}")[other]

    assert code == 2
    assert said in cried
    assert "Traceback" not in cried
