"""The Python interface: scenario -> Systems -> compiled kernels -> Run.

>>> from wmr_ctrl import simulate
>>> run = simulate("paper-simulation", "nn", seed=3)
>>> print(run.outcome)
completed
>>> bool(abs(run["v1"]).max() < 1.0)
True
"""

from __future__ import annotations

import hashlib
import os
import platform
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from wmr_ctrl.errors import ArgumentError, UnknownNameError
from wmr_ctrl.results import Monitor, Run, Settings, first_beyond, outcome_of
from wmr_ctrl.scenario import Scenario, load_scenario, override, to_toml
from wmr_ctrl.signals import LOG_HEAD, Signal

ENGINES = ("native", "numpy")

START_SAMPLE = (0.0, 0.0, -1.5707963, 0.2, 0.1, 0.0, 0.0, -0.5, -0.5, -0.7, 0.3, -0.4)
"""A sample near the paper's start: reference, pose, velocity."""

Progress = Callable[[float], None]


def scenario_of(
    given: str | Path | Scenario,
    overrides: Mapping[str, Any] | None = None,
    guard: bool | None = None,
) -> Scenario:
    """A checked scenario from a preset's name, a TOML file or a Scenario, with fields overridden.

    ``overrides`` maps key paths to values (``{"clock.control": 0.02}``); ``guard`` switches the
    velocity guard on or off (None: as the scenario says).  Gains and guard are checked too.
    Raises ScenarioError or UnknownNameError, each naming the key.

    >>> scenario_of("far-start", {"robot.mu": 0.1}).robot.mu
    0.1
    """
    from wmr_ctrl.laws.gains import check_gains
    from wmr_ctrl.laws.guard_bounds import settled_guard

    switch = {} if guard is None else {"guard.enabled": guard}
    changed = {**(overrides or {}), **switch}
    loaded = (
        override(given, changed) if isinstance(given, Scenario) else load_scenario(given, changed)
    )
    check_gains(loaded)
    if loaded.guard.enabled:
        settled_guard(loaded, loaded.actuator.tau_max)
    return loaded


def simulate(
    scenario: str | Path | Scenario,
    law: str = "nn",
    *,
    seed: int = 0,
    engine: str = "native",
    guard: bool | None = None,
    overrides: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
) -> Run:
    """Run ``law`` on ``scenario`` and return the Run.

    ``engine`` is "native" (compiled C) or "numpy" (slow, needs no compiler); ``guard`` switches the
    velocity guard on or off (None: as the scenario says).  Leaving the velocity limit, diverging
    or turning non-finite is the Run's outcome, never an exception.  Raises UnknownNameError,
    ScenarioError, ArgumentError (seed) or CompilerError.

    >>> run = simulate("paper-simulation-nominal", "pid", overrides={"clock.duration": 5.0})
    >>> print(run.outcome)
    limit-violated
    >>> run.time.shape, run["v_c0"].shape, run.signal("v_c0").unit
    ((500,), (500, 2), 'm/s, rad/s')
    """
    settled = scenario_of(scenario, overrides, guard)
    _check_seed(seed)
    if engine == "native":
        return _prepared(settled, law)(seed)
    if engine == "numpy":
        return _simulate_numpy(settled, law, seed, progress)
    raise UnknownNameError("engine", engine, ENGINES)


def simulate_many(
    scenario: str | Path | Scenario,
    law: str = "nn",
    seeds: Iterable[int] = range(20),
    *,
    guard: bool | None = None,
    overrides: Mapping[str, Any] | None = None,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> list[Run]:
    """Run ``law`` once per seed, in parallel; the same bits for any number of ``jobs``.

    ``jobs`` is the number of threads (default: one per processor); ``progress`` is called with the
    share that is done.  Errors as in `simulate`.

    >>> runs = simulate_many("paper-simulation", "mb", range(3), overrides={"clock.duration": 5.0})
    >>> [run.monitor.violations for run in runs]
    [0, 0, 0]
    """
    from concurrent.futures import ThreadPoolExecutor

    settled, listed = scenario_of(scenario, overrides, guard), list(seeds)
    for seed in listed:
        _check_seed(seed)
    engine = _prepared(settled, law)
    runs: list[Run] = []
    with ThreadPoolExecutor(jobs or os.cpu_count()) as pool:
        for run in pool.map(engine, listed):
            runs.append(run)
            if progress:
                progress(len(runs) / len(listed))
    return runs


def reproduce(
    out: str | Path = "reproduction",
    *,
    seeds: int = 20,
    quick: bool = False,
    jobs: int | None = None,
    progress: Any = None,
) -> Any:
    """Rerun Sections V and VI of the paper and write the report into the folder ``out``.

    ``quick`` takes 3 seeds.  Returns the verdicts; ``.as_expected`` tells whether they are the
    committed ones.  ``progress`` has ``start(total, text)``, ``advance(n)`` and ``done()``.
    """
    from wmr_ctrl.report.reproduce import reproduce as write_report
    from wmr_ctrl.scenario import preset_names

    engines: dict[tuple[str, str], Callable[[int], Run]] = {}

    def prepare(scenario: str, law: str) -> None:
        engines[scenario, law] = _prepared(scenario_of(scenario), law)

    def run(scenario: str, law: str, seed: int) -> Run:
        return engines[scenario, law](seed)

    titles = {row["name"]: row["title"] for row in law_table()}
    facts = {
        "titles": titles,
        "timings": evaluation_times(),
        "versions": versions(),
        "presets": preset_names(),
    }
    return write_report(
        run,
        prepare,
        seeds=seeds,
        quick=quick,
        jobs=jobs,
        out=Path(out),
        progress=progress,
        facts=facts,
    )


def export_fmu(what: str, **options: Any) -> list[Path]:
    """Write FMUs (or ``what = "ssp"``: the SSP package); returns the files' paths.

    Options as in `wmr_ctrl.fmi.export.export_fmu`: law, scenario, fmi, target, out.
    """
    if what == "ssp":
        from wmr_ctrl.fmi.ssp import export_ssp

        return export_ssp(**{key: item for key, item in options.items() if key != "fmi"})
    from wmr_ctrl.fmi.export import export_fmu as write_fmus

    return write_fmus(what, **options)


def cosimulate(scenario: str | Path | Scenario, law: str = "nn", **options: Any) -> Run:
    """Run reference, controller and plant as FMUs; options as in `wmr_ctrl.fmi.cosim`."""
    from wmr_ctrl.fmi.cosim import cosimulate as run_fmus

    return run_fmus(scenario, law, **options)


def linearize(scenario: str | Path | Scenario, law: str = "nn") -> Any:
    """Poles, margins and sampled-data limits: a `wmr_ctrl.linear.LinearReport`."""
    from wmr_ctrl.linear import report_linear

    return report_linear(scenario_of(scenario), law)


def prove(only: Iterable[str] = (), progress: Any = None) -> Any:
    """Check the paper's equations by machine: a `wmr_ctrl.proofs.ledger.Ledger`."""
    from wmr_ctrl.proofs import prove as check_all

    return check_all(tuple(only), progress)


def bench(progress: Progress | None = None) -> dict[str, Any]:
    """Measure the generated code against hand-written C, NumPy and CasADi's virtual machine.

    Takes about a minute.  Returns ``ratios`` by name, their ``spread`` and ``targets``, ``ns`` per
    step, and the paper's times beside ours; ``text`` is all that as a table.
    """
    module = _benchmarks()
    found = module.run_bench(progress)
    return {**found, "text": module.table(found)}


def _benchmarks() -> Any:
    """The benchmarks: part of the package where it is installed, beside it in a checkout."""
    try:
        return import_module("wmr_ctrl._benchmarks.bench")
    except ModuleNotFoundError:
        sys.path.insert(0, str(Path(__file__).parents[1]))
        return import_module("benchmarks.bench")


def evaluation_times(
    laws: Iterable[str] = ("pid", "smc", "mb", "nn"), count: int = 10_000
) -> dict[str, float]:
    """Seconds that ``count`` evaluations of each law take, called one by one from Python."""
    found = {}
    for law in laws:
        compiled = compile_law(law)
        compiled.u[:] = START_SAMPLE
        begin = time.perf_counter()
        for _ in range(count):
            compiled.step()
        found[law] = time.perf_counter() - begin
    return found


def compile_law(law: str, scenario: str | Path | Scenario = "paper-simulation") -> Any:
    """The law's compiled controller, to be called sample by sample on arrays that stay in place.

    Returns a `wmr_ctrl.sim.compiled_law.CompiledLaw`: write ``u`` (order: ``inputs``), call
    ``step()``, read the torque.  Raises UnknownNameError, ScenarioError or CompilerError.

    >>> law = compile_law("mb")
    >>> law.u[:] = [0, 0, -1.57, 0.2, 0.1, 0, 0, -0.5, -0.5, -0.7, 0, 0]
    >>> right, left = law.step()
    >>> bool(left > right)  # the target is to the right
    True
    """
    from wmr_ctrl.codegen.build import build_loop
    from wmr_ctrl.sim.compiled_law import CompiledLaw

    return CompiledLaw(build_loop(scenario_of(scenario), law))


def law_table() -> list[dict[str, str]]:
    """Name and title of every law in the registry."""
    from wmr_ctrl.laws import LAWS

    return [{"name": name, "title": LAWS[name].title} for name in LAWS]


def _prepared(scenario: Scenario, law: str) -> Callable[[int], Run]:
    """The compiled loop of ``law`` on ``scenario`` as a function of the seed."""
    from wmr_ctrl.codegen.build import build_loop
    from wmr_ctrl.sim.native import columns_of, run_native

    kernels = build_loop(scenario, law)
    signals, facts = columns_of(kernels.manifest), {"kernel_hash": kernels.digest}

    def engine(seed: int) -> Run:
        columns, monitor = run_native(kernels, scenario, seed)
        return run_of(scenario, law, seed, "native", (signals, columns, monitor), facts)

    return engine


def _simulate_numpy(scenario: Scenario, law: str, seed: int, progress: Progress | None) -> Run:
    from wmr_ctrl.laws.controller import controller
    from wmr_ctrl.laws.gains import gains_of, kinematic_gains
    from wmr_ctrl.laws.sample import own_diagnostics
    from wmr_ctrl.sim.oracle import simulate_oracle

    own = {signal.name: signal for signal in own_diagnostics(controller(scenario, law))}
    gains, kinematics = asdict(gains_of(scenario, law)), asdict(kinematic_gains(scenario))
    columns, numbers = simulate_oracle(scenario, law, gains, kinematics, seed, progress)
    signals = (*LOG_HEAD, *(own[name] for name in columns if name in own))
    return run_of(
        scenario, law, seed, "numpy", (signals, columns, Monitor(**numbers)), {"kernel_hash": ""}
    )


def run_of(
    scenario: Scenario,
    law: str,
    seed: int,
    engine: str,
    found: tuple[tuple[Signal, ...], Mapping[str, np.ndarray], Monitor],
    facts: Mapping[str, str],
) -> Run:
    """The Run of what an engine found, with its provenance."""
    signals, columns, seen = found
    monitor = _with_bounds(scenario, law, columns, seen)
    return Run(
        scenario.name, law, scenario.guard.enabled, seed, engine, settings_of(scenario), signals,
        columns, monitor, outcome_of(monitor), {**provenance(scenario), **facts},
    )  # fmt: skip


def _with_bounds(
    scenario: Scenario, law: str, columns: Mapping[str, np.ndarray], monitor: Monitor
) -> Monitor:
    """The monitor with the first motion that contradicts the guard's bounds, if the guard is on."""
    if not scenario.guard.enabled:
        return monitor
    from wmr_ctrl.laws.guard_bounds import settled_guard, torque_limit

    guard = settled_guard(scenario, torque_limit(scenario, law))
    mass, u1, period = guard.M_max or (0.0, 0.0), scenario.limits.v_u1, scenario.clock.control
    largest = (mass[0] * u1[0] / period, mass[1] * u1[1] / period)
    return replace(monitor, bounds_left=first_beyond(columns, guard.dbar or (0.0, 0.0), largest))


def settings_of(scenario: Scenario) -> Settings:
    """Clocks, limits and windows of a scenario."""
    clock, metrics = scenario.clock, scenario.metrics
    split = clock.duration / 2 if metrics.split is None else metrics.split
    return Settings(
        clock.control, clock.plant, clock.duration, scenario.limits.v_u1, split, metrics.rms_from
    )


def provenance(scenario: Scenario) -> dict[str, str]:
    """What made a run: versions, the scenario as TOML and its hash."""
    text = to_toml(scenario, comments=False)
    return {
        **versions(),
        "scenario_hash": hashlib.sha256(text.encode()).hexdigest()[:16],
        "scenario_toml": text,
    }


def versions() -> dict[str, str]:
    """Versions of what computes."""
    from wmr_ctrl import __version__

    return {
        "version": __version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "machine": platform.machine(),
    }


def _check_seed(seed: int) -> None:
    if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed < 2**63:
        raise ArgumentError(f"seed = {seed!r} must be a whole number from 0 up.")
