"""The node over real DDS, in an environment of its own made from wheels; elsewhere NOT RUN."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.ros2.conftest import OVER_DDS, refusal_of, report_of

SLACK = 0.15
"""Time [s] that DDS and a busy machine may take, beside time-outs and ticks."""
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


@pytest.fixture(scope="module")
def seen(ros, environment, tmp_path_factory):
    return report_of("outside.py", SCENARIO, ros, environment, tmp_path_factory.mktemp("scenario"))


@pytest.fixture(scope="module")
def live(ros, environment, tmp_path_factory):
    return report_of("filter_live.py", SCENARIO, ros, environment, tmp_path_factory.mktemp("live"))


def test_a_sound_command_passes(seen):
    assert seen["sound"]["largest"] == pytest.approx([0.5, 0.3])
    assert seen["sound"]["falls"] is None


@pytest.mark.parametrize("fault", ["missing", "NaN", "old", "ahead", "in map"])
def test_without_a_command_that_counts_the_base_comes_to_rest(seen, fault):
    found = seen[f"command {fault}"]

    assert found["falls"] <= 0.25 + 2 * TICK + SLACK
    assert found["zero"] <= 0.25 + 0.25 + 2 * TICK + SLACK  # 0.5 m/s at 2 m/s2
    assert "no-command" in found["said"]
    assert found["messages"] > 20  # zeros go on: silence is death


@pytest.mark.parametrize("fault", ["missing", "NaN", "no rotation", "of a laser", "old"])
def test_without_odometry_that_counts_the_base_comes_to_rest(seen, fault):
    found = seen[f"odometry {fault}"]

    assert found["falls"] <= 0.1 + 2 * TICK + SLACK
    assert found["zero"] <= 0.1 + 0.25 + 2 * TICK + SLACK
    assert "no-odometry" in found["said"]


def test_a_wild_command_is_brought_inside_and_keeps_its_curvature(seen):
    found = seen["command wild"]

    assert found["largest"][0] == pytest.approx(0.95 / 1.1, rel=1e-6)
    assert found["curvature"] == pytest.approx([0.6])


def test_a_base_that_is_too_fast_is_stopped_until_a_reset(seen):
    assert seen["base too fast"]["falls"] <= 2 * TICK + SLACK
    assert "stopped, too-fast" in seen["base too fast"]["said"]
    assert seen["latched"]["stays"]
    assert seen["latched"]["reset"]


def test_a_stop_is_zero_at_once(seen):
    assert seen["stop"]["zero"] <= 2 * TICK + SLACK
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
        (["scenario:={}", "command_timeout:=-1.0"], "must be positive"),
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
