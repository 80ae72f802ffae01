"""What a run is told by: identity, outcome and figures, as ``wmr-ctrl run --json`` prints them."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

import numpy as np

from wmr_ctrl.results.figures import FIGURES, values_of
from wmr_ctrl.results.metrics import e_rms, ise, tau_peak, tau_rms
from wmr_ctrl.results.plain import json_safe
from wmr_ctrl.results.tracking import (
    arrival,
    guard_share,
    position_max,
    position_rms,
    saturated_share,
    torque_change_rms,
    torque_needed_rms,
    tracked,
    tracking,
)
from wmr_ctrl.results.windows import WINDOWS

if TYPE_CHECKING:
    from wmr_ctrl.results.run import Run

PROVENANCE = ("version", "scenario_hash", "kernel_hash")
"""The keys of a run's provenance that the summary repeats."""
COUNTED = ("M_min", "M_max", "dbar", "nbar", "alpha")
"""What it repeats of the numbers that a guard counts on."""
COUPLED = ("master", "delay", "fmu_reference", "fmu_controller", "fmu_guard", "fmu_plant")
"""Those that it repeats of a run that coupled FMUs: who stepped, and names and hashes of files."""


@np.errstate(over="ignore", invalid="ignore")
def summary(run: Run) -> dict[str, object]:
    """The run's identity, outcome and figures, as ``wmr-ctrl run --json`` prints them.

    Plain Python values only; None stands for a window that the run did not cover and for a number
    that is not finite.
    """
    figures = {
        "scenario": run.scenario,
        "law": run.law,
        "guard": counted_on(run),
        "seed": run.seed,
        "engine": run.engine,
        "plant": run.settings.plant_kind,
        "outcome": run.outcome.value,
        "ise": ise(run),
        "position_rms": position_rms(run),
        "position_max": position_max(run),
        "tracking": tracking(run),
        "tracked": tracked(run),
        "arrival": arrival(run),
        "guard_share": guard_share(run),
        "usable_speed": run.settings.usable,
        "reference_speed": run.settings.asked,
        "torque_change_rms": torque_change_rms(run),
        "torque_needed_rms": torque_needed_rms(run),
        "saturated_share": saturated_share(run),
        "max_abs_v": run.monitor.max_abs_v,
        "violations": run.monitor.violations,
        "rigid": None if run.monitor.rigid is None else asdict(run.monitor.rigid),
        "d_least": run.monitor.d_least,
        "dbar": run.settings.dbar,
        "tau_peak": tau_peak(run),
        "tau_rms": tau_rms(run),
        "e_rms": {f"{start}-{end}": e_rms(run, start, end) for start, end in WINDOWS},
        "figures": values_of(run, FIGURES.plugins),
        "remarks": [asdict(item) for item in run.remarks],
        "provenance": {key: run.provenance.get(key) for key in PROVENANCE}
        | {key: run.provenance[key] for key in COUPLED if key in run.provenance},
    }
    return {key: json_safe(value) for key, value in figures.items()}


def counted_on(run: Run) -> dict[str, object] | None:
    """What a guarded run's guard counted on, in SI units as in `Settings`; None without guard."""
    return {name: getattr(run.settings, name) for name in COUNTED} if run.guard else None
