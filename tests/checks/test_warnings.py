"""What all warnings have in common."""

import re
from itertools import cycle

import pytest

from tests.checks.asking import STABILITY
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import UnknownNameError
from wmr_ctrl.results.verdicts import Warning
from wmr_ctrl.theory.checks import warnings_for
from wmr_ctrl.theory.checks.sample_time import sample_time
from wmr_ctrl.theory.checks.sending import loop_of
from wmr_ctrl.world.scenario import load_scenario, preset_names


@pytest.mark.parametrize(
    "name, law",
    [
        ("paper-experiment", "nn"),
        ("paper-simulation", "pid"),
        ("robot-100ms", "prox"),
        ("outside-start", "smc"),
        ("turtlebot3-burger", "pursuit"),
    ],
)
@pytest.mark.slow_but("paper-experiment-nn", "paper-simulation-pid")
def test_every_preset_gets_a_handful_of_readable_sentences(name, law):
    found = warnings_for(settle(load_scenario(name), law))

    assert len(found) <= 5
    for warning in found:
        assert re.fullmatch(r"[^\n]{60,500}\.", warning.sentence)
        assert not re.search(r"\bnan\b|np\.|array|\{", warning.sentence)
        assert warning.equation
        assert str(warning) == f"{warning.sentence} [{warning.equation}]"


@pytest.mark.slow
def test_stability_is_told_by_two_keys_alone():
    """So that tests of other keys need not ask for it."""
    robots = [name for name in preset_names() if not load_scenario(name).takes_velocity]
    for name, law in zip(robots[::4], cycle(LAWS), strict=False):
        found = sample_time(loop_of(settle(load_scenario(name), law)))
        assert {warning.key for warning in found} <= set(STABILITY)


def test_theorems_own_case_gets_no_objection():
    assert warnings_for(settle(load_scenario("paper-simulation-nominal"), "mb")) == ()


def test_gravest_comes_first():
    found = warnings_for(settle(load_scenario("outside-start", {"clock.control": 0.1}), "mb"))

    assert [warning.key for warning in found][:3] == ["initial.velocity"] * 2 + ["clock.control"]


def test_same_question_same_answer():
    first, second = (warnings_for(settle(load_scenario("far-start"), "nn")) for _ in range(2))

    assert first is second


def test_warnings_are_values():
    warning = Warning("clock.control", "Too long.", "Eq. (9)")

    assert warning == Warning("clock.control", "Too long.", "Eq. (9)")
    with pytest.raises(AttributeError):
        warning.key = "other"


def test_unknown_law():
    with pytest.raises(UnknownNameError, match="near: pid"):
        warnings_for(settle(load_scenario("paper-simulation"), "pit"))
