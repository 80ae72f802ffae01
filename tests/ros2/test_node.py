"""The node over real DDS, in an environment of its own made from wheels; elsewhere NOT RUN."""

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
        ("faults", "outside.py", ("odometry=required",)),
        ("life", "filter_live.py", ("odometry=none",)),
    ):
        both = in_both(script, SCENARIO, (), settings)
        jobs |= {f"{name}, {node}": job for node, job in both.items()}
    vendor = in_both("second_vendor.py", SCENARIO, (), ("odometry=none",))
    jobs["second vendor"] = vendor["C"]
    jobs["interrupted"] = Job("interrupted.py", SCENARIO)
    jobs["reconfigured"] = Job("reconfigured.py", SCENARIO)
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
    return found["falls"] is None and found["largest"] == pytest.approx([0.5, 0.3])


def test_a_sound_command_passes(seen):
    assert drives_on(seen["sound"])


@pytest.mark.parametrize(
    "fault", ["missing", "NaN", "infinite", "old", "ahead", "repeated", "in map"]
)
def test_without_a_command_that_counts_the_base_comes_to_rest(seen, fault):
    found = seen["command"][fault]

    assert found["falls"] <= bar(found, 0.25)
    assert found["zero"] <= bar(found, 0.25 + 0.25)  # 0.5 m/s at 2 m/s2
    assert any("no-command" in text for text in found["said"])
    assert found["zeros"] > 5  # they go on: silence is death


@pytest.mark.parametrize(
    "fault", ["missing", "NaN", "no rotation", "of a laser", "old", "repeated"]
)
def test_without_odometry_that_counts_the_base_comes_to_rest(seen, fault):
    found = seen["odometry"][fault]

    assert found["falls"] <= bar(found, 0.1)
    assert found["zero"] <= bar(found, 0.1 + 0.25)
    assert any("no-odometry" in text for text in found["said"])


def test_a_refusal_names_the_frame_that_came_and_the_one_that_is_wanted(report):
    said = report("faults, Python")["odometry"]["of a laser"]["said"]

    assert any("it is 'laser', wanted is 'base_link'" in text for text in said), said


def test_parameters_change_between_cleanup_and_configure_alone(report):
    found = report("reconfigured")

    assert found["changed while active"] is False
    assert found["changed after cleanup"] is True
    assert found["first"] > 0.8
    assert 0 < found["second"] <= 0.45
    assert found["other parts"] == ["other-parts"]


@pytest.mark.parametrize("what", ["command", "odometry"])
def test_messages_out_of_order_are_ignored_and_the_base_drives_on(seen, what):
    assert drives_on(seen[what]["out of order"])


def test_a_sender_at_best_effort_is_heard(seen):
    assert drives_on(seen["command"]["best effort"])


def test_a_wild_command_is_brought_inside_and_keeps_its_curvature(seen):
    found = seen["command"]["wild"]

    assert found["largest"][0] == pytest.approx(0.95 / 1.1, rel=1e-6)
    assert found["curvature"] == pytest.approx([0.6])


def test_a_base_that_is_too_fast_is_stopped_until_a_reset(seen):
    found = seen["odometry"]["too fast"]

    assert found["falls"] <= bar(found, 0.0)
    assert any("stopped, too-fast" in text for text in found["said"])
    assert seen["latched"] == {"zero": True, "stays": True, "reset": True}


def test_a_stop_is_zero_at_once(seen):
    assert seen["stop"]["zero"] <= bar(seen["stop"], 0.0)
    assert not seen["stop"]["reset while it says so"]
    assert seen["stop"]["stays"]
    assert seen["stop"]["reset"]


def test_a_second_publisher_is_told(seen):
    assert any("other publishers" in text for text in seen["rival"])
    late = bar({"silence": seen["rival silence"]}, 2.0)  # looked for each second; one may miss it
    assert seen["rival after"] < late


def test_who_is_interrupted_sends_a_last_zero(seen):
    assert seen["interrupt"] == [[0.0, 0.0], 0]


def test_an_interrupt_at_a_bad_moment_ends_it_with_a_last_zero(report):
    """In a destructor, which drops it; twice; in what takes long; in a transition; at the end."""
    found = {name: item for name, item in report("interrupted").items() if "Broken" not in name}

    assert found.pop("AtConfigure") == [0, 0]  # nothing was sent, nor looked around to the end
    assert len(found) == 5
    assert set(map(str, found.values())) == {"[0, [0.0, 0.0], 3]"}, found


def test_a_rival_is_found_on_the_remapped_topic(live):
    assert any(
        "/base/cmd_vel" in text and "/robot1/outside" in text for text in live["space"]["rival"]
    )


@pytest.mark.parametrize("step", ["Configure", "Activate"])
def test_an_exception_in_a_transition_is_told_and_ends_it(report, step):
    """Of which rclpy says nothing."""
    code, sent, told = report("interrupted")[f"BrokenAt{step}"]

    assert (code, sent) == (2, 0)
    assert f"on_{step.lower()}: RuntimeError('broken')" in told


def test_where_all_is_well_diagnostics_say_so(live):
    """The base reads it, reliably, and nobody else is there."""
    assert "driving" in live["space"]["well"]


def test_a_reader_to_whom_nothing_comes_is_told(live):
    assert any("another QoS" in text and "reaches it" in text for text in live["space"]["deaf"])


def test_two_senders_are_told(live):
    assert any("twist_mux" in text for text in live["space"]["two senders"])


def test_the_share_of_commands_has_a_range(live):
    if "scaled" not in live["space"]:
        pytest.skip("the node in C has no parameters")
    assert live["space"]["scale 7"] is False
    assert live["space"]["scale 0.25"] is True
    assert live["space"]["scaled"] == 0.125


def falls_to_rest(speeds, before=0.5):
    """By the ramp of 2 m/s2 at 50 Hz, some ticks early or late."""
    steps = [a - b for a, b in zip([before, *speeds], speeds, strict=False)]
    return all(0 <= step <= 2 * TICK * 1.01 for step in steps) and speeds[-1] == 0


def test_a_frozen_process_is_silent_and_then_comes_to_rest_by_the_ramp(live):
    assert live["space"]["while frozen"] == 0
    assert falls_to_rest(live["space"]["thawed"])


def test_a_killed_process_is_silent_and_begins_with_zeros(live):
    assert live["space"]["after the kill"] == 0
    assert live["space"]["next life"] == 0.0


def test_simulated_time_that_stops_ends_in_rest(live):
    found = live["simulated"]["stopped"]
    assert falls_to_rest(found["speeds"])
    assert found["speeds"].count(0.5) <= bar(found, 0.25) / TICK


@pytest.mark.parametrize("jump", ["back", "ahead"])
def test_simulated_time_that_jumps_does_not_stop_a_sender_that_goes_on(live, jump):
    assert live["simulated"][jump]


def test_on_simulated_time_too_a_last_zero_is_sent(live):
    assert live["simulated"]["interrupt"] == [[0.0, 0.0], 0]


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
    """Commands or odometry of another type, a second publisher, and a stop that is not heard."""
    code, cried = report(f"useless, {node}")[other]

    assert code == 2
    assert said in cried
    assert "Traceback" not in cried


def test_another_vendor_commands_and_reads_it(report):
    """Cyclone DDS without ROS at both ends: a command passes, and its absence ends in rest."""
    assert report("second vendor") == {"driving": [0.5, 0.25], "after": [0.0, 0.0]}
