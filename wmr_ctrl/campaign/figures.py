"""The catalogue of numbers that a campaign keeps of each run; each is None where a run has none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from wmr_ctrl.errors import UnknownNameError
from wmr_ctrl.results import (
    Run,
    distance,
    e_rms,
    ise,
    position_max,
    position_rms,
    rises,
    settling_time,
    tau_peak,
    tau_rms,
    weight_norm,
    window,
)

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


LATE = (30.0, 40.0)
"""The last seconds before the paper's change of parameters [s]."""


def distance_at_start(run: Run) -> float | None:
    """Distance from the reference at t = 0 [m]."""
    return float(distance(run)[0]) if run.rows else None


def distance_rms(run: Run, start: float, end: float) -> float | None:
    """RMS of the distance from the reference over [start, end) [m]."""
    rows = window(run, start, end)
    if rows is None or rows.start == rows.stop:
        return None
    return float(np.sqrt(np.mean(distance(run)[rows] ** 2)))


def halving_time(run: Run) -> float | None:
    """First sample time at which the distance is at most half of that at the start [s]."""
    gap = distance(run)
    reached = np.flatnonzero(gap <= 0.5 * gap[0]) if run.rows else np.array([])
    return float(run.time[reached[0]]) if reached.size else None


def limit_ratio(run: Run) -> float:
    """Largest |v_i| over its limit v_u1_i, over both axes and every plant step [1]."""
    pairs = zip(run.monitor.max_abs_v, run.settings.v_u1, strict=True)
    return max(value / limit for value, limit in pairs)


def violated(run: Run) -> float:
    """1.0 if a velocity was ever beyond its limit, else 0.0; the mean over runs is their share."""
    return float(run.monitor.violations > 0)


def violations(run: Run) -> float:
    """Number of plant steps beyond a limit."""
    return float(run.monitor.violations)


def first_violation(run: Run) -> float | None:
    """Time of the first violation [s]."""
    event = run.monitor.first_violation
    return None if event is None else event[0]


def barrier_at_start(run: Run) -> float | None:
    """The barrier function V1, Eq. (12), at the first sample."""
    return float(run["V1"][0]) if run.rows else None


def barrier_late(run: Run) -> float | None:
    """Mean of V1 over 30-40 s, divided by V1 at the first sample."""
    rows = window(run, *LATE)
    return None if rows is None else _relative(run, float(np.mean(run["V1"][rows])))


def barrier_rises(run: Run) -> float | None:
    """Number of samples before the split at which V1 is larger than one sample earlier."""
    climb = rises(run, 0.0, run.settings.split)
    return None if climb is None else float(climb.count)


def barrier_rise_share(run: Run) -> float | None:
    """Sum of the rises of V1 before the split, divided by V1 at the first sample."""
    climb = rises(run, 0.0, run.settings.split)
    return None if climb is None else _relative(run, climb.total)


def weights(run: Run, axis: int, when: str) -> float | None:
    """Norm of the network's weights of an axis (0 or 1), at the ``end`` or its ``largest``."""
    norm = weight_norm(run)
    if norm is None:
        return None
    return (norm.end if when == "end" else norm.largest)[axis]


def _relative(run: Run, value: float) -> float | None:
    start = barrier_at_start(run)
    return value / start if start else None


def _ise_orientation(run: Run) -> float | None:
    parts = ise(run)
    total, position = parts["total"], parts["position"]
    return None if total is None or position is None else total - position


def _position_rms(key: str, run: Run) -> float | None:
    return position_rms(run)[key]


def _ise(key: str, run: Run) -> float | None:
    return ise(run)[key]


def _e_rms(axis: int, between: tuple[int, int], run: Run) -> float | None:
    errors = e_rms(run, *between)
    return None if errors is None else errors[axis]


def _max_abs(axis: int, run: Run) -> float:
    return run.monitor.max_abs_v[axis]


_POSITION = (
    Figure("position_rms", "m", "RMS of the distance from the reference, whole run",
           partial(_position_rms, "all")),
    Figure("position_rms_last_quarter", "m", "RMS of the distance over the last quarter",
           partial(_position_rms, "last_quarter")),
    Figure("position_max", "m", "largest distance over the last quarter", position_max),
)  # fmt: skip
_MIXED = "m2.s + rad2.s"
_ISE = (
    Figure("ise_total", _MIXED, "ISE over the whole run", partial(_ise, "total")),
    Figure("ise_before", _MIXED, "ISE up to the split (40 s)", partial(_ise, "before")),
    Figure("ise_after", _MIXED, "ISE from the split on", partial(_ise, "after")),
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
    Figure("d_start", "m", "distance from the reference at the start", distance_at_start),
    *(
        Figure(f"d_rms_{a}_{b}", "m", f"RMS of the distance over {a}-{b} s",
               partial(distance_rms, start=a, end=b))
        for a, b in WINDOWS
    ),
    Figure("halving_time", "s", "first time at half the start's distance", halving_time),
    Figure("settling_time", "s", "time after which the distance stays within 0.1 m",
           partial(settling_time, within=0.1)),
)  # fmt: skip
_LIMITS = (
    Figure("max_abs_v1", "m/s", "largest |v1|", partial(_max_abs, 0)),
    Figure("max_abs_omega", "rad/s", "largest |omega|", partial(_max_abs, 1)),
    Figure("limit_ratio", "1", "largest |v_i|/v_u1_i over both axes", limit_ratio),
    Figure("violated", "1", "1 if a limit was broken, else 0", violated),
    Figure("violations", "1", "plant steps beyond a limit", violations),
    Figure("first_violation", "s", "time of the first violation", first_violation),
)
_TORQUES = (
    Figure("tau_peak", "N.m", "largest commanded wheel torque", tau_peak),
    Figure("tau_peak_late", "N.m", "largest commanded wheel torque from 2 s on",
           partial(tau_peak, start=2.0)),
    Figure("tau_rms", "N.m", "RMS of the wheel torques from 2 s on", tau_rms),
)  # fmt: skip
_BARRIER = (
    Figure("V1_start", "1", "V1 at the start", barrier_at_start),
    Figure("V1_late", "1", "mean of V1 over 30-40 s, relative to its start", barrier_late),
    Figure("V1_rises", "1", "number of samples before the split at which V1 rose",
           barrier_rises),
    Figure("V1_rise_share", "1", "sum of these rises, relative to V1 at the start",
           barrier_rise_share),
)  # fmt: skip
_WEIGHTS = tuple(
    Figure(f"W{axis + 1}_{when}", "1", f"norm of the weights of axis {axis + 1}, {text}",
           partial(weights, axis=axis, when=when))
    for axis in (0, 1)
    for when, text in (("end", "last sample"), ("largest", "largest"))
)  # fmt: skip

FIGURES: tuple[Figure, ...] = (
    *_POSITION, *_DISTANCES, *_ISE, *_ERRORS, *_LIMITS, *_TORQUES, *_BARRIER, *_WEIGHTS,
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
