"""The labelled runs: the same numbers are the same runs, and the rule and the remarks agree."""

import pytest

from benchmarks.verdicts import REPORTED_ON, faults, judged, table
from wmr_ctrl.api import simulate
from wmr_ctrl.control.given import scenario_of


def test_the_rule_finds_nothing_wrong_with_a_good_run():
    case = scenario_of("safe-simulation", {"changes": []})

    assert list(faults(simulate(case, "kanayama"), case)) == []


@pytest.mark.parametrize("changed", [{"actuator.tau_max": 1.0}, {"metrics.tolerance": 1e-5}])
def test_the_rule_finds_what_is_wrong(changed):
    case = scenario_of("paper-simulation-no-switch", changed)

    assert list(faults(simulate(case, "prox"), case))


@pytest.mark.slow
def test_some_runs_are_judged_as_the_rule_has_it_with_few_misses_and_false_alarms():
    """They are the first rows of the benchmark's table of 300."""
    found = list(judged(REPORTED_ON, 6))
    good = [row for row in found if not row.faults]

    assert all(bool(row.keys) >= bool(row.faults) for row in found)
    assert "missed: bad" in table(found)
    assert sum(bool(row.seen) for row in good) <= 0.05 * len(good)
