"""Scenarios as callers give them: a name, a file or a Scenario, with fields replaced."""

import pytest

from tests.papers_robot import paper
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.core.errors import ArgumentError, ScenarioError
from wmr_ctrl.world.scenario import to_toml


def test_a_name_a_file_and_a_scenario_are_the_same_with_fields_replaced(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(to_toml(paper()))
    changed = {"robot.mu": 0.1}

    assert scenario_of(file, changed).robot == scenario_of(paper(), changed).robot
    assert scenario_of("far-start", changed).robot.mu == 0.1
    assert scenario_of(paper(), guard=True).guard.enabled is True
    assert scenario_of(paper(), {"guard.enabled": True}, guard=False).guard.enabled is False


def test_a_law_is_no_scenario_and_a_fault_is_told_with_its_file(tmp_path):
    with pytest.raises(ArgumentError, match="'pid' is a law, but the first argument"):
        scenario_of("pid")
    with pytest.raises(ScenarioError, match=r"^robot\.mu"):
        scenario_of(paper(), {"robot.mu": -1.0})
