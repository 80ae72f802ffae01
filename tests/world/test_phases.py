"""Words for a robot that changes: the fewest numbers that tell its states apart."""

import pytest

from wmr_ctrl.world.phases import robots_in_words
from wmr_ctrl.world.scenario import load_scenario


@pytest.mark.parametrize(
    "changes, words",
    [
        ([], ()),
        ([{"t": 4.0, "m": 50.0}], ()),
        ([{"t": 4.0, "m": 65.0, "I": 7.0}], ("50 kg", "65 kg")),
        ([{"t": 0.0, "m": 65.0}, {"t": 4.0, "m": 50.0}], ("65 kg", "50 kg")),
        ([{"t": 4.0, "mu": 0.15}], ("friction 0.08", "friction 0.15")),
        (
            [{"t": 4.0, "m": 65.0}, {"t": 5.0, "mu": 0.0}],
            ("50 kg, friction 0.08", "65 kg, friction 0.08", "65 kg, friction 0"),
        ),
        ([{"t": 4.0, "m": 65.0}, {"t": 5.0, "m": 50.0}], ("50 kg", "65 kg", "50 kg")),
    ],
)
def test_robots_are_told_apart(changes, words):
    case = load_scenario("paper-simulation-nominal", {"changes": changes})

    assert tuple(text for _, text in robots_in_words(case)) == words
