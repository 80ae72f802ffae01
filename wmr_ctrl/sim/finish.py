"""What an engine found becomes a Run, with its settings and provenance."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from wmr_ctrl import __version__
from wmr_ctrl.results import Monitor, Run, Settings, first_beyond, outcome_of
from wmr_ctrl.scenario import Scenario, to_toml
from wmr_ctrl.signals import Signal

Found = tuple[tuple[Signal, ...], Mapping[str, np.ndarray], Monitor]
"""Signals, columns and monitor, as an engine leaves them."""

Pair = tuple[float, float]


def finished(
    scenario: Scenario,
    law: str,
    seed: int,
    engine: str,
    found: Found,
    facts: Mapping[str, str],
    bounds: tuple[Pair, Pair] | None = None,
) -> Run:
    """The Run of what an engine found.

    ``bounds`` are what the guard assumes: largest disturbance and largest force [N, N m]; with
    them the monitor tells the first motion that contradicts them.
    """
    signals, columns, seen = found
    monitor = seen if bounds is None else replace(seen, bounds_left=first_beyond(columns, *bounds))
    return Run(
        scenario.name, law, scenario.guard.enabled, seed, engine, settings_of(scenario), signals,
        columns, monitor, outcome_of(monitor), {**provenance(scenario), **facts},
    )  # fmt: skip


def settings_of(scenario: Scenario) -> Settings:
    """Clocks, limits and windows of a scenario."""
    clock = scenario.clock
    return Settings(
        clock.control, clock.plant, clock.duration, scenario.limits.v_u1, scenario.split,
        scenario.metrics.rms_from,
    )  # fmt: skip


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
    return {
        "version": __version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "machine": platform.machine(),
    }
