"""Many runs at once: every lane is the run that the loop of one robot makes."""

import ctypes as ct
import threading
from types import SimpleNamespace

import numpy as np
import pytest

from wmr_ctrl.api import simulate_many
from wmr_ctrl.codegen import build
from wmr_ctrl.codegen.build import vector_sets
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.results import split_columns
from wmr_ctrl.results.windows import windows_of
from wmr_ctrl.simulation.batch import run_logged, run_tasks
from wmr_ctrl.simulation.engines import runnable
from wmr_ctrl.simulation.memory import Task, laid_out
from wmr_ctrl.simulation.memory import vector_sets as usable

SHORT = {"clock.duration": 6.0, "changes": [{"t": 3.0, "m": 65.0, "I": 7.0, "mu": 0.15}]}


def tasks_of(name, law, seeds, overrides, vectors=None):
    loop = runnable(scenario_of(name, overrides), law)
    if vectors and vectors not in names_of(loop.compiled.library):
        pytest.skip(f"NOT RUN: this processor has no {vectors}")
    return [Task(loop, seed, vectors=vectors) for seed in seeds]


def names_of(library):
    return [item.name for item in usable(library)]


def logged(tasks):
    signals = tasks[0].loop.compiled.layout.columns

    def columns(_, rows, watched):
        return split_columns(signals, rows.copy()), watched

    return run_logged(tasks, columns)


def same_bits(one, other):
    return one.shape == other.shape and one.tobytes() == np.ascontiguousarray(other).tobytes()


def same_values(one, other):
    """Texts and numbers alike; not a number is the same as itself."""
    return bool(np.all((one == other) | (one != one) & (other != other)))


@pytest.mark.slow
def test_order_jobs_and_company_do_not_matter():
    """A lane's neighbours, those that diverge among them, leave it alone."""
    wild = tasks_of("paper-simulation", "pid", range(4), {**SHORT, "gains.pid.Kp": [2e4, 2e3]})
    tame = tasks_of("paper-simulation", "pid", range(9), SHORT)
    alone, mixed = run_tasks(tame, jobs=1), run_tasks([*wild[:2], *tame, *wild[2:]], jobs=4)

    assert (mixed["stop"][[0, 1, 11, 12]] == 1).all()
    assert np.isnan(mixed["ise_total"][[0, 1, 11, 12]]).all()
    for name, values in alone.items():
        assert same_values(mixed[name][2:11], values), name
    apart = [run_tasks([task], jobs=1) for task in wild]
    for task, own in zip((0, 1, 11, 12), apart, strict=True):
        assert all(same_values(mixed[k][task], own[k][0]) for k in own)


def test_a_run_that_ended_counts_no_further_while_others_go_on():
    """The guard acts in all samples of a push that throws the robot out, and hardly in others."""
    guard = {**SHORT, "guard.enabled": True, "guard.trust": True, "guard.dbar": [70.0, 15.0]}
    changed = ({**guard, "disturbance.push": [push, 1.0]} for push in (1e6, 1.0))
    tasks = [
        task for item in changed for task in tasks_of("paper-simulation", "pid", range(1), item)
    ]
    together = run_tasks(tasks)

    assert (together["stop"] > 0).tolist() == [True, False]
    for place, task in enumerate(tasks):
        own = run_tasks([task])
        assert [k for k in own if not same_values(together[k][place], own[k][0])] == []


def test_a_batch_that_runs_again_begins_anew():
    tasks = tasks_of("paper-simulation", "mb", range(2), {**SHORT, "actuator.delay": 0.02})
    memory = laid_out(tasks, list(windows_of(tasks[0].loop.settings).values()))
    arrays = memory.findings, memory.state, memory.added
    assert memory.run()
    first = [array.copy() for array in arrays]
    memory.added[:] = 7.0
    assert memory.run()

    assert all(same_bits(one, again) for one, again in zip(first, arrays, strict=True))


@pytest.mark.parametrize("jobs", [0, -1, 1.5, True])
def test_jobs_that_cannot_be_are_named(jobs):
    with pytest.raises(ArgumentError, match="jobs"):
        simulate_many("paper-simulation", "mb", [0], SHORT, jobs=jobs)  # type: ignore[arg-type]


@pytest.mark.parametrize("start", [(0.0, 0.0), (0.0,) * 6, (0.0, np.nan, 0.0, 0.0, 0.0)])
def test_starts_that_cannot_be_are_named(start):
    loop = tasks_of("paper-simulation", "mb", range(1), SHORT)[0].loop
    with pytest.raises(ArgumentError, match="start"):
        Task(loop, 0, start)


def test_an_interrupt_ends_all_threads_at_once():
    tasks = tasks_of("paper-simulation", "nn", range(64), {"clock.duration": 4000.0})
    before = threading.active_count()

    def stop(share):
        raise KeyboardInterrupt

    short = tasks_of("paper-simulation", "nn", range(1), {"clock.duration": 0.1})
    with pytest.raises(KeyboardInterrupt):
        run_tasks([*short, *tasks], jobs=2, progress=stop)

    assert threading.active_count() == before


def test_lanes_that_are_cancelled_do_no_further_sample():
    tasks = tasks_of("paper-simulation", "mb", range(2), SHORT)
    memory = laid_out(tasks, [], cancelled=ct.c_int32(1))

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
    limits = scenario_of("paper-simulation", SHORT).limits.v_u1
    start = [limit + more for limit, more in zip(limits, beyond, strict=True)]
    changed = {**SHORT, "initial.velocity": start}
    ((_, watched),) = logged(tasks_of("paper-simulation", "pid", range(1), changed))
    at, which = watched.first_violation or (1.0, None)

    assert (which if at == 0.0 else None) == axis
