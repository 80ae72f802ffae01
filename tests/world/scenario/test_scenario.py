"""The Scenario: its tables, its gains, and the values derived from its fields."""

import pytest

from tests.papers_robot import paper
from wmr_ctrl.core.errors import ScenarioError, UnknownNameError
from wmr_ctrl.world.gust import Gust
from wmr_ctrl.world.scenario import override
from wmr_ctrl.world.scenario.scenario import SECTIONS, clean_gains, sections


def test_the_middle_of_a_run_splits_it_unless_stated():
    assert override(paper(), {"clock.duration": 8.0}).split == 4.0
    assert override(paper(), {"metrics.split": 1.5}).split == 1.5


def test_laws_believe_the_robot_except_what_the_model_states():
    scenario = override(paper(), {"model.m": 40.0, "robot.mu": 0.2})

    assert (scenario.believed.m, scenario.believed.mu) == (40.0, 0.2)
    assert scenario.table("model") == scenario.believed
    assert scenario.robot.m != 40.0


def test_every_table_is_found_by_its_key_with_its_defaults():
    scenario = paper()

    assert all(
        type(scenario.table(key)) is kind for key, kind in SECTIONS.items() if key != "model"
    )
    assert scenario.section(Gust) == Gust()
    assert all(key == section.KEY for key, section in sections().items())
    with pytest.raises(UnknownNameError, match="no section is named 'gusts'"):
        scenario.table("gusts")


def test_numbers_have_a_signal_at_their_key_and_the_references_at_their_name():
    signal, value = paper().number("robot.m")

    assert (signal.unit, value) == ("kg", paper().value("robot.m"))
    assert paper().number("ref_radius")[1] == paper().value("ref_radius")
    with pytest.raises(UnknownNameError, match="number of the reference"):
        paper().number("ref_nothing")


@pytest.mark.parametrize(
    "raw, words",
    [
        (3, "gains = 3 must be a table of laws"),
        ({"mb": 3}, "gains.mb = 3 must be a table of gains"),
        ({"mb": {"k": [1, None]}}, r"gains.mb.k\[2\]"),
    ],
)
def test_gains_are_tables_of_numbers(raw, words):
    with pytest.raises(ScenarioError, match=words):
        clean_gains(raw)
    cleaned = clean_gains({"mb": {"k": [1, 2.5], "on": True, "c": 3}})
    assert cleaned == {"mb": {"k": (1.0, 2.5), "on": True, "c": 3.0}}
    assert hash(cleaned) == hash(clean_gains(cleaned))
