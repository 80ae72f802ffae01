"""Words for a robot that changes: the fewest numbers that tell its states apart."""

import pytest

from wmr_ctrl.core.fields.units import plain
from wmr_ctrl.world.phases import robots_in_words
from wmr_ctrl.world.scenario import load_scenario
from wmr_ctrl.world.scenario.sections import Change


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


@pytest.mark.parametrize(
    "value, text",
    [(12345670.0, "12345670"), (65.0, "65"), (1e-5, "0.00001"), (0.0, "0"), (1e-9, "1e-09")],
)
def test_numbers_are_written_without_exponent(value, text):
    assert plain(value) == text
    assert f" coefficient of {text}." in Change(t=1.0, mu=value).sentence
