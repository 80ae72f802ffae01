"""Words for a robot that changes: the fewest numbers that tell its states apart."""

import pytest

from wmr_ctrl.core.fields.units import plain
from wmr_ctrl.results.windows import robots_over
from wmr_ctrl.simulation.runnable import settings_of
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
    "start, end, words",
    [
        (0, 40, "50 kg"),
        (40, 60, "65 kg"),
        (39.99, 40.01, "50 kg, from 40 s on 65 kg"),
        (0, 80, "50 kg, from 40 s on 65 kg, from 60 s on 70 kg"),
    ],
)
def test_windows_name_the_robots_that_drive_in_them(start, end, words):
    changes = {"changes": [{"t": 40.0, "m": 65.0}, {"t": 60.0, "m": 70.0}]}
    settings = settings_of(load_scenario("paper-simulation-nominal", changes))

    assert robots_over(settings, start, end) == words


@pytest.mark.parametrize(
    "value, text",
    [(12345670.0, "12345670"), (65.0, "65"), (1e-5, "0.00001"), (0.0, "0"), (1e-9, "1e-09")],
)
def test_numbers_are_written_without_exponent(value, text):
    assert plain(value) == text
    assert f" coefficient of {text}." in Change(t=1.0, mu=value).sentence
