"""The drive node over real DDS, in a namespace and with remapped topics: the run's bits."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.ros2.conftest import OVER_DDS, bar, refusal_of, report_of
from tests.ros2.lockstep import BASES, CARRIED, COMMON, messages, sent_by
from wmr_ctrl import simulate
from wmr_ctrl.scenario import load_scenario, to_toml
from wmr_ctrl.world.registry import EFFECTS

SCRIPT = Path(__file__).with_name("drive_outside.py")
pytestmark = [pytest.mark.slow, OVER_DDS]


@pytest.mark.parametrize("base", ["velocity, governor", "efforts, guard"])
def test_every_command_on_the_wire_is_that_of_the_run(
    ros, environment, tmp_path, monkeypatch, base
):
    law, changes = BASES[base]
    (tmp_path / "base.toml").write_text(
        to_toml(load_scenario("paper-simulation", {**COMMON, **changes}), comments=False),
        encoding="utf-8",
    )
    monkeypatch.setitem(EFFECTS.__dict__, "plugins", (CARRIED,))
    carried = load_scenario("paper-simulation", {**COMMON, **changes, "message.sent": 1.0})
    run = simulate(carried, law)
    rows = [[*message, stamp] for message, stamp in messages(run, carried.clock.control)]
    (tmp_path / "rows.json").write_text(json.dumps(rows), encoding="utf-8")
    given = [tmp_path / "base.toml", law, tmp_path / "rows.json", base.partition(",")[0]]
    done = subprocess.run(
        [ros, SCRIPT, *given], env=environment, capture_output=True, text=True, timeout=120,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-500:] + done.stderr[-2000:]
    report = json.loads(done.stdout)

    assert np.array(report["answers"]).tobytes() == sent_by(run).tobytes()
    assert report["last"] == [0.0, 0.0]
    assert report["code"] == 0


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (["scenario:={}"], "the parameter law is not set"),
        (["scenario:={}", "law:=fastest"], "fastest"),
        (["scenario:={}", "law:=pid", "reference:=path"], "waypoints"),
        (["scenario:={}", "law:=pid", "reference:=goal"], "must be one of scenario, path"),
        (["scenario:={}", "law:=pid", "wheels:=[left, left]"], "left and right"),
        (["scenario:={}", "law:=pid", "jump:=[0.1]"], "must have two"),
    ],
)
def test_what_cannot_be_configured_is_a_sentence(ros, environment, tmp_path, settings, said):
    scenario = 'extends = "paper-simulation"\n'

    assert said in refusal_of("drive", settings, scenario, ros, environment, tmp_path)


WAY = """
extends = "paper-simulation"
[limits]
v_u1 = [1.0, 2.0]
v_u2 = [0.7, 1.4]
[base]
kind = "velocity"
tau = [0.05, 0.05]
[clock]
control = 0.02
[filter]
kind = "clip"
gain = [0.9, 1.1]
d = [0.05, 0.05]
[reference]
kind = "waypoints"
points = [[0.0, 0.0], [1.0, 0.0]]
speed = 0.3
[disturbance]
std = 0.0
"""


CIRCLE = (
    WAY.partition("[reference]")[0]
    + """
[reference]
kind = "circle"
radius = 1.0
rate = 0.3
[disturbance]
std = 0.0
"""
)


@pytest.fixture(scope="module")
def life(ros, environment, tmp_path_factory):
    return report_of("drive_live.py", WAY, ros, environment, tmp_path_factory.mktemp("life"))


@pytest.fixture(scope="module")
def faults(ros, environment, tmp_path_factory):
    return report_of("drive_faults.py", CIRCLE, ros, environment, tmp_path_factory.mktemp("faults"))


def test_it_is_a_lifecycle_node_that_can_be_configured_twice(life):
    assert life["transitions"] == [True] * 6


def test_what_a_promise_rests_on_cannot_be_set(life):
    assert life["set"] == {"law": False, "rise": False}


def test_a_path_in_odom_is_driven_to_its_end_and_one_in_map_is_not(life):
    assert life["before a path"] == life["path in map"] == "no-path"
    assert life["arrived"]
    assert life["off"] < 0.02


def test_a_process_that_stood_still_ramps_from_where_it_was_and_goes_on(life):
    assert life["while frozen"] == 0
    assert all(0 <= v < 0.2 for v in life["thawed"])
    assert life["thawed"] == sorted(life["thawed"], reverse=True)
    assert life["goes on"]


def test_a_killed_node_is_silent_and_its_next_life_begins_with_zeros(life):
    assert life["after the kill"] == 0
    assert life["next life"] == 0.0
    assert life["interrupt"] == [0.0, 0]


def test_a_second_node_is_refused(life):
    assert life["refused"] == 2


def test_a_twin_is_told_also_for_a_while_after_its_death(life):
    assert life["twin"]
    assert any("own name" in text and "lease" in text for text in life["ghost"])


TICK, TIMEOUT = 0.02, 0.1
"""Of the node [s]."""
STEP = 2.0 * TICK * 1.01
"""Most that a tick may take off the speed [m/s]; fall is 2 m/s2."""


@pytest.mark.parametrize(
    "fault",
    ["missing", "in map", "of a laser", "no rotation", "NaN", "without stamp", "old", "stopped"],
)
def test_without_odometry_that_counts_it_ramps_to_rest(faults, fault):
    found = faults["simulated" if fault == "stopped" else "real"][fault]

    assert found["falls"] <= bar(found, TIMEOUT)
    assert found["zero"] <= bar(found, TIMEOUT + 0.35)  # at most .7 m/s at 2 m/s2
    assert found["steps"] <= STEP
    assert found["last"] == 0
    assert any("no-odometry" in text for text in found["said"])


@pytest.mark.parametrize(
    ("clock", "fault", "flag"),
    [
        ("real", "pose leaps", "pose-jump"),
        ("simulated", "back", "time-back"),
        ("simulated", "ahead", "time-forth"),
    ],
)
def test_a_leap_brakes_at_once_and_drives_on(faults, clock, fault, flag):
    found = faults[clock][fault]

    assert found["falls"] <= bar(found, 0.0)
    assert found["steps"] <= STEP
    assert found["last"] > 0.1
    assert any(flag in text for text in found["said"])


def test_what_latches_waits_for_a_reset(faults):
    real = faults["real"]
    assert real["too fast"]["falls"] <= bar(real["too fast"], 0.0)
    assert real["too fast"]["steps"] <= STEP
    assert real["latched"] == [0.0, True]
    assert real["stop"]["zero"] <= bar(real["stop"], 0.0)
    assert real["reset while stopped"] is False
    assert real["stopped"] == [0.0, True]
    assert real["drives again"]
    assert faults["simulated"]["drives again"]
