"""Presets against the numbers of the paper and of the project's conventions, typed by hand."""

import pickle

import pytest

from wmr_ctrl.core.errors import UnknownNameError
from wmr_ctrl.world.scenario import (
    from_dict,
    load_scenario,
    loads_scenario,
    preset_names,
    preset_titles,
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


def test_all_are_there_and_the_papers_come_first():
    assert set(NAMES) <= set(preset_names())
    assert preset_names()[0].startswith("paper")


@pytest.mark.parametrize("name", preset_names())
def test_loads_and_is_described_in_one_line(name):
    scenario = load_scenario(name)

    assert scenario.name == name
    assert scenario.title == preset_titles()[name]
    assert 20 < len(scenario.title) < 90
    assert "\n" not in scenario.title


@pytest.mark.parametrize("name", preset_names())
@pytest.mark.parametrize("comments", [True, False])
def test_toml_loads_back_equal(name, comments):
    scenario = load_scenario(name)

    assert loads_scenario(to_toml(scenario, comments=comments), name) == scenario
    assert from_dict(scenario_dict(scenario), name) == scenario
    assert pickle.loads(pickle.dumps(scenario)) == scenario
    assert hash(pickle.loads(pickle.dumps(scenario))) == hash(scenario)


def test_unknown_name_lists_the_near_ones():
    with pytest.raises(UnknownNameError, match=r"near: paper-simulation.*path"):
        load_scenario("paper-simulaton")
