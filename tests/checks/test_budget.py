"""Work of a verdict: independent of earlier requests, and charged where it is spent."""

import os
import subprocess
import sys

import pytest

from tests.tables import changes
from wmr_ctrl.cli import check_answers
from wmr_ctrl.control.setup import settle
from wmr_ctrl.results import NOT_CHECKED
from wmr_ctrl.theory.checks import warnings_for
from wmr_ctrl.theory.checks.budget import OF_RUN, OverBudgetError, budget, counted, spend
from wmr_ctrl.theory.checks.outlook import CheckVerdict, verdict
from wmr_ctrl.world.scenario import load_scenario

UNSTABLE = changes("""
    reference.kind = rounded-square; reference.speed = 0.198; clock.duration = 10.0
    model.m = 1.93; model.I = 0.0077
""")
"""A path on which nn with its 133 states is unstable, and whose stable periods take 7 s."""
LITTLE = 5.0


def keys(setup, work):
    return [item.key for item in warnings_for(setup, work)]


def test_cached_answer_costs_what_it_once_took():
    @counted
    def answer(name):
        spend(0, 10)
        return name

    for _ in range(2):
        with budget(25.0):
            assert [answer("a"), answer("a")] == ["a", "a"]
            with pytest.raises(OverBudgetError):
                answer("a")


def test_what_is_not_checked_does_not_depend_on_what_was_asked_before():
    setup = settle(load_scenario("turtlebot3-burger"), "nn")
    assert keys(setup, LITTLE) == [NOT_CHECKED]
    assert NOT_CHECKED not in keys(setup, OF_RUN)
    warnings_for.cache_clear()
    (said,) = warnings_for(setup, LITTLE)
    assert said.key == NOT_CHECKED
    assert not said.objects
    assert "`wmr-ctrl check --law nn`" in said.sentence


def test_check_shows_what_is_not_checked():
    case = load_scenario("turtlebot3-burger")
    answers = check_answers.find_answers(case, ("nn",), (), "stability", LITTLE)
    shown = check_answers.document(answers)
    assert shown["verdict"] == {"nn": "not-checked"}
    assert [shown[key]["nn"] for key in ("min_period", "max_period", "max_delay")] == [None] * 3
    assert [item["key"] for item in shown["warnings"]] == [NOT_CHECKED]
    assert "not checked" in "\n".join(check_answers.law_table(answers))
    (note,) = [item.text for item in check_answers.about(answers, "stability")]
    assert "`wmr-ctrl check --law nn`" in note


def test_objection_outweighs_what_is_not_checked():
    warnings = warnings_for(settle(load_scenario("turtlebot3-burger"), "nn"), LITTLE)
    objection = warnings_for(settle(load_scenario("turtlebot3-burger", UNSTABLE), "nn"))
    assert verdict(warnings, None) is CheckVerdict.NOT_CHECKED
    assert verdict((*warnings, *objection), None) is CheckVerdict.OBJECTED


def test_commands_use_one_thread_of_the_linear_algebra():
    environment = {k: v for k, v in os.environ.items() if k != "OPENBLAS_NUM_THREADS"}
    code = (
        "import atexit, os, sys; from wmr_ctrl.__main__ import main\n"
        "assert 'numpy' not in sys.modules\n"
        "atexit.register(lambda: print(os.environ['OPENBLAS_NUM_THREADS']))\n"
        "sys.argv = ['wmr-ctrl', '--version']; main()"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout.split()[-1] == "1"
