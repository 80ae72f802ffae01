"""Figures of many runs as arrays, from the sums that the lanes' loop leaves behind."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.results import Monitor, Settings
from wmr_ctrl.results.metrics import E_RMS_WINDOWS
from wmr_ctrl.results.monitor import STOP_REASONS
from wmr_ctrl.results.tracking import at_rest, drive, last_quarter, working
from wmr_ctrl.sim.memory import Memory
from wmr_ctrl.sim.ready import Ready

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Figures = dict[str, NDArray[np.float64]]

SHAPES: Mapping[str, tuple[int, ...]] = {
    "ise_total": (), "ise_before": (), "ise_after": (), "ise_position": (),
    "e_rms": (len(E_RMS_WINDOWS), 3), "max_abs_v": (2,), "violations": (),
    "first_violation": (), "first_axis": (), "stop": (), "stopped": (), "stop_axis": (),
    "samples": (), "tau_peak": (), "tau_rms": (), "torque_change_rms": (), "torque_needed_rms": (),
    "saturated_share": (), "position_rms": (2,), "position_max": (), "tracking_drive": (2,),
    "tracking_end": (2,), "final_state": (5,), "d_least": (2,), "bounds_left": (),
    "bounds_axis": (), "guard_share": (2,),
}  # fmt: skip
"""Figure to its shape for one run: ISE as in `results.metrics` [m2 s and rad2 s]; ``e_rms`` by
window of `E_RMS_WINDOWS` [m, m, rad]; ``max_abs_v`` [m/s, rad/s]; ``violations`` (plant steps);
``first_violation`` and ``stopped`` [s], ``first_axis`` and ``stop_axis`` (1, 2); ``stop`` (index
into STOP_REASONS); ``samples`` made; torques [N m], their change and what the motion needs as in
`results.tracking`; ``saturated_share`` of the samples with a wheel at its limit;
``position_rms`` over all and over the last quarter, ``position_max`` over the last quarter [m];
``tracking_drive`` and ``tracking_end``, RMS and largest distance [m]; ``final_state`` x, y [m],
theta [rad],
v1 [m/s], omega [rad/s]; ``d_least`` [N, N m], the largest; ``bounds_left`` [s] and ``bounds_axis``,
the first motion that a guard's bounds do not admit; ``guard_share``, share of samples in which the
guard acted.  NaN where there was no such event or the run ended before its window
did."""


@dataclass(frozen=True, slots=True)
class FigureColumn:
    """One number of a run as a column of a table: its name, unit and meaning, and its place.

    ``figure`` is a name of `SHAPES`, ``index`` the place in its array for one run.
    """

    name: str
    unit: str
    meaning: str
    figure: str
    index: tuple[int, ...] = ()


def _pair(name: str, units: tuple[str, str], meaning: str) -> tuple[FigureColumn, FigureColumn]:
    """Columns of a figure with an axis each, counted from 1."""
    first, second = (
        FigureColumn(f"{name}{axis + 1}", units[axis], f"{meaning}, axis {axis + 1}", name, (axis,))
        for axis in (0, 1)
    )
    return first, second


def _column(name: str, unit: str, meaning: str) -> FigureColumn:
    return FigureColumn(name, unit, meaning, name)


def _tracking(part: str, when: str) -> tuple[FigureColumn, FigureColumn]:
    """RMS and largest distance in a part of the run."""
    first, second = (
        FigureColumn(f"tracking_{part}_{short}", "m", f"{meaning} distance {when}",
                     f"tracking_{part}", (place,))
        for place, (short, meaning) in enumerate((("rms", "RMS"), ("max", "largest")))
    )  # fmt: skip
    return first, second


_MIXED = "m2.s + rad2.s"
COLUMNS: tuple[FigureColumn, ...] = (
    _column("violations", "1", "plant steps beyond a velocity limit"),
    FigureColumn("position_rms", "m", "RMS distance from the desired position, whole run",
                 "position_rms", (0,)),
    FigureColumn("position_rms_last_quarter", "m", "RMS distance over the last quarter",
                 "position_rms", (1,)),
    _column("position_max", "m", "largest distance over the last quarter"),
    *_tracking("drive", "while driving"),
    *_tracking("end", "after arrival"),
    _column("ise_total", _MIXED, "ISE over the whole run"),
    _column("ise_before", _MIXED, "ISE before the split"),
    _column("ise_after", _MIXED, "ISE from the split on"),
    _column("ise_position", "m2.s", "ISE of the position alone"),
    *_pair("max_abs_v", ("m/s", "rad/s"), "largest |v1| or |omega|"),
    _column("first_violation", "s", "time of the first violation"),
    _column("tau_peak", "N.m", "largest commanded wheel torque"),
    _column("tau_rms", "N.m", "RMS of the wheel torques"),
    _column("torque_change_rms", "N.m", "RMS change of the torques from sample to sample"),
    _column("torque_needed_rms", "N.m", "RMS of the torques that the desired motion needs"),
    _column("saturated_share", "1", "share of samples with a wheel at its torque limit"),
    *_pair("guard_share", ("1", "1"), "share of samples in which the guard changed the force"),
    *_pair("d_least", ("N", "N.m"), "largest least disturbance"),
    _column("bounds_left", "s", "first motion that contradicts the guard's bounds"),
    _column("stopped", "s", "time at which a run ended early"),
    *(
        FigureColumn(f"e{axis + 1}_rms_{a}_{b}", unit, f"RMS of e{axis + 1} over {a}-{b} s",
                     "e_rms", (window, axis))
        for axis, unit in enumerate(("m", "m", "rad"))
        for window, (a, b) in enumerate(E_RMS_WINDOWS)
    ),
    *(
        FigureColumn(f"final_{name}", unit, f"{name} at the end", "final_state", (place,))
        for place, (name, unit) in enumerate(
            (("x", "m"), ("y", "m"), ("theta", "rad"), ("v1", "m/s"), ("omega", "rad/s"))
        )
    ),
)  # fmt: skip
"""The figures as columns of one number each, in the order in which tables have them."""

RIGID_COLUMNS: tuple[FigureColumn, ...] = (
    _column("slipped", "s", "first time at which a tread slid by more than body.slip_max"),
    _column("tipped", "s", "time at which the robot had fallen over"),
    _column("max_slip", "m/s", "largest speed of a tread over the ground"),
    _column("max_wheel_speed", "rad/s", "largest speed of a wheel"),
    _column("max_tilt", "rad", "largest lean of the robot's axis"),
    _column("least_tip_margin", "1", "least distance of the load's centre from tipping, 0 to 1"),
)
"""What runs on the rigid body have besides, each a figure of its name and shape ()."""


def column_of(column: FigureColumn, figures: Mapping[str, NDArray[np.float64]]) -> Floats:
    """The numbers of a column, one a run."""
    values = figures[column.figure]
    for place in column.index:
        values = values[:, place]
    return values


class Runnable(Protocol):
    """What is read of a task."""

    @property
    def loop(self) -> Ready:
        """What ran: its clocks and windows."""


def windows_of(settings: Settings) -> list[tuple[int, int]]:
    """Sample windows: all, before and after the split, torque; last quarter, working; the drive
    and the end; errors.
    """
    end, split = settings.samples, settings.index(settings.split)
    errors = [(settings.index(a), settings.index(b)) for a, b in E_RMS_WINDOWS]
    late = (settings.index(settings.rms_from), end), last_quarter(settings), working(settings)
    parts = drive(settings), at_rest(settings)
    return [(0, end), (0, split), (split, end), *late, *parts, *errors]


DRIVE, END, ERRORS = 6, 7, 8
"""Places of these windows, of the errors' the first."""


def empty_figures(count: int) -> Figures:
    """Arrays for ``count`` runs."""
    return {name: np.full((count, *shape), np.nan) for name, shape in SHAPES.items()}


def put(figures: Figures, places: Sequence[int], memory: Memory, runs: Sequence[Runnable]) -> None:
    """Write a batch's figures where its runs stand."""
    settings = runs[0].loop.settings
    columns = _from_findings(memory, settings) | _from_sums(memory, settings)
    for name, values in columns.items():
        figures[name][list(places)] = values


def tracked(figures: Mapping[str, NDArray[np.float64]], settings: Sequence[Settings]) -> Flags:
    """Whether each run tracked, as `results.tracking.tracked` has it."""
    allowed = np.array([item.tolerance for item in settings], dtype=float)
    stops = np.array([first < end for first, end in map(at_rest, settings)])
    drives, ends = (figures[f"tracking_{part}"][:, 0] <= allowed for part in ("drive", "end"))
    return np.asarray(drives & (ends | ~stops))


def monitors(memory: Memory, runs: Sequence[Runnable]) -> list[Monitor]:
    """What was watched in each run of a batch."""
    columns = _from_findings(memory, runs[0].loop.settings)
    return [
        monitor({name: values[lane] for name, values in columns.items()})
        for lane, _ in enumerate(runs)
    ]


def monitor(one: Mapping[str, NDArray[np.float64]]) -> Monitor:
    """What was watched in one run, from its figures by name."""
    first = None
    if one["violations"] > 0:
        first = (float(one["first_violation"]), int(one["first_axis"]))
    reason = STOP_REASONS[int(one["stop"])]
    stopped = (float(one["stopped"]), int(one["stop_axis"])) if reason else None
    speeds = (float(one["max_abs_v"][0]), float(one["max_abs_v"][1]))
    left = None
    if one["bounds_left"] >= 0:
        left = (float(one["bounds_left"]), int(one["bounds_axis"]))
    least = None
    if not np.isnan(one["d_least"]).any():
        least = (float(one["d_least"][0]), float(one["d_least"][1]))
    return Monitor(
        speeds, int(one["violations"]), first, stopped, reason, bounds_left=left, d_least=least
    )


def _from_findings(memory: Memory, settings: Settings) -> Figures:
    row = memory.row
    step, left = settings.plant, row("left_sample")
    violated, ended, samples = row("violations") > 0, row("stop") > 0, row("samples")
    ran = (samples > 0)[:, None]
    return {
        "final_state": memory.final,
        "max_abs_v": row("max_v1", "max_omega"),
        "violations": row("violations"),
        "first_violation": np.where(violated, row("first_step") * step, np.nan),
        "first_axis": np.where(violated, row("first_axis"), np.nan),
        "stop": row("stop"),
        "stopped": np.where(ended, row("stop_step") * step, np.nan),
        "stop_axis": np.where(ended, row("stop_axis"), np.nan),
        "samples": samples,
        "tau_peak": np.where(samples > 0, row("torque"), np.nan),
        "d_least": np.where(ran, row("d_least1", "d_least2"), np.nan),
        "bounds_left": np.where(left >= 0, left * settings.control, np.nan),
        "bounds_axis": np.where(left >= 0, row("left_axis"), np.nan),
        "guard_share": np.where(
            ran, row("clipped1", "clipped2") / np.maximum(samples[:, None], 1), np.nan
        ),
    }


def _from_sums(memory: Memory, settings: Settings) -> Figures:
    full = np.array([covered(w, settings, memory) for w in windows_of(settings)])
    both = np.where(full, memory.sum("position") + memory.sum("angle"), np.nan) * settings.control
    position = np.where(full[0], memory.sum("position")[0], np.nan) * settings.control
    farthest = np.sqrt(np.where(full, memory.sum("farthest"), np.nan))

    def mean(name: str) -> Floats:
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(memory.sum(name) / np.where(full, memory.sum("samples"), np.nan))

    rms = np.sqrt(mean("position"))
    farthest = np.where(np.isnan(rms), np.nan, farthest)
    errors = [mean(f"e{axis}")[ERRORS:] for axis in (1, 2, 3)]
    return {
        "ise_total": both[0],
        "ise_before": both[1],
        "ise_after": both[2],
        "ise_position": position,
        "tau_rms": np.sqrt(mean("torque")[3] / 2),
        "torque_change_rms": np.sqrt(mean("change")[5] / 2),
        "torque_needed_rms": np.sqrt(mean("needed")[5] / 2),
        "saturated_share": mean("saturated")[5],
        "position_rms": rms[[0, 4]].T,
        "position_max": farthest[4],
        "tracking_drive": np.stack((rms[DRIVE], farthest[DRIVE]), axis=1),
        "tracking_end": np.stack((rms[END], farthest[END]), axis=1),
        "e_rms": np.sqrt(np.stack(errors, axis=2).swapaxes(0, 1)),
    }


def covered(window: tuple[int, int], settings: Settings, memory: Memory) -> NDArray[np.bool_]:
    """Which runs lasted through a window of samples."""
    stop, stop_step = memory.row("stop"), memory.row("stop_step")
    substeps = round(settings.control / settings.plant)
    whole = np.where(stop > 0, stop_step // substeps, settings.samples)
    first, last = window
    return np.asarray((whole >= last) & (first <= last) & (last <= settings.samples))
