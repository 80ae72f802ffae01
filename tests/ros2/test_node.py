"""The node over real DDS, in an environment of its own made from wheels; elsewhere NOT RUN."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.ros2.conftest import OVER_DDS, SLACK, bar, built_node, refusal_of, report_of
from wmr_ctrl.scenario import load_scenario

TICK = 0.02
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


@pytest.fixture(scope="module", params=["Python", "C"])
def node(request, ros, tmp_path_factory):
    """Words that start the filter: none for the node in Python, or the program of that in C."""

    def words(odometry):
        if request.param == "Python":
            return ()
        folder = tmp_path_factory.mktemp("node")
        path = folder / "base.toml"
        path.write_text(SCENARIO, encoding="utf-8")
        settings = [f"odometry={odometry}"]
        return (str(built_node(load_scenario(path), settings, ros, folder / "c")),)

    return words


@pytest.fixture(scope="module")
def seen(ros, environment, tmp_path_factory, node):
    folder = tmp_path_factory.mktemp("scenario")
    return report_of("outside.py", SCENARIO, ros, environment, folder, *node("required"))


@pytest.fixture(scope="module")
def live(ros, environment, tmp_path_factory, node):
    folder = tmp_path_factory.mktemp("live")
    return report_of("filter_live.py", SCENARIO, ros, environment, folder, *node("none"))


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
    assert "no-command" in found["said"]
    assert found["messages"] > 20  # zeros go on: silence is death


@pytest.mark.parametrize(
    "fault", ["missing", "NaN", "no rotation", "of a laser", "old", "repeated"]
)
def test_without_odometry_that_counts_the_base_comes_to_rest(seen, fault):
    found = seen["odometry"][fault]

    assert found["falls"] <= bar(found, 0.1)
    assert found["zero"] <= bar(found, 0.1 + 0.25)
    assert "no-odometry" in found["said"]


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
    assert "stopped, too-fast" in found["said"]
    assert seen["latched"] == {"zero": True, "stays": True, "reset": True}


def test_a_stop_is_zero_at_once(seen):
    assert seen["stop"]["zero"] <= bar(seen["stop"], 0.0)
    assert not seen["stop"]["reset while it says so"]
    assert seen["stop"]["stays"]
    assert seen["stop"]["reset"]


def test_a_second_publisher_is_told(seen):
    assert any("other publishers" in text for text in seen["rival"]["said"])


def test_who_is_interrupted_sends_a_last_zero(seen):
    assert seen["interrupt"] == {"last": [0.0, 0.0], "code": 0}


def test_a_rival_is_found_on_the_remapped_topic(live):
    assert any(
        "/base/cmd_vel" in text and "/robot1/outside" in text for text in live["space"]["rival"]
    )


def test_two_senders_are_told(live):
    assert any("twist_mux" in text for text in live["space"]["two senders"])


def test_the_share_of_commands_has_a_range(live):
    if "scaled" not in live["space"]:
        pytest.skip("the node in C has no parameters")
    assert live["space"]["scale 7"] is False
    assert live["space"]["scale .25"] is True
    assert live["space"]["scaled"] == pytest.approx(0.125)


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
    stopped = live["simulated"]["stopped"]
    assert falls_to_rest(stopped)
    assert stopped.count(0.5) <= (0.25 + SLACK) / TICK + 2


@pytest.mark.parametrize("jump", ["back", "ahead"])
def test_simulated_time_that_jumps_does_not_stop_a_sender_that_goes_on(live, jump):
    assert live["simulated"][jump][-1] == pytest.approx(0.5)


def test_on_simulated_time_too_a_last_zero_is_sent(live):
    assert live["simulated"]["interrupt"] == [0.0, 0]


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ([], "the parameter scenario is not set"),
        (["scenario:=paper-simulation"], "no command filter"),
        (["scenario:=none.toml"], "none.toml"),
        (["scenario:={}", "odometry:=maybe"], "must be one of none, watched, required"),
        (["scenario:={}", "command_timeout:=-1.0"], "command_timeout is out of its range"),
        (["scenario:={}", "command_timeout:=1"], "Numbers need a point"),
        (["scenario:={}", "rise:=[1.0]"], "must have two"),
        (["scenario:={}", "fall:=[0.0, 1.0]"], "must be positive"),
        (["scenario:={}", "trigger:=never"], "must be one of timer, command"),
    ],
)
def test_what_cannot_be_configured_is_a_sentence(ros, environment, tmp_path, settings, said):
    assert said in refusal_of("filter", settings, SCENARIO, ros, environment, tmp_path)


def test_without_ros_a_sentence_says_so():
    done = subprocess.run(
        [sys.executable, "-m", "wmr_ctrl.ros2", "filter"],
        capture_output=True,
        text=True,
        check=False,
    )

    assert done.returncode == 2
    assert "ROS 2 is not here" in done.stderr


@pytest.mark.parametrize(
    ("kind", "topic", "reliable", "said"),
    [
        ("Twist", "cmd_vel_in", True, "stamped:=true or false"),
        ("TwistStamped", "cmd_vel", True, "other publishers"),
        ("Bool", "wmr_filter/stop", False, "another QoS"),
    ],
)
def test_who_makes_it_useless_is_a_sentence_at_configure(
    ros, environment, tmp_path, kind, topic, reliable, said
):
    """Commands of another type, a second publisher, and a stop that would not be heard."""
    script = OTHER.format(kind=kind, topic=topic, reliable=reliable)
    with subprocess.Popen([ros, "-c", script], env=environment, stdout=subprocess.PIPE) as other:
        try:
            assert other.stdout.readline() == b"there\n"
            given = "filter", ["scenario:={}"], SCENARIO, ros, environment, tmp_path
            assert said in refusal_of(*given, attempts=5)
        finally:
            other.kill()


OTHER = """
import time, rclpy
from geometry_msgs.msg import Twist, TwistStamped
from std_msgs.msg import Bool
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy as R
rclpy.init()
node = rclpy.create_node("other")
qos = QoSProfile(depth=1, reliability=R.RELIABLE if {reliable} else R.BEST_EFFORT)
publisher = node.create_publisher({kind}, "{topic}", qos)
print("there", flush=True)
time.sleep(60)
"""


def test_another_vendor_commands_and_reads_it(ros, environment, tmp_path, node):
    """Cyclone DDS without ROS at both ends: a command passes, and its absence ends in rest."""
    found = report_of("second_vendor.py", SCENARIO, ros, environment, tmp_path, *node("none"))

    assert found == {"driving": [0.5, 0.25], "after": [0.0, 0.0]}
