"""The catalogue of numbers that a campaign keeps of each run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from wmr_ctrl.campaign import measures
from wmr_ctrl.errors import UnknownNameError
from wmr_ctrl.results import Run, e_rms, ise, settling_time, tau_peak, tau_rms

WINDOWS = ((30, 40), (40, 45), (70, 80))
"""Just before, just after and long after the paper's change of parameters [s]."""


@dataclass(frozen=True, slots=True)
class Figure:
    """A number of a run: name, SI unit, meaning, and how to take it (None where it has none)."""

    name: str
    unit: str
    meaning: str
    of: Callable[[Run], float | None]

    @property
    def heading(self) -> str:
        """Name and unit, as columns are headed."""
        return f"{self.name} [{self.unit}]"


def figure_named(name: str) -> Figure:
    """The figure called ``name``; raises UnknownNameError for any other name."""
    for figure in FIGURES:
        if figure.name == name:
            return figure
    raise UnknownNameError("figure", name, (figure.name for figure in FIGURES))


def _ise_orientation(run: Run) -> float | None:
    found = ise(run)
    total, position = found["total"], found["position"]
    return None if total is None or position is None else total - position


def _ise(key: str, run: Run) -> float | None:
    return ise(run)[key]


def _e_rms(axis: int, window: tuple[int, int], run: Run) -> float | None:
    found = e_rms(run, *window)
    return None if found is None else found[axis]


def _max_abs(axis: int, run: Run) -> float:
    return run.monitor.max_abs_v[axis]


_MIXED = "m2.s + rad2.s"
_ISE = (
    Figure("ise_total", _MIXED, "ISE over the whole run", partial(_ise, "total")),
    Figure("ise_before", _MIXED, "ISE up to the change at 40 s", partial(_ise, "before")),
    Figure("ise_after", _MIXED, "ISE from 40 s on", partial(_ise, "after")),
    Figure("ise_position", "m2.s", "ISE of the whole run without theta", partial(_ise, "position")),
    Figure("ise_orientation", "rad2.s", "ISE of the whole run of theta alone", _ise_orientation),
)
_ERRORS = tuple(
    Figure(f"e{axis + 1}_rms_{a}_{b}", unit, f"RMS of e{axis + 1} over {a}-{b} s",
           partial(_e_rms, axis, (a, b)))
    for axis, unit in enumerate(("m", "m", "rad"))
    for a, b in WINDOWS
)  # fmt: skip
_DISTANCES = (
    Figure("d_start", "m", "distance from the reference at the start", measures.distance_at_start),
    *(
        Figure(f"d_rms_{a}_{b}", "m", f"RMS of the distance over {a}-{b} s",
               partial(measures.distance_rms, start=a, end=b))
        for a, b in WINDOWS
    ),
    Figure("halving_time", "s", "first time at half the start's distance", measures.halving_time),
    Figure("settling_time", "s", "time after which the distance stays within 0.1 m",
           partial(settling_time, within=0.1)),
)  # fmt: skip
_LIMITS = (
    Figure("max_abs_v1", "m/s", "largest |v1|", partial(_max_abs, 0)),
    Figure("max_abs_omega", "rad/s", "largest |omega|", partial(_max_abs, 1)),
    Figure("limit_ratio", "1", "largest |v_i|/v_u1_i over both axes", measures.limit_ratio),
    Figure("violated", "1", "1 if a limit was broken, else 0", measures.violated),
    Figure("violations", "1", "plant steps beyond a limit", measures.violations),
    Figure("first_violation", "s", "time of the first violation", measures.first_violation),
)
_TORQUES = (
    Figure("tau_peak", "N.m", "largest commanded wheel torque", tau_peak),
    Figure("tau_peak_late", "N.m", "largest commanded wheel torque from 2 s on",
           partial(tau_peak, start=2.0)),
    Figure("tau_rms", "N.m", "RMS of the wheel torques from 2 s on", tau_rms),
)  # fmt: skip
_BARRIER = (
    Figure("V1_start", "1", "V1 at the start", measures.barrier_at_start),
    Figure("V1_late", "1", "mean of V1 over 30-40 s, relative to its start", measures.barrier_late),
    Figure("V1_rises", "1", "number of samples before the split at which V1 rose",
           measures.barrier_rises),
    Figure("V1_rise_share", "1", "sum of these rises, relative to V1 at the start",
           measures.barrier_rise_share),
)  # fmt: skip
_WEIGHTS = tuple(
    Figure(f"W{axis + 1}_{when}", "1", f"norm of the weights of axis {axis + 1}, {text}",
           partial(measures.weights, axis=axis, when=when))
    for axis in (0, 1)
    for when, text in (("end", "last sample"), ("largest", "largest"))
)  # fmt: skip

FIGURES: tuple[Figure, ...] = (
    *_ISE, *_ERRORS, *_DISTANCES, *_LIMITS, *_TORQUES, *_BARRIER, *_WEIGHTS,
)  # fmt: skip
"""Every figure, in the order of the table's columns."""


@np.errstate(over="ignore", invalid="ignore")
def figures_of(run: Run) -> dict[str, float | None]:
    """All figures of a run by name; None where it has none or where it is not finite."""
    values = {figure.name: figure.of(run) for figure in FIGURES}
    return {
        name: float(value) if value is not None and np.isfinite(value) else None
        for name, value in values.items()
    }
