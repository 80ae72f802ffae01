"""Studies of a user: a plan, a folder, an executor, a worker; and both plants side by side."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from concurrent.futures import Executor, ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from wmr_ctrl import __version__
from wmr_ctrl.campaign.engine import PhaseProgress
from wmr_ctrl.fields.arguments import checks_arguments

if TYPE_CHECKING:
    import numpy as np

    from wmr_ctrl.campaign.engine import Overrides, Prepare
    from wmr_ctrl.campaign.rigid import RigidComparison
    from wmr_ctrl.campaign.study_plan import StudyPlan
    from wmr_ctrl.campaign.study_rows import StudyChunk, TakeColumns
    from wmr_ctrl.campaign.study_run import StudyOutcome
    from wmr_ctrl.scenario import Scenario
    from wmr_ctrl.sim.ready import Ready


@checks_arguments
def study(
    plan: str | Path | Mapping[str, object] | StudyPlan,
    out: str | Path,
    *,
    executor: str | Executor = "threads",
    jobs: int | None = None,
    progress: PhaseProgress | None = None,
) -> StudyOutcome:
    """Run a plan (a TOML file, its tables, or a StudyPlan) and write ``out``/table.csv.

    ``executor``: "threads" of this process, "dask" for processes of this machine, a Dask scheduler
    as "dask://HOST:PORT", or any `concurrent.futures` executor; ``jobs``: threads or processes.
    The table has the same bytes for all of them, and however often the study was interrupted:
    called again, it makes what is missing.  A plan with the plant "mujoco" has its runs made by
    processes in the place of threads, and needs the extra physics.  Raises ArgumentError,
    UnknownNameError, ScenarioError, ResultFileError, MissingExtraError or CompilerError; what is
    finished stays.
    """
    from wmr_ctrl.campaign.executors import executor_named
    from wmr_ctrl.campaign.study_plan import load_plan, plan_of
    from wmr_ctrl.campaign.study_run import run_study
    from wmr_ctrl.sim.batch import check_jobs

    check_jobs(jobs)
    if isinstance(plan, str | Path):
        plan = load_plan(plan)
    chosen = plan_of(plan) if isinstance(plan, Mapping) else plan
    if chosen.plant == "mujoco":
        _check_body(chosen.scenario)
    facts = partial(study_facts, chosen.scenario, chosen.laws, chosen.plant)
    prepare = _prepare_on(chosen.plant)
    with ThreadPoolExecutor(1) as beside:
        known = beside.submit(facts)  # while processes start
        with executor_named(executor, jobs, known.result, facts, prepare) as running:
            made_by = known.result()
            return run_study(chosen, Path(out), study_rows, made_by, running, jobs, progress)


def study_rows(chunk: StudyChunk, jobs: int | None) -> dict[str, np.ndarray]:
    """Outcome and figures of a chunk's runs: what an executor's worker calls."""
    from wmr_ctrl.campaign.study_rows import chunk_rows

    return chunk_rows(chunk, _prepare_on(chunk.plant), _take_on(chunk.plant), jobs)


def _take_on(plant: str) -> TakeColumns:
    """What takes the figures of runs on that plant."""
    from wmr_ctrl.campaign.study_rows import take_in_lanes, take_on_tyres
    from wmr_ctrl.sim.many import run_each

    if plant == "ode":
        return partial(take_in_lanes, run_each)
    from wmr_ctrl.physics.many import rigid_rows

    return partial(take_on_tyres, rigid_rows)


def _prepare_on(plant: str) -> Prepare:
    """What compiles a case for that plant."""
    return prepare_case if plant == "ode" else _prepare_plantless


def _check_body(scenario: Scenario) -> None:
    """Raise MissingExtraError, or ScenarioError for what no rigid body is."""
    from wmr_ctrl.physics.description import description
    from wmr_ctrl.physics.rigid import mujoco

    mujoco()
    description(scenario)


def prepare_case(
    scenario: str | Scenario,
    law: str,
    overrides: Overrides | None = None,
    guard: bool | None = None,
) -> Ready:
    """The compiled loop of a case.  Raises as `wmr_ctrl.api.compile_loop` does."""
    from wmr_ctrl.engines import ready_batch

    return ready_batch(_scenario_of(scenario, overrides, guard), law)


def rigid_comparison(
    quick: bool = False, jobs: int | None = None, progress: PhaseProgress | None = None
) -> RigidComparison:
    """The laws on the plane model and on the rigid body; one seed if ``quick``.

    Raises MissingExtraError without the extra physics.
    """
    from wmr_ctrl.campaign.rigid import RIGID_SEEDS, run_rigid_comparison
    from wmr_ctrl.physics.run import run_rigid_then
    from wmr_ctrl.sim.many import run_each

    engines = {"ode": (run_each, prepare_case), "mujoco": (run_rigid_then, _prepare_plantless)}
    seeds = RIGID_SEEDS[: 1 if quick else None]
    return run_rigid_comparison(engines, seeds, jobs=jobs, progress=progress)


def _prepare_plantless(
    scenario: str | Scenario,
    law: str,
    overrides: Overrides | None = None,
    guard: bool | None = None,
) -> Ready:
    from wmr_ctrl.engines import ready_plantless

    return ready_plantless(_scenario_of(scenario, overrides, guard), law)


def _scenario_of(
    scenario: str | Scenario, overrides: Overrides | None, guard: bool | None
) -> Scenario:
    from wmr_ctrl.scenario import load_scenario, override

    switch = {} if guard is None else {"guard.enabled": guard}
    base = load_scenario(scenario) if isinstance(scenario, str) else scenario
    changed = {**(overrides or {}), **switch}
    return override(base, changed) if changed else base


def study_facts(scenario: Scenario, laws: tuple[str, ...], plant: str = "ode") -> dict[str, str]:
    """What decides a result besides the plan: the version, and the code of the plan's laws.

    The laws' loops without guard are compiled for it, here or on the worker that is asked, so that
    a kind of machine does so before its first chunk.
    """
    prepare = _prepare_on(plant)
    digests = [prepare(scenario, law, None, False).compiled.digest for law in laws]
    code = hashlib.sha256(" ".join(digests).encode()).hexdigest()[:16]
    return {"version": __version__, "kernels": code, **_engine_facts(plant)}


def _engine_facts(plant: str) -> dict[str, str]:
    """The version of the rigid body's engine, where it is asked for."""
    if plant == "ode":
        return {}
    from wmr_ctrl.physics.rigid import mujoco

    return {"mujoco": str(mujoco().__version__)}
