"""Running a plan: the same for any number of threads, prompt when it fails or is interrupted."""

from __future__ import annotations

import threading
import time

import pytest

from wmr_ctrl.campaign import Task, paper_plan, run_campaign
from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.results import runs_equal

PLAN = [Task("paper-simulation", law, seed) for seed in (4, 3, 5) for law in ("mb", "nn")]


def nothing(scenario: str, law: str) -> None:
    """Compile nothing."""


class Watch:
    """Progress that remembers its phases: total, and what was done of it."""

    def __init__(self) -> None:
        self.phases: list[list[int]] = []
        self.ended = 0

    def start(self, total: int, text: str) -> None:
        self.phases.append([total, 0])

    def advance(self, count: int = 1) -> None:
        self.phases[-1][1] += count

    def done(self) -> None:
        self.ended += 1


@pytest.mark.parametrize("jobs", [2, 7, None])
def test_the_number_of_threads_changes_nothing(fake_simulate, jobs):
    alone = run_campaign(fake_simulate, nothing, PLAN, jobs=1)
    together = run_campaign(fake_simulate, nothing, PLAN, jobs=jobs)

    assert together.table.rows == alone.table.rows
    assert all(runs_equal(together.runs[case], alone.runs[case]) for case in alone.runs)


def test_rows_stand_in_the_order_of_the_plan_however_long_runs_take(fake_simulate):
    def slow_first(scenario, law, seed):
        time.sleep(0.05 if seed == 4 else 0)
        return fake_simulate(scenario, law, seed)

    table = run_campaign(slow_first, nothing, PLAN, jobs=3).table

    assert [Task(row.scenario, row.law, row.seed) for row in table] == PLAN


def test_only_the_first_seed_of_a_case_is_kept_whole(fake_simulate):
    runs = run_campaign(fake_simulate, nothing, PLAN).runs

    assert {case: run.seed for case, run in runs.items()} == {
        ("paper-simulation", "mb"): 3,
        ("paper-simulation", "nn"): 3,
    }


def test_every_case_is_compiled_once_before_the_first_run(fake_simulate):
    calls = []

    def simulate(scenario, law, seed):
        calls.append("run")
        return fake_simulate(scenario, law, seed)

    run_campaign(simulate, lambda scenario, law: calls.append((scenario, law)), PLAN, jobs=1)

    assert calls == [("paper-simulation", "mb"), ("paper-simulation", "nn"), *["run"] * 6]


def test_progress_counts_every_step_of_every_phase(fake_simulate):
    watch = Watch()
    run_campaign(fake_simulate, nothing, PLAN, progress=watch)

    assert watch.phases == [[2, 2], [6, 6]]
    assert watch.ended == 2


@pytest.mark.parametrize("error", [RuntimeError("no"), KeyboardInterrupt()])
def test_a_failure_ends_the_campaign_at_once(fake_simulate, error):
    begun, watch = [], Watch()

    def simulate(scenario, law, seed):
        begun.append(seed)
        if len(begun) == 2:
            raise error
        time.sleep(0.01)
        return fake_simulate(scenario, law, seed)

    with pytest.raises(type(error)):
        run_campaign(simulate, nothing, paper_plan(seeds=20), jobs=2, progress=watch)
    assert len(begun) < 50
    assert watch.ended == 2


def test_no_thread_is_left_behind(fake_simulate):
    run_campaign(fake_simulate, nothing, PLAN, jobs=3)
    deadline = time.monotonic() + 5
    while any(t.name.startswith("campaign") for t in threading.enumerate()):
        assert time.monotonic() < deadline
        time.sleep(0.01)


@pytest.mark.parametrize("wrong", [{"jobs": 0}, {"plan": []}])
def test_impossible_campaigns_are_refused(fake_simulate, wrong):
    with pytest.raises(ArgumentError):
        run_campaign(fake_simulate, nothing, **{"plan": PLAN, **wrong})
