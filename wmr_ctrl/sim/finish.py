"""What an engine found becomes a Run, with its settings and provenance."""

from __future__ import annotations

import hashlib
import operator
import platform
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import lru_cache
from itertools import islice
from typing import SupportsIndex

import numpy as np

from wmr_ctrl import __version__
from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.fields.limits import MOST_SEEDS, SEED_END
from wmr_ctrl.fields.problems import show
from wmr_ctrl.results import (
    Assumptions,
    Monitor,
    Run,
    Settings,
    first_beyond,
    largest_push,
    outcome_of,
)
from wmr_ctrl.scenario import Scenario, to_toml
from wmr_ctrl.signals import Signal

COUNTED = ("dbar", "void", "usable", "asked", "M_min", "M_max", "nbar", "alpha")
"""What of `Assumptions` a run's settings keep."""
Log = tuple[tuple[Signal, ...], Mapping[str, np.ndarray], Monitor]
"""Signals, columns and monitor, as an engine leaves them."""


def assemble_run(
    scenario: Scenario,
    law: str,
    seed: int,
    engine: str,
    log: Log,
    facts: Mapping[str, str],
    bounds: Assumptions | None = None,
    plant: str = "ode",
) -> Run:
    """The Run of what an engine found.

    ``bounds`` are what a guard assumes, be it on or off: largest disturbance and largest force
    [N, N m]; with them the monitor tells the first motion that contradicts them, and how near the
    least disturbance came.  ``plant``: which of `Settings` it was.
    """
    signals, columns, seen = log
    monitor, guard = seen, scenario.guard.enabled
    settings = replace(settings_of(scenario), plant_kind=plant)
    if bounds is not None:
        left, least = first_beyond(columns, bounds), largest_push(columns)
        monitor = replace(seen, bounds_left=left, d_least=least)
        known = {name: getattr(bounds, name) for name in COUNTED}
        settings = replace(settings, **known)
    return Run(
        scenario.name, law, guard, seed, engine, settings, signals, columns, monitor,
        outcome_of(monitor, guard), {**provenance(scenario), **facts},
    )  # fmt: skip


def settings_of(scenario: Scenario) -> Settings:
    """Clocks, limits and windows of a scenario."""
    clock, metrics = scenario.clock, scenario.metrics
    return Settings(
        clock.control, clock.plant, clock.duration, scenario.limits.v_u1, scenario.split,
        metrics.rms_from, tolerance=metrics.tolerance, arrival=scenario.reference.arrival,
    )  # fmt: skip


@lru_cache(maxsize=64)
def provenance(scenario: Scenario) -> Mapping[str, str]:
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


def checked_seeds(seeds: Iterable[int]) -> list[int]:
    """The seeds; raises ArgumentError unless they are `MOST_SEEDS` whole numbers below SEED_END."""
    listed = list(islice(seeds, MOST_SEEDS + 1))
    if len(listed) > MOST_SEEDS:
        raise ArgumentError(f"there are more than {MOST_SEEDS} seeds. Give them in parts.")
    if not listed:
        raise ArgumentError("seeds: there must be at least one.")
    for seed in listed:
        whole = isinstance(seed, SupportsIndex) and not isinstance(seed, bool)
        if not (whole and 0 <= operator.index(seed) < SEED_END):
            raise ArgumentError(
                f"seed = {show(seed)} must be a whole number from 0 up, below {SEED_END}."
            )
    return listed


def checked_starts(starts: Iterable[Iterable[float]]) -> list[tuple[float, ...]]:
    """States at t = 0 as rows of numbers; raises ArgumentError for what is none."""
    try:
        return [tuple(map(float, row)) for row in starts]
    except (TypeError, ValueError):
        raise ArgumentError(
            "starts must hold five numbers a run: x, y [m], theta [rad], v1 [m/s], omega [rad/s]."
        ) from None
