"""The labelled runs: the same numbers are the same runs, and the rule and the remarks agree."""

from functools import cache

import pytest

from benchmarks.verdicts import REPORTED_ON, faults, judged, table
from wmr_ctrl.api import simulate
from wmr_ctrl.control.given import scenario_of


def shares(rows):
    """Of the bad those without a remark, of the good those with one on how the run went."""
    bad, good = [row for row in rows if row.faults], [row for row in rows if not row.faults]
    return (sum(not row.keys for row in bad) / len(bad), sum(row.seen for row in good) / len(good))


def test_the_rule_finds_nothing_wrong_with_a_good_run():
    case = scenario_of("safe-simulation", {"changes": []})

    assert list(faults(simulate(case, "kanayama"), case)) == []


@pytest.mark.parametrize("changed", [{"actuator.tau_max": 1.0}, {"metrics.tolerance": 1e-5}])
def test_the_rule_finds_what_is_wrong(changed):
    case = scenario_of("paper-simulation-no-switch", changed)

    assert list(faults(simulate(case, "prox"), case))


@cache
def first():
    """The first rows of the table of 300 that the benchmark prints."""
    return list(judged(REPORTED_ON, 6))


@pytest.mark.slow
def test_some_runs_are_judged_as_the_rule_has_it():
    found = first()

    assert all(bool(row.keys) >= bool(row.faults) for row in found)
    assert "missed: bad" in table(found)


@pytest.mark.slow
def test_misses_and_false_alarms_are_few():
    misses, alarms = shares(first())

    assert misses <= 0.02
    assert alarms <= 0.05
