"""Figures of many runs as arrays, from the loop's sums, without a log."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.core.fields.orientation import outward
from wmr_ctrl.results import Monitor, Settings, outcome_of
from wmr_ctrl.results.figures import STATE, SUMMED, Sum
from wmr_ctrl.results.outcomes import DIVERGENCE, STOP_REASONS
from wmr_ctrl.results.settings import Event
from wmr_ctrl.results.windows import at_rest, windows_of

from .memory import Results, Task
from .runnable import RunnableLoop

Floats = NDArray[np.float64]
Figures = dict[str, NDArray[np.float64]]
V = TypeVar("V", float, Floats)

EVENTS = ("first_axis", "stop", "stop_axis", "samples", "bounds_axis")
"""Numbers of a run beside its figures: axes of its events (1, 2), ``stop`` (index into
STOP_REASONS), and the number of samples made."""

CHANGED = ("guard_share1", "guard_share2", "filter_share1", "filter_share2")
"""Shares of samples in which guard or filter changed what the law asked for."""
COLUMNS = (*(figure.name for figure in SUMMED), *EVENTS)
"""Numbers of a run without a log; NaN where there was no such event, or the run ended before the
figure's window did."""


def empty_figures(count: int) -> Figures:
    """Arrays for ``count`` runs, with ``outcome`` (text) and ``tracked`` (bool)."""
    texts = {"outcome": np.full(count, "", "<U16"), "tracked": np.full(count, False)}
    return texts | {name: np.full(count, np.nan) for name in COLUMNS}


def put(figures: Figures, places: Sequence[int], memory: Results, runs: Sequence[Task]) -> None:
    """Write a batch's figures at the indices of its runs."""
    where, settings = list(places), runs[0].loop.settings
    each = {id(run.loop): _facts(run.loop) for run in runs}
    known = np.array([each[id(run.loop)] for run in runs])
    guarded, filtered, stops = known[:, :3].T != 0.0
    numbers = {**_from_findings(memory, settings), **dict(_from_sums(memory, settings))}
    for share in CHANGED:
        numbers[share] = np.where(filtered if "filter" in share else guarded, numbers[share], 0.0)
    for push in ("d_least1", "d_least2"):  # no motion contradicts a guard that is not there
        numbers[push] = np.where(filtered, np.nan, numbers[push])
    for name, values in numbers.items():
        figures[name][where] = values
    figures["outcome"][where] = _outcomes(memory, settings, guarded)
    drives, ends = (numbers[f"tracking_{part}_rms"] <= known[:, 3] for part in ("drive", "end"))
    figures["tracked"][where] = drives & (ends | ~stops)


def _facts(loop: RunnableLoop) -> tuple[float, ...]:
    """Properties of a loop: has a guard, a filter, a path that stops; and the tolerance [m]."""
    scenario, settings = loop.scenario, loop.settings
    first, end = at_rest(settings)
    switches = scenario.guard.enabled, scenario.base.kind == "velocity", first < end
    return (*map(float, switches), np.nan if settings.tolerance is None else settings.tolerance)


def _outcomes(memory: Results, settings: Settings, guarded: NDArray[np.bool_]) -> NDArray[np.str_]:
    """Outcome of each run; runs with equal data are judged once."""
    row = memory.row
    most = np.maximum(row("max_v1"), row("max_omega"))
    events = (most >= DIVERGENCE, row("violations") > 0, row("left_sample") >= 0, guarded)
    decisive = [row("stop"), ~np.isfinite(most), *events]
    alike = np.ravel_multi_index([*np.array(decisive, dtype=int)], (3, 2, 2, 2, 2, 2))
    _, first, kind = np.unique(alike, return_index=True, return_inverse=True)
    judged = zip(monitors(memory, settings, first), guarded[first], strict=True)
    return np.array([outcome_of(seen, guard).value for seen, guard in judged])[kind]


def monitors(
    memory: Results, settings: Settings, places: NDArray[np.intp] | slice = slice(None)
) -> list[Monitor]:
    """Monitors of the runs of a batch, or of selected ones."""
    columns = memory.findings[:, : memory.count].T[places].tolist()
    rows = [dict(zip(memory.layout.findings, numbers, strict=True)) for numbers in columns]
    return [monitor(row, settings.plant, settings.control) for row in rows]


def monitor(
    seen: Mapping[str, float], step: float, period: float = 0.0, failure: str = ""
) -> Monitor:
    """Monitor of one run, from its findings by name; the plant's and the control step [s].

    Without a ``period`` the guard's bounds are omitted.
    """

    def event(name: str, time: float) -> Event | None:
        return (time, int(seen[f"{name}_axis"])) if time >= 0 else None

    return Monitor(
        (seen["max_v1"], seen["max_omega"]),
        int(seen["violations"]),
        event("first", seen["first_step"] * step) if seen["violations"] > 0 else None,
        event("stop", seen["stop_step"] * step) if seen["stop"] > 0 else None,
        STOP_REASONS[int(seen["stop"])],
        event("left", seen["left_sample"] * period) if period else None,
        failure,
        least_margin=(seen["margin_v1"], seen["margin_omega"]),
    )


def final_state(end: Iterable[V], frames: str) -> dict[str, V]:
    """Figures of the final state, by name; its orientation is converted to ``frames``."""
    values = {f"final_{name}": value for (name, _), value in zip(STATE, end, strict=False)}
    return values | {"final_theta": outward(values["final_theta"], frames)}


def _from_findings(memory: Results, settings: Settings) -> Figures:
    row = memory.row
    step, left = settings.plant, row("left_sample")
    violated, ended, samples = row("violations") > 0, row("stop") > 0, row("samples")
    ran, most = samples > 0, np.maximum(samples, 1)
    return {
        **final_state(memory.final.T, settings.frames),
        "max_abs_v1": row("max_v1"),
        "max_abs_v2": row("max_omega"),
        "least_margin1": row("margin_v1"),
        "least_margin2": row("margin_omega"),
        "least_gap": np.where(
            ran, row("gap") if "gap" in memory.layout.findings else np.nan, np.nan
        ),
        "violations": row("violations"),
        "first_violation": np.where(violated, row("first_step") * step, np.nan),
        "first_axis": np.where(violated, row("first_axis"), np.nan),
        "stop": row("stop"),
        "stopped": np.where(ended, row("stop_step") * step, np.nan),
        "stop_axis": np.where(ended, row("stop_axis"), np.nan),
        "samples": samples,
        "tau_peak": np.where(ran, row("torque"), np.nan),
        **{f"d_least{k}": np.where(ran, row(f"d_least{k}"), np.nan) for k in (1, 2)},
        "bounds_left": np.where(left >= 0, left * settings.control, np.nan),
        "bounds_axis": np.where(left >= 0, row("left_axis"), np.nan),
        **{name: np.where(ran, row(f"clipped{name[-1]}") / most, np.nan) for name in CHANGED},
    }


def _from_sums(memory: Results, settings: Settings) -> Iterator[tuple[str, Floats]]:
    """Figures computed from sums, by name; NaN if a run did not last the figure's window."""
    windows = windows_of(settings)
    full = {name: covered(span, settings, memory) for name, span in windows.items()}
    place = {name: k for k, name in enumerate(windows)}

    def total(sums: str, over: str) -> Floats:
        added = sum(memory.sum(name)[place[over]] for name in sums.split(" + "))
        return np.where(full[over], added, np.nan)

    for figure in SUMMED:
        if figure.sum is not None:
            added, samples = (total(n, figure.sum.over) for n in (figure.sum.sums, "samples"))
            yield figure.name, _made(figure.sum, added, samples, settings.control)


def _made(how: Sum, added: Floats, samples: Floats, period: float) -> Floats:
    """A figure from its sums over a window with this number of samples."""
    if how.how == "integral":
        return added * period
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.asarray(added / samples)
    if how.how == "largest":
        return np.where(np.isnan(mean), np.nan, np.sqrt(added))
    return mean if how.how == "mean" else np.sqrt(mean / how.count)


def covered(window: tuple[int, int], settings: Settings, memory: Results) -> NDArray[np.bool_]:
    """Mask of the runs that lasted through a window of samples."""
    stop, stop_step = memory.row("stop"), memory.row("stop_step")
    substeps = round(settings.control / settings.plant)
    whole = np.where(stop > 0, stop_step // substeps, settings.samples)
    first, last = window
    return np.asarray((whole >= last) & (first <= last) & (last <= settings.samples))
