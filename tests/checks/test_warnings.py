"""Common properties of all warnings."""

import re

import pytest

from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.checks import warnings_for
from wmr_ctrl.world.scenario import load_scenario


@pytest.mark.parametrize(
    "name, law",
    [
        ("paper-experiment", "nn"),
        ("paper-simulation", "pid"),
    ],
)
def test_every_preset_gets_a_handful_of_readable_sentences(name, law):
    found = warnings_for(settle(load_scenario(name), law))

    assert len(found) <= 5
    for warning in found:
        assert re.fullmatch(r"[^\n]{60,500}\.", warning.sentence)
        assert not re.search(r"\bnan\b|np\.|array|\{", warning.sentence)
        assert warning.equation
        assert str(warning) == f"{warning.sentence} [{warning.equation}]"


def test_gravest_comes_first():
    found = warnings_for(settle(load_scenario("outside-start", {"clock.control": 0.1}), "mb"))

    assert [warning.key for warning in found][:3] == ["initial.velocity"] * 2 + ["clock.control"]
