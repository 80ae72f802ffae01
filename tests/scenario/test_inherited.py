"""What a sparse file takes from the paper is listed; what it states is not."""

from __future__ import annotations

import pytest

from wmr_ctrl.scenario import inherited, load_scenario
from wmr_ctrl.scenario.toml_io import OF_A_ROBOT


def keys(path, overrides=None):
    found = inherited(load_scenario(path, overrides), str(path), overrides or ())
    return [item.key for item in found]


def test_an_empty_file_takes_everything_and_a_preset_is_complete(tmp_path):
    (tmp_path / "mine.toml").write_text("")

    assert keys(tmp_path / "mine.toml") == list(OF_A_ROBOT)
    assert keys("paper-simulation") == []


@pytest.mark.parametrize("key", OF_A_ROBOT)
def test_what_is_stated_in_a_file_or_by_an_override_is_not_listed(tmp_path, key):
    scenario = load_scenario("paper-simulation")
    table, name = key.split(".")
    value = getattr(scenario.table(table), name)
    text = list(value) if isinstance(value, tuple) else value
    (tmp_path / "mine.toml").write_text(f"[{table}]\n{name} = {text}\n")
    (tmp_path / "child.toml").write_text('extends = "mine.toml"\n')
    (tmp_path / "empty.toml").write_text("")
    rest = [other for other in OF_A_ROBOT if other != key]

    assert keys(tmp_path / "mine.toml") == rest
    assert keys(tmp_path / "empty.toml", {key: text}) == rest
    # Relative to the file that extends it, and presets that are extended do not count.
    assert keys(tmp_path / "child.toml") == rest
    (tmp_path / "child.toml").write_text('extends = "far-start"\n')
    assert keys(tmp_path / "child.toml") == list(OF_A_ROBOT)
