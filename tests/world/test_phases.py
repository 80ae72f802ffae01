"""Words for a robot that changes: the fewest numbers that distinguish its states."""

import pytest

from tests.tables import cases
from wmr_ctrl.world.phases import robots_in_words
from wmr_ctrl.world.scenario import load_scenario

ROBOTS = """
    [] | -
    [{t = 4.0, m = 50.0}] | -
    [{t = 4.0, m = 65.0, I = 7.0}] | 50 kg; 65 kg
    [{t = 0.0, m = 65.0}, {t = 4.0, m = 50.0}] | 65 kg; 50 kg
    [{t = 4.0, mu = 0.15}] | friction 0.08; friction 0.15
    [{t=4, m=65}, {t=5, mu=0}] | 50 kg, friction 0.08; 65 kg, friction 0.08; 65 kg, friction 0
    [{t = 4.0, m = 65.0}, {t = 5.0, m = 50.0}] | 50 kg; 65 kg; 50 kg
"""


@pytest.mark.parametrize("changed, words", cases(ROBOTS))
def test_robots_are_told_apart(changed, words):
    case = load_scenario("paper-simulation-nominal", {"changes": changed})

    assert "; ".join(text for _, text in robots_in_words(case)) == words.strip("-")
