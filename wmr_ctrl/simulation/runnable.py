"""A compiled loop that is ready to run, and the Run from an engine's results."""

import platform
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property, lru_cache

import numpy as np

from wmr_ctrl.core.compiled import CompiledLoop
from wmr_ctrl.core.fields.orientation import ORIENTATIONS, PAPER, described, outward
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.results import Assumptions, Monitor, Run, Settings, outcome_of
from wmr_ctrl.results.settings import CountedNumbers, first_beyond, largest_push
from wmr_ctrl.version import __version__
from wmr_ctrl.world.phases import robots_in_words
from wmr_ctrl.world.scenario import Scenario, scenario_hash, to_toml

Log = tuple[tuple[Signal, ...], Mapping[str, np.ndarray], Monitor]
"""Signals, columns and monitor, as an engine leaves them."""


def assemble_run(
    scenario: Scenario,
    law: str,
    seed: int,
    engine: str,
    log: Log,
    facts: Mapping[str, str],
    bounds: Assumptions,
    plant: str = "ode",
) -> Run:
    """The Run from an engine's results.

    ``bounds`` are the guard's assumptions, whether it is on or off: with them the monitor reports
    the first motion that contradicts them, and how near the least disturbance came; on a base that
    takes velocities there is no such check.  ``plant``: as in `Settings`.
    """
    (signals, columns, seen), guard = log, scenario.guard.enabled
    signals, columns = _stated(signals, columns, scenario.frames)
    least = None if scenario.takes_velocity else largest_push(columns)
    left = first_beyond(columns, bounds)
    monitor = replace(seen, bounds_left=left, d_least=least)
    known = {item.name: getattr(bounds, item.name) for item in fields(CountedNumbers)}
    settings = replace(settings_of(scenario), plant_kind=plant, **known)
    about = scenario.name, law, guard, seed, engine, settings
    outcome, made_by = outcome_of(monitor, guard), {**provenance(scenario), **facts}
    return Run(*about, signals, columns, monitor, outcome, made_by)


def _stated(
    signals: tuple[Signal, ...], columns: Mapping[str, np.ndarray], frames: str
) -> tuple[tuple[Signal, ...], Mapping[str, np.ndarray]]:
    """Signals and columns with orientations converted to ``frames``."""
    if frames == PAPER:
        return signals, columns
    turned = {name: outward(columns[name], frames) for name in ORIENTATIONS if name in columns}
    renamed = (replace(item, meaning=described(item.meaning, frames)) for item in signals)
    return tuple(renamed), {**columns, **turned}


def settings_of(scenario: Scenario) -> Settings:
    """Clocks, limits and windows of a scenario."""
    clock, metrics, limits = scenario.clock, scenario.metrics, scenario.limits
    return Settings(
        clock.control, clock.plant, clock.duration, limits.v_u1, scenario.split,
        metrics.rms_from, tolerance=metrics.tolerance, arrival=scenario.reference.arrival,
        keep_out=scenario.obstacles, radius=scenario.body.radius,
        frames=scenario.frames, robots=robots_in_words(scenario),
        v_min=limits.v_min if limits.apart else None, v_max=limits.v_max if limits.apart else None,
    )  # fmt: skip


@lru_cache(maxsize=64)
def provenance(scenario: Scenario) -> Mapping[str, str]:
    """Provenance of a run: versions, the scenario as TOML and its hash."""
    text = to_toml(scenario, comments=False)
    return {
        **versions(),
        "scenario_hash": scenario_hash(scenario),
        "scenario_toml": text,
    }


def versions() -> dict[str, str]:
    """Versions of the packages that compute."""
    return {
        "version": __version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "machine": platform.machine(),
    }


@dataclass(frozen=True)
class RunnableLoop:
    """A compiled loop, its scenario and law, and the guard's assumptions on the motion."""

    compiled: CompiledLoop
    scenario: Scenario
    law: str
    bounds: Assumptions

    @cached_property
    def settings(self) -> Settings:
        """Clocks, limits and windows of the scenario."""
        return settings_of(self.scenario)
