"""Many native runs of one compiled loop, from many starts."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wmr_ctrl.linear.numbers import Floats
from wmr_ctrl.results import Outcome, outcome_of
from wmr_ctrl.scenario import Initial, Scenario
from wmr_ctrl.sim.native import Kernels, run_native


@dataclass(frozen=True)
class Started:
    """A compiled loop with another start; the library is shared."""

    library: str
    manifest: Mapping[str, Any]


@dataclass(frozen=True)
class Ending:
    """Where a run ended: outcome, distance to the reference [m], largest |v1| and |omega|."""

    outcome: Outcome
    distance: float
    max_abs_v: tuple[float, float]


def endings(
    kernels: Kernels, scenario: Scenario, starts: Iterable[Floats], jobs: int | None = None
) -> list[Ending]:
    """Run the loop once from each start (5: pose and velocity), in parallel threads.

    ``kernels`` come from `wmr_ctrl.codegen.build.build_loop` for this scenario and a law.  The same
    noise (seed 0) acts in all runs.
    """
    with ThreadPoolExecutor(jobs or os.cpu_count()) as pool:
        return list(pool.map(lambda start: _ending(kernels, scenario, start), starts))


def _ending(kernels: Kernels, scenario: Scenario, start: Floats) -> Ending:
    x, y, theta, v1, omega = map(float, start)
    moved = replace(scenario, initial=Initial((x, y, theta), (v1, omega)))
    columns, monitor = run_native(_started(kernels, start), moved, 0)
    last = columns["e"][-1, :2] if len(columns["e"]) else np.array([np.inf, np.inf])
    return Ending(outcome_of(monitor), float(np.hypot(*last)), monitor.max_abs_v)


def _started(kernels: Kernels, start: Floats) -> Started:
    systems = dict(kernels.manifest["systems"])
    systems["plant"] = {**systems["plant"], "start": [float(number) for number in start]}
    return Started(kernels.library, {**kernels.manifest, "systems": systems})
