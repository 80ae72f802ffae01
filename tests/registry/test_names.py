"""What is looked up by name: each name is of one thing, says what it is, and is its own key."""

from __future__ import annotations

import pytest

from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.results.figures import FIGURES
from wmr_ctrl.world.references import REFERENCES
from wmr_ctrl.world.registry import EFFECTS
from wmr_ctrl.world.scenario.scenario import sections


@pytest.mark.parametrize("registry", [LAWS, REFERENCES], ids=["laws", "references"])
def test_an_entry_is_found_by_the_name_that_it_gives_itself(registry):
    assert len(registry) == len(set(registry)) > 3
    assert {name: entry.name for name, entry in registry.items()} == {
        name: name for name in registry
    }


def test_effects_have_names_and_sections_of_their_own():
    names = [effect.name for effect in EFFECTS]

    assert len(set(names)) == len(names)
    assert all(effect.section.__doc__ for effect in EFFECTS)


def test_every_section_of_a_scenario_stands_under_its_own_key():
    for key, section in sections().items():
        assert key == section.KEY


def test_a_figure_is_found_by_its_name():
    names = [figure.name for figure in FIGURES]

    assert len(set(names)) == len(names)
    assert [FIGURES[name].name for name in names] == names
