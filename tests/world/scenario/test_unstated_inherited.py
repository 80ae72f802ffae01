"""What a file calls assumed is listed until somebody states it; presets are whole."""

import pytest

from tests.papers_robot import HEAD
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.scenario import inherited, load_scenario, loads_scenario, override
from wmr_ctrl.world.scenario.unstated import KIND


def keys(path, overrides=None):
    return [item.key for item in inherited(load_scenario(path, overrides))]


LIMITED = f"""assumed = ["limits.v_u1", "robot.mu"]
{HEAD}[limits]
v_u1 = [0.9, 1.4]
[robot]
mu = 0.0
"""


def test_what_a_file_calls_assumed_is_listed_until_somebody_states_it(tmp_path):
    mine = tmp_path / "mine.toml"
    mine.write_text(LIMITED)
    child = tmp_path / "child.toml"

    assert keys(mine) == ["limits.v_u1", "robot.mu"]
    stated = load_scenario(mine, {"limits.v_u1[1]": 0.95})
    assert stated.assumed == ("robot.mu",)
    assert override(load_scenario(mine), {"robot": {"mu": 0.1}}).assumed == ("limits.v_u1",)
    child.write_text('extends = "mine.toml"\n[limits]\nv_u1 = [1.0, 1.5]\n')
    assert keys(child) == ["robot.mu"]
    child.write_text(f'extends = "mine.toml"\nassumed = ["{KIND}"]\n[reference]\nkind = "line"\n')
    assert keys(child) == ["limits.v_u1", "robot.mu", KIND]


@pytest.mark.parametrize("raw", ['"robot.m"', '["robot.mass"]', '["robot"]', "[1]", "3"])
def test_what_is_assumed_is_a_list_of_keys(raw):
    with pytest.raises(ScenarioError, match="assumed"):
        loads_scenario(f"assumed = {raw}\n{HEAD}")
