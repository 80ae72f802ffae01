"""Many runs at once: every lane is the run that the loop of one robot makes."""

import ctypes as ct
import threading
from types import SimpleNamespace

import numpy as np
import pytest

from tests.papers_robot import preset
from tests.tables import changes
from wmr_ctrl.api import simulate_many
from wmr_ctrl.codegen import build
from wmr_ctrl.codegen.build import vector_sets
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.results.windows import windows_of
from wmr_ctrl.simulation.batch import run_logged, run_tasks
from wmr_ctrl.simulation.engines import runnable
from wmr_ctrl.simulation.memory import Task, laid_out

SHORT = changes("""
clock.duration = 6.0
changes = [{t = 3.0, m = 65.0, I = 7.0, mu = 0.15}]
""")


def tasks_of(law, count, *told):
    """Tasks with ``count`` seeds on the paper's simulation."""
    loop = runnable(preset("paper-simulation", SHORT, *told), law)
    return [Task(loop, seed) for seed in range(count)]


def same_values(one, other):
    """True if all texts and numbers are equal; NaN equals itself."""
    return bool(np.all((one == other) | (one != one) & (other != other)))


def test_a_run_that_ended_counts_no_further_while_others_go_on():
    """The guard acts in all samples of a push that carries the robot out, and hardly in others."""
    guard = "guard.enabled = true; guard.trust = true; guard.dbar = [70.0, 15.0]"
    pushes = "disturbance.push = [1e6, 1.0]", "disturbance.push = [1.0, 1.0]"
    tasks = [task for push in pushes for task in tasks_of("pid", 1, guard, push)]
    together = run_tasks(tasks)

    assert (together["stop"] > 0).tolist() == [True, False]
    for place, task in enumerate(tasks):
        own = run_tasks([task])
        assert [k for k in own if not same_values(together[k][place], own[k][0])] == []


@pytest.mark.slow
def test_order_jobs_and_company_do_not_matter():
    """Neighbours of a lane, even diverging ones, do not affect it."""
    wild, tame = tasks_of("pid", 2, "gains.pid.Kp = [2e4, 2e3]"), tasks_of("pid", 9)
    alone, mixed = run_tasks(tame, jobs=1), run_tasks([wild[0], *tame, wild[1]], jobs=4)

    assert (mixed["stop"][[0, 10]] == 1).all()
    assert [k for k in alone if not same_values(mixed[k][1:10], alone[k])] == []


def test_a_batch_that_runs_again_begins_anew():
    tasks = tasks_of("mb", 2, "actuator.delay = 0.02")
    memory = laid_out(tasks, list(windows_of(tasks[0].loop.settings).values()))
    arrays = memory.findings, memory.state, memory.added
    assert memory.run()
    first = [array.tobytes() for array in arrays]
    memory.added[:] = 7.0
    assert memory.run()

    assert first == [array.tobytes() for array in arrays]


@pytest.mark.parametrize("jobs", [0, -1, 1.5, True])
def test_jobs_that_cannot_be_are_named(jobs):
    with pytest.raises(ArgumentError, match="jobs"):
        simulate_many("paper-simulation", "mb", [0], SHORT, jobs=jobs)  # type: ignore[arg-type]


@pytest.mark.parametrize("start", [(0.0, 0.0), (0.0,) * 6, (0.0, np.nan, 0.0, 0.0, 0.0)])
def test_starts_that_cannot_be_are_named(start):
    loop = tasks_of("mb", 1)[0].loop
    with pytest.raises(ArgumentError, match="start"):
        Task(loop, 0, start)


def test_an_interrupt_ends_all_threads_at_once():
    tasks = tasks_of("mb", 64, "clock.duration = 4000.0")
    before = threading.active_count()

    def stop(share):
        raise KeyboardInterrupt

    short = tasks_of("mb", 1, "clock.duration = 0.1; changes = []")
    with pytest.raises(KeyboardInterrupt):
        run_tasks([*short, *tasks], jobs=2, progress=stop)

    assert threading.active_count() == before


def test_lanes_that_are_cancelled_do_no_further_sample():
    memory = laid_out(tasks_of("mb", 2), [], cancelled=ct.c_int32(1))

    assert not memory.run()
    assert memory.row("samples").tolist() == [0.0, 0.0]


@pytest.mark.usefixtures("every_set_of_instructions")
def test_a_compiler_may_lack_any_set_of_instructions_but_the_baseline(monkeypatch):
    asked = []
    monkeypatch.setattr(build, "build_units", lambda _, units, *__, **___: asked.extend(units))
    monkeypatch.setattr(build, "unity", lambda *_: {})
    build.Program.lanes.func(SimpleNamespace(generated_lanes={}))

    assert {item.name: item.optional for item in asked} == {
        item.name: item.name != "baseline" for item in vector_sets()
    }


@pytest.mark.parametrize(
    "beyond, axis", [((0.5, 0.01), 1), ((-0.5, 0.01), 2), ((0.0, 0.01), 2), ((0.0, 0.0), None)]
)
def test_a_run_that_begins_beyond_a_limit_is_in_violation_from_the_start(beyond, axis):
    velocity = [limit + more for limit, more in zip((1.0, 1.5), beyond, strict=True)]
    tasks = tasks_of("pid", 1, f"initial.velocity = {velocity}")
    (watched,) = run_logged(tasks, lambda _, rows, watched: watched)
    at, which = watched.first_violation or (1.0, None)

    assert (which if at == 0.0 else None) == axis
