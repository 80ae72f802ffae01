"""``python -m wmr_ctrl.ros2 prepare``, and the texts of refusals; no ROS 2 is needed."""

import logging

import pytest

from tests.ros2.test_scans import STATED
from wmr_ctrl.codegen.toolchain import BUILDS
from wmr_ctrl.control.filter.gate import GateSettings
from wmr_ctrl.core.errors import WmrError
from wmr_ctrl.ros2.__main__ import main
from wmr_ctrl.ros2.filter_core import FilterCore
from wmr_ctrl.ros2.prepare import prepare
from wmr_ctrl.ros2.refusals import Received
from wmr_ctrl.ros2.sight import SightSettings
from wmr_ctrl.world.scenario import load_scenario, to_toml


def test_nothing_is_compiled_after_prepare(tmp_path, monkeypatch, caplog):
    monkeypatch.setenv("WMR_CTRL_CACHE", str(tmp_path))
    caplog.set_level(logging.INFO, BUILDS.name)
    ready = list(prepare("turtlebot3-burger", ["command_timeout:=0.4"]))
    assert len(ready) == 4
    assert any("compiling filter" in line for line in caplog.messages)

    caplog.clear()
    for use in ("none", "watched", "required"):
        settings = GateSettings(command_timeout=0.4, odometry=use)
        FilterCore(load_scenario("turtlebot3-burger"), settings, "base_footprint")
    assert caplog.messages == []


def test_nothing_is_compiled_after_prepare_with_a_laser(tmp_path, monkeypatch, caplog):
    monkeypatch.setenv("WMR_CTRL_CACHE", str(tmp_path))
    caplog.set_level(logging.INFO, BUILDS.name)
    path, words = tmp_path / "base.toml", ['scans:=["scan"]', "radius:=0.25", "odometry:=none"]
    path.write_text(to_toml(load_scenario("paper-simulation", STATED)), "utf-8")
    assert next(prepare(str(path), words)) == "filter, odometry none"

    caplog.clear()
    sight = SightSettings(scans=("scan",), radius=0.25)
    FilterCore(load_scenario(str(path)), GateSettings(odometry="none"), "base_link", sight)
    assert caplog.messages == []


@pytest.mark.parametrize("words", [["odometri:=none"], ["odometry=none"], ["odometry:=maybe"]])
def test_words_that_no_node_takes_are_refused(words):
    with pytest.raises(WmrError, match="odometr"):
        list(prepare("turtlebot3-burger", words))


def test_command_ends_with_a_sentence(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["ros2", "prepare", "no-such.toml"])

    assert main() == 2
    assert "no-such.toml" in capsys.readouterr().err


@pytest.mark.parametrize(
    "reason, words",
    [
        ("wrong frame", ["'base_footprint'", "'base_link'", "base_frame"]),
        ("too old", ["0.182 s", "0.1 s", "odometry_timeout"]),
        ("repeated or out of order", []),
        ("", []),
    ],
)
def test_refusals_name_what_came_and_what_is_wanted(reason, words):
    seen = Received("base_footprint", "base_link", 10**9, 1_182_000_000, 0.1, "odometry_timeout")

    text = seen.explained(reason)

    assert text.startswith(reason)
    assert all(word in text for word in words)
    assert words or text == reason
