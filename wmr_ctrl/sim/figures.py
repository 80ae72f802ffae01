"""Figures of many runs as arrays, from the sums that the lanes' loop leaves behind."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.results import Monitor, Settings
from wmr_ctrl.results.figures import Figure
from wmr_ctrl.results.outcomes import STOP_REASONS
from wmr_ctrl.results.windows import WINDOWS, at_rest, drive, last_quarter, named, working
from wmr_ctrl.sim.memory import Memory
from wmr_ctrl.sim.runnable import RunnableLoop

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Figures = dict[str, NDArray[np.float64]]

SHAPES: Mapping[str, tuple[int, ...]] = {
    "ise_total": (), "ise_before": (), "ise_after": (), "ise_position": (),
    "e_rms": (len(WINDOWS), 3), "max_abs_v": (2,), "violations": (),
    "first_violation": (), "first_axis": (), "stop": (), "stopped": (), "stop_axis": (),
    "samples": (), "tau_peak": (), "tau_rms": (), "torque_change_rms": (), "torque_needed_rms": (),
    "saturated_share": (), "position_rms": (2,), "position_max": (), "tracking_drive": (2,),
    "tracking_end": (2,), "final_state": (5,), "d_least": (2,), "bounds_left": (),
    "bounds_axis": (), "guard_share": (2,),
}  # fmt: skip
"""Figure to its shape for one run: ISE as in `results.measures` [m2 s and rad2 s]; ``e_rms`` by
window of `WINDOWS` [m, m, rad]; ``max_abs_v`` [m/s, rad/s]; ``violations`` (plant steps);
``first_violation`` and ``stopped`` [s], ``first_axis`` and ``stop_axis`` (1, 2); ``stop`` (index
into STOP_REASONS); ``samples`` made; torques [N m], their change and what the motion needs as in
`results.measures`; ``saturated_share`` of the samples with a wheel at its limit;
``position_rms`` over all and over the last quarter, ``position_max`` over the last quarter [m];
``tracking_drive`` and ``tracking_end``, RMS and largest distance [m]; ``final_state`` x, y [m],
theta [rad],
v1 [m/s], omega [rad/s]; ``d_least`` [N, N m], the largest; ``bounds_left`` [s] and ``bounds_axis``,
the first motion that a guard's bounds do not admit; ``guard_share``, share of samples in which the
guard acted.  NaN where there was no such event or the run ended before its window
did."""


def column_of(figure: Figure, arrays: Mapping[str, NDArray[np.float64]]) -> Floats:
    """A figure that the loop adds up, one number a run."""
    values: Floats = arrays[figure.array]
    for place in figure.index:
        values = values[:, place]
    return values


class Runnable(Protocol):
    """What is read of a task."""

    @property
    def loop(self) -> RunnableLoop:
        """What ran: its clocks and windows."""


def windows_of(settings: Settings) -> dict[str, tuple[int, int]]:
    """Windows of samples over which the loop adds up, by name."""
    end, split = settings.samples, settings.index(settings.split)
    return {
        "all": (0, end), "before": (0, split), "after": (split, end),
        "torque": (settings.index(settings.rms_from), end), "last_quarter": last_quarter(settings),
        "working": working(settings), "drive": drive(settings), "end": at_rest(settings),
        **{named(span): (settings.index(span[0]), settings.index(span[1])) for span in WINDOWS},
    }  # fmt: skip


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
    """Whether each run tracked, as `results.measures.tracked` has it."""
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
    windows = windows_of(settings)
    full = np.array([covered(w, settings, memory) for w in windows.values()])
    place = {name: k for k, name in enumerate(windows)}

    def total(name: str, over: str) -> Floats:
        k = place[over]
        return np.where(full[k], memory.sum(name)[k], np.nan)

    def rms(name: str, over: str, wheels: int = 1) -> Floats:
        return np.sqrt(mean(name, over) / wheels)

    def mean(name: str, over: str) -> Floats:
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(total(name, over) / total("samples", over))

    def farthest(over: str) -> Floats:
        return np.where(np.isnan(mean("position", over)), np.nan, np.sqrt(total("farthest", over)))

    def ise(over: str) -> Floats:
        return (total("position", over) + total("angle", over)) * settings.control

    errors = [[rms(f"e{axis}", named(span)) for axis in (1, 2, 3)] for span in WINDOWS]
    return {
        "ise_total": ise("all"),
        "ise_before": ise("before"),
        "ise_after": ise("after"),
        "ise_position": total("position", "all") * settings.control,
        "tau_rms": rms("torque", "torque", 2),
        "torque_change_rms": rms("change", "working", 2),
        "torque_needed_rms": rms("needed", "working", 2),
        "saturated_share": mean("saturated", "working"),
        "position_rms": np.stack((rms("position", "all"), rms("position", "last_quarter")), axis=1),
        "position_max": farthest("last_quarter"),
        **{
            f"tracking_{part}": np.stack((rms("position", part), farthest(part)), axis=1)
            for part in ("drive", "end")
        },
        "e_rms": np.moveaxis(np.array(errors), 2, 0),
    }


def covered(window: tuple[int, int], settings: Settings, memory: Memory) -> NDArray[np.bool_]:
    """Which runs lasted through a window of samples."""
    stop, stop_step = memory.row("stop"), memory.row("stop_step")
    substeps = round(settings.control / settings.plant)
    whole = np.where(stop > 0, stop_step // substeps, settings.samples)
    first, last = window
    return np.asarray((whole >= last) & (first <= last) & (last <= settings.samples))
