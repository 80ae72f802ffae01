"""Presets against the numbers of the paper and of the project's conventions, typed by hand."""

import pickle

import pytest

from wmr_ctrl.world.scenario import (
    from_dict,
    load_scenario,
    loads_scenario,
    preset_names,
    scenario_dict,
    to_toml,
)

NAMES = (
    "paper-experiment",
    "paper-experiment-literal",
    "paper-simulation",
    "paper-simulation-no-switch",
    "paper-simulation-noise-free",
    "paper-simulation-nominal",
    "far-start",
    "far-start-drop",
    "far-start-friction-overestimated",
    "fast-reference",
    "outside-start",
)


@pytest.mark.parametrize("name", preset_names())
@pytest.mark.parametrize("comments", [True, False])
def test_toml_loads_back_equal(name, comments):
    scenario = load_scenario(name)

    assert loads_scenario(to_toml(scenario, comments=comments), name) == scenario
    assert from_dict(scenario_dict(scenario), name) == scenario
    assert pickle.loads(pickle.dumps(scenario)) == scenario
    assert hash(pickle.loads(pickle.dumps(scenario))) == hash(scenario)
