"""The Python interface: scenario -> Systems -> compiled kernels -> Run.

>>> from wmr_ctrl import simulate
>>> run = simulate("paper-simulation", "nn", seed=3)
>>> print(run.outcome)
completed
>>> bool(abs(run["v1"]).max() < 1.0)
True
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

from wmr_ctrl.control.given import law_of, scenario_of
from wmr_ctrl.control.laws.given import law_if_any, law_name, law_names
from wmr_ctrl.core.errors import UnknownNameError
from wmr_ctrl.core.fields.arguments import checks_arguments
from wmr_ctrl.export import api_types as types
from wmr_ctrl.results import Run
from wmr_ctrl.results import load_run as load_run
from wmr_ctrl.simulation.campaign.study_run import study as study
from wmr_ctrl.simulation.many import checked_seeds, checked_starts
from wmr_ctrl.simulation.runnable import versions
from wmr_ctrl.world.scenario import Scenario

if TYPE_CHECKING:
    from types import ModuleType

    from wmr_ctrl.report.report_page import Facts
    from wmr_ctrl.report.write import Verdicts
    from wmr_ctrl.results import RunTable
    from wmr_ctrl.results.ledger import Entry, Ledger
    from wmr_ctrl.simulation.campaign.against_run import AgainstRun
    from wmr_ctrl.simulation.compiled_law import CompiledLaw
    from wmr_ctrl.theory.linear import LinearReport

ENGINES = ("native", "numpy", "fmu")


@checks_arguments
def simulate(
    scenario: str | Path | Scenario,
    law: types.LawGiven | None = None,
    *,
    seed: int = 0,
    engine: str = "native",
    plant: str = "ode",
    guard: bool | None = None,
    overrides: types.Overrides | None = None,
    progress: types.Progress | None = None,
) -> Run:
    """Run ``law`` (a name, a file with LAW, or a Law) on ``scenario`` and return the Run.

    ``law`` None is the scenario's own, else kanayama.  ``engine`` is "native" (compiled C), "numpy"
    (the same graphs without a compiler, slower) or "fmu" (our own FMUs of reference, controller and
    plant, coupled in order); ``plant`` is "ode" (the paper's plane model) or "mujoco" (a rigid body
    on tyres, [body] of the scenario: extra physics, engine native); ``guard`` switches the velocity
    guard on or off (None: as the scenario says).  A run that breaks the velocity limit, diverges or
    becomes non-finite is returned with that outcome.  Raises UnknownNameError, ScenarioError,
    ArgumentError (seed) or CompilerError.

    >>> run = simulate("paper-simulation-nominal", "pid", overrides={"clock.duration": 5.0})
    >>> print(run.outcome)
    limit-violated
    >>> run.time.shape, run["v_c0"].shape, run.signal("v_c0").unit
    ((500,), (500, 2), 'm/s, rad/s')
    """
    from wmr_ctrl.simulation.engines import check_plant, run_compiled, run_numpy, runnable

    chosen, law = _chosen(scenario, law, overrides, guard)
    checked_seeds([seed])
    check_plant(plant, engine)
    if plant == "mujoco":
        from wmr_ctrl.simulation.physics.run import run_rigid

        return run_rigid(runnable(chosen, law, plant), seed, progress)
    if engine == "native":
        return run_compiled(chosen, law, seed)
    if engine == "numpy":
        return run_numpy(chosen, law, seed, progress)
    if engine == "fmu":
        return cosimulate(chosen, law, seed=seed, progress=progress)
    raise UnknownNameError("engine", engine, ENGINES)


@checks_arguments
def simulate_runs(
    scenario: str | Path | Scenario,
    law: types.LawGiven | None = None,
    seeds: Iterable[int] = range(20),
    *,
    plant: str = "ode",
    guard: bool | None = None,
    overrides: types.Overrides | None = None,
    jobs: int | None = None,
    progress: types.Progress | None = None,
    device: str = "cpu",
) -> list[Run]:
    """One complete Run per seed, computed several at a time on each core.

    The results equal those of `simulate` bit for bit, for any number of ``jobs`` (threads, or
    processes for the ``plant`` "mujoco"; default: one per core), any vector instructions, and on a
    graphics processor (``device`` "gpu": CUDA, extra gpu).  `simulate_many` returns only figures
    and needs no memory for logs.  ``progress`` is called with the completed share.  Raises the
    errors of `simulate`, and DeviceError.

    >>> runs = simulate_runs("paper-simulation", "mb", range(3), overrides={"clock.duration": 5.0})
    >>> [run.monitor.violations for run in runs]
    [0, 0, 0]
    """
    from wmr_ctrl.simulation.engines import check_device, runs_of

    check_device(device, plant)
    chosen, law = _chosen(scenario, law, overrides, guard)
    return runs_of(plant, chosen, law, checked_seeds(seeds), jobs, progress, device)


def _chosen(
    scenario: str | Path | Scenario,
    law: types.LawGiven | None,
    overrides: types.Overrides | None = None,
    guard: bool | None = None,
) -> tuple[Scenario, str]:
    """The scenario and the law's name; a law is read first, so that a scenario may name it."""
    named = law_if_any(law)
    chosen = scenario_of(scenario, overrides, guard)
    return chosen, law_of(chosen, named)


@checks_arguments
def simulate_many(
    scenario: str | Path | Scenario,
    law: types.LawGiven | None = None,
    seeds: Iterable[int] = range(20),
    overrides: types.Overrides | Sequence[types.Overrides] | None = None,
    *,
    plant: str = "ode",
    guard: bool | None = None,
    starts: Iterable[Iterable[float]] | None = None,
    figures: Iterable[str] = (),
    jobs: int | None = None,
    progress: types.Progress | None = None,
    device: str = "cpu",
) -> RunTable:
    """Figures of one run per seed as arrays, computed for several runs at a time on each core.

    ``overrides`` is one mapping for all runs, or one per seed; ``starts`` (n, 5) are the states at
    t = 0 in the scenario's ``frames``: x, y [m], theta [rad], v1 [m/s], omega [rad/s].
    ``figures`` names further figures of the catalogue, including those of other packages.
    With ``plant`` "mujoco", the rigid body, ``jobs`` are processes, and the table also has slip,
    wheel speed, tilt and tip margin.  Results depend neither on ``jobs`` nor on ``device``, as in
    `simulate_runs`.  Ctrl-C ends all threads within one sample, and processes at once.  Raises the
    same errors.

    >>> table = simulate_many("paper-simulation", "mb", range(3), {"clock.duration": 5.0})
    >>> table["violations"]
    array([0., 0., 0.])
    """
    from wmr_ctrl.simulation.engines import check_device, table_of

    listed, law = checked_seeds(seeds), law_if_any(law)
    check_device(device, plant)
    if progress:
        progress(0.0)
    each = [overrides] if overrides is None or isinstance(overrides, Mapping) else overrides
    scenarios = [scenario_of(scenario, item, guard) for item in each]
    rows = None if starts is None else checked_starts(starts, scenarios)
    own = law_of(scenarios[0] if scenarios else scenario_of(scenario), law)
    return table_of(plant, scenarios, own, listed, rows, tuple(figures), jobs, progress, device)


@checks_arguments
def reproduce(
    out: str | Path = "reproduction",
    *,
    seeds: int = 20,
    quick: bool = False,
    jobs: int | None = None,
    progress: types.Progress | None = None,
    with_ours: bool = False,
    with_physics: bool = False,
) -> Verdicts:
    """Rerun Sections V and VI of the paper and write the report into the folder ``out``.

    ``quick`` uses 3 seeds.  ``with_ours`` also compares all laws, including ours, with and without
    the guard (about a minute: ours.csv, figures); ``with_physics`` the plane model with the rigid
    body (some minutes: rigid.csv).  ``.as_expected`` of the result is True if the verdicts equal
    the committed ones.  Raises ArgumentError, ResultFileError (``out``) and MissingExtraError
    (physics) before the first run.
    """
    from wmr_ctrl.report.paper_claims import Evidence, judge_all
    from wmr_ctrl.report.report_page import Reproduction
    from wmr_ctrl.report.write import FILES, write_reproduction
    from wmr_ctrl.results import check_writable, new_folder
    from wmr_ctrl.simulation.batch import check_jobs
    from wmr_ctrl.simulation.campaign import PAPER_LAWS
    from wmr_ctrl.simulation.campaign.engine import run_campaign
    from wmr_ctrl.simulation.campaign.paper_runs import QUICK_SEEDS, paper_plan
    from wmr_ctrl.simulation.many import part
    from wmr_ctrl.simulation.physics.rigid import mujoco

    plan = paper_plan(PAPER_LAWS, QUICK_SEEDS if quick else seeds)
    check_jobs(jobs)
    wanted = [what for what, on in (("ours", with_ours), ("physics", with_physics)) if on]
    more = [name for what in wanted for name in _benchmark("beyond").FILES[what]]
    if with_physics:
        mujoco()
    with new_folder(Path(out)):
        for name in (*FILES, *more):
            check_writable(Path(out) / name)
        facts = _facts(PAPER_LAWS, quick)
        parts = 2 + len(wanted)
        each = [part(progress, k / parts, (k + 1) / parts) for k in range(parts)]
        campaign = run_campaign(plan, jobs, each[0])
        judged = judge_all(Evidence(campaign.table, facts.timings))
        drawings = _benchmark("paper_figures").all_drawings(campaign)
        verdicts = write_reproduction(out, Reproduction(campaign, judged, facts), drawings, each[1])
        for what, tell in zip(wanted, each[2:], strict=True):
            _benchmark("beyond").run(what, Path(out), jobs, quick, tell)
    return verdicts


def _facts(laws: Sequence[str], quick: bool) -> Facts:
    """Titles, times, versions, and whether the graphs are the ledger's (not if ``quick``)."""
    from wmr_ctrl.report.report_page import Facts
    from wmr_ctrl.simulation.compiled_law import ROUNDS, seconds_of
    from wmr_ctrl.theory.door import is_open, proofs

    return Facts(
        titles={row["name"]: row["title"] for row in law_table()},
        timings={law: seconds_of(compile_law(law)) for law in laws},
        rounds=ROUNDS,
        versions=versions(),
        stale=proofs("runner").stale_entries() if is_open() and not quick else None,
    )


@checks_arguments
def export_fmu(what: types.LawGiven, **options: Unpack[types.ExportOptions]) -> list[Path]:
    """Write FMUs, or files for other simulation tools, and return their paths.

    Options as in `wmr_ctrl.export.fmi.fmu_files.export_fmu`: law, scenario, fmi, target, out.
    ``what`` = "ssp" writes an SSP package, which also takes a foreign ``plant`` and ``controller``
    with a ``map_file``, ``delay_known`` and ``flat``; "modelica" writes the package WheeledRobot.mo
    with every law (options scenario and out); "simulink" writes the kit for ``law``.
    """
    from wmr_ctrl.export.outputs import write_output

    if (law := options.get("law")) is not None:
        options["law"] = law_name(law)
    return write_output(law_name(what), options)


@checks_arguments
def write_page(
    out: str | Path,
    scenario: str | Path | Scenario = "paper-simulation",
    **options: Unpack[types.PageOptions],
) -> Path:
    """Write one HTML file that runs the loop live; options of `wmr_ctrl.export.page.write_page`."""
    if (laws := options.get("laws")) is not None:
        options["laws"] = law_names(laws)
    return import_module("wmr_ctrl.export.page").write_page(out, scenario_of(scenario), **options)


@checks_arguments
def cosimulate(
    scenario: str | Path | Scenario,
    law: types.LawGiven | None = None,
    **options: Unpack[types.CosimulationOptions],
) -> Run:
    """Run reference, controller and plant as FMUs; options as in `wmr_ctrl.export.cosim`."""
    from wmr_ctrl.export.cosim import cosimulate as run_fmus

    name = law_if_any(law)
    return run_fmus(scenario, name, **options)


@checks_arguments
def linearize(
    scenario: str | Path | Scenario,
    law: types.LawGiven | None = None,
    at: float | None = None,
    guard: bool = False,
) -> LinearReport:
    """Poles, margins and limits at time ``at`` [s].

    ``law``: as in `simulate`.  With ``guard``, a point at which the guard acts is refused.
    """
    from wmr_ctrl.theory.linear import report_linear

    return report_linear(*_chosen(scenario, law), at, guard=guard)


@checks_arguments
def linear_against_run(
    scenario: str | Path | Scenario,
    laws: Sequence[types.LawGiven] | None = None,
    *,
    guard: bool | None = None,
    overrides: types.Overrides | None = None,
    jobs: int | None = None,
    progress: types.Progress | None = None,
) -> AgainstRun:
    """Compare the linear loop with compiled runs: start sizes at which they differ by 1 % and 10 %.

    For each law (as in `simulate`) and direction, over 20 s or the whole run if that is shorter;
    docs/linear.md says how it is measured. `.plot(path)` draws both responses. Raises ArgumentError
    if the run leaves its reference by itself.

    >>> found = linear_against_run("paper-simulation-nominal", ["mb"])
    >>> round(found.laws["mb"].directions["ahead"].one_per_cent, 3)  # m
    0.083
    """
    from wmr_ctrl.simulation.campaign.against_run import against_run
    from wmr_ctrl.simulation.engines import runnable

    chosen = scenario_of(scenario, overrides, guard)
    names = tuple(law_names(laws)) if laws else (law_of(chosen, None),)
    return against_run(runnable, chosen, names, jobs, progress)


@checks_arguments
def prove(
    only: Iterable[str] = (), progress: Callable[[float, Entry], None] | None = None
) -> Ledger:
    """Check the ledger's entries by machine; ``progress(share, entry)`` is called after each.

    Raises MissingExtraError without the extra proofs, UnknownNameError for an unknown entry.
    """
    from wmr_ctrl.theory.door import proofs

    ledger: Ledger = proofs().prove(tuple(only), progress)
    return ledger


def bench(progress: types.Progress | None = None) -> types.BenchReport:
    """Measure the generated code against hand-written C, NumPy and CasADi (about a minute)."""
    module = _benchmark("bench")
    measured: types.Measurements = module.run_bench(progress)
    return {**measured, "text": module.table(measured)}


def _benchmark(name: str) -> ModuleType:
    installed = find_spec("wmr_ctrl._benchmarks")  # in a checkout they lie beside wmr_ctrl
    return import_module(f"wmr_ctrl._benchmarks.{name}" if installed else f"benchmarks.{name}")


@checks_arguments
def compile_law(
    law: types.LawGiven, scenario: str | Path | Scenario = "paper-simulation"
) -> CompiledLaw:
    """The law's compiled controller, to be called sample by sample.

    Write ``u`` (order: ``inputs``), call ``step()``, read the torques (or v, omega).  Raises
    UnknownNameError, ScenarioError or CompilerError; ``step()`` raises ArgumentError for bad input.

    >>> law = compile_law("mb")
    >>> law.u[:] = [0, 0, -1.57, 0.2, 0.1, 0, 0, -0.5, -0.5, -0.7, 0, 0]
    >>> right, left = law.step()
    >>> bool(left > right)  # the target is to the right
    True
    """
    from wmr_ctrl.codegen.build import build_law
    from wmr_ctrl.control.setup import settle
    from wmr_ctrl.simulation.compiled_law import CompiledLaw

    name = law_name(law)
    return CompiledLaw(build_law(settle(scenario_of(scenario), name)))


def law_table() -> list[dict[str, str]]:
    """Name and title of every law in the registry."""
    from wmr_ctrl.control.laws import LAWS

    return [{"name": name, "title": LAWS[name].title} for name in LAWS]
