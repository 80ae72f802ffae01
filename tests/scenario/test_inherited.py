"""What a sparse file takes from the paper is listed; what it states is not."""

from __future__ import annotations

import pytest

from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.scenario import inherited, load_scenario, loads_scenario, override, to_toml
from wmr_ctrl.world.scenario.toml_io import KIND, OF_A_ROBOT, preset_names


def keys(path, overrides=None):
    found = inherited(load_scenario(path, overrides), str(path), overrides or ())
    return [item.key for item in found]


def test_an_empty_file_takes_everything_and_a_preset_is_complete(tmp_path):
    (tmp_path / "mine.toml").write_text("")

    assert keys(tmp_path / "mine.toml") == [*OF_A_ROBOT, KIND]
    assert keys("paper-simulation") == []
    (tmp_path / "path.toml").write_text("[reference]\nradius = 3.0\n")
    assert keys(tmp_path / "path.toml") == list(OF_A_ROBOT)


@pytest.mark.parametrize("key", OF_A_ROBOT)
def test_what_is_stated_in_a_file_or_by_an_override_is_not_listed(tmp_path, key):
    scenario = load_scenario("paper-simulation")
    table, name = key.split(".")
    value = getattr(scenario.table(table), name)
    text = list(value) if isinstance(value, tuple) else value
    (tmp_path / "mine.toml").write_text(f"[{table}]\n{name} = {text}\n")
    (tmp_path / "child.toml").write_text('extends = "mine.toml"\n')
    (tmp_path / "empty.toml").write_text("")
    rest = [other for other in (*OF_A_ROBOT, KIND) if other != key]

    assert keys(tmp_path / "mine.toml") == rest
    assert keys(tmp_path / "empty.toml", {key: text}) == rest
    # Relative to the file that extends it, and presets that are extended do not count.
    assert keys(tmp_path / "child.toml") == rest
    (tmp_path / "child.toml").write_text('extends = "far-start"\n')
    assert keys(tmp_path / "child.toml") == [*OF_A_ROBOT, KIND]


LIMITED = 'assumed = ["limits.v_u1", "robot.mu"]\n[limits]\nv_u1 = [0.9, 1.4]\n[robot]\nmu = 0.0\n'


def test_what_a_file_calls_assumed_is_listed_until_somebody_states_it(tmp_path):
    mine = tmp_path / "mine.toml"
    mine.write_text(LIMITED)
    child = tmp_path / "child.toml"

    assert {"limits.v_u1", "robot.mu"} < {*keys(mine)}
    stated = load_scenario(mine, {"limits.v_u1[1]": 0.95})
    assert stated.assumed == ("robot.mu",)
    assert override(load_scenario(mine), {"robot": {"mu": 0.1}}).assumed == ("limits.v_u1",)
    assert "limits.v_u1" not in keys(mine, {"limits.v_u1[1]": 0.95})
    child.write_text('extends = "mine.toml"\n[limits]\nv_u1 = [1.0, 1.5]\n')
    assert load_scenario(child).assumed == ("robot.mu",)
    assert "limits.v_u1" not in keys(child)
    assert "robot.mu" in keys(child)
    child.write_text(f'extends = "mine.toml"\nassumed = ["{KIND}"]\n[reference]\nkind = "line"\n')
    assert load_scenario(child).assumed == ("limits.v_u1", "robot.mu", KIND)
    assert KIND in keys(child)


def test_what_is_assumed_is_written_and_read_again():
    scenario = loads_scenario(LIMITED)

    assert scenario.assumed == ("limits.v_u1", "robot.mu")
    assert loads_scenario(to_toml(scenario)) == scenario
    assert loads_scenario(to_toml(scenario, comments=False)) == scenario
    assert "assumed" not in to_toml(load_scenario("paper-simulation"))


@pytest.mark.parametrize("raw", ['"robot.m"', '["robot.mass"]', '["robot"]', "[1]", "3"])
def test_what_is_assumed_is_a_list_of_keys(raw):
    with pytest.raises(ScenarioError, match="assumed"):
        loads_scenario(f"assumed = {raw}\n")


@pytest.mark.parametrize("name", preset_names())
def test_a_text_without_defaults_is_the_same_scenario(name):
    scenario = load_scenario(name)

    text = to_toml(scenario, only={"robot.m"})

    assert loads_scenario(text, name) == scenario
    assert len(text) < len(to_toml(scenario)) / 2
    assert ("\nl = " in text) is (scenario.robot.l != 0.25)
