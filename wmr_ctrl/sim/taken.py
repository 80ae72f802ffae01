"""The figures of many runs, taken from a whole Run in the place of the sums of the lanes' loop."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.results import (
    Run,
    e_rms,
    guard_share,
    ise,
    position_max,
    position_rms,
    saturated_share,
    tau_peak,
    tau_rms,
    torque_change_rms,
    torque_needed_rms,
    tracking,
)
from wmr_ctrl.results.metrics import E_RMS_WINDOWS
from wmr_ctrl.results.monitor import STOP_REASONS, Event
from wmr_ctrl.sim.figures import SHAPES

Taken = dict[str, NDArray[np.float64]]


def figures_taken(run: Run, end: tuple[float, ...]) -> Taken:
    """Every figure of `SHAPES` of one run; ``end`` is the state that it ended in, (5,).

    They are those of `sim.many.run_many` but for the rounding of sums.
    """
    numbers = {**_of_log(run), **_of_monitor(run), "final_state": end, "samples": run.rows}
    return {name: _shaped(numbers[name], shape) for name, shape in SHAPES.items()}


def _shaped(value: object, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Numbers of that shape; NaN where there is none."""
    return np.full(shape, np.nan) if value is None else np.array(value, dtype=float).reshape(shape)


@np.errstate(over="ignore", invalid="ignore")
def _of_log(run: Run) -> dict[str, object]:
    position, none = position_rms(run), (np.nan,) * 3
    return {
        **{f"ise_{name}": value for name, value in ise(run).items()},
        "e_rms": [e_rms(run, *window) or none for window in E_RMS_WINDOWS],
        "tau_peak": tau_peak(run),
        "tau_rms": tau_rms(run),
        "torque_change_rms": torque_change_rms(run),
        "torque_needed_rms": torque_needed_rms(run),
        "saturated_share": saturated_share(run),
        **{f"tracking_{part}": _pair(seen) for part, seen in tracking(run).items()},
        "position_rms": [position["all"], position["last_quarter"]],
        "position_max": position_max(run),
        "guard_share": guard_share(run),
    }


def _pair(seen: dict[str, float | None] | None) -> list[float]:
    return [np.nan if value is None else value for value in (seen or dict.fromkeys("ab")).values()]


def _of_monitor(run: Run) -> dict[str, object]:
    seen = run.monitor
    return {
        "max_abs_v": seen.max_abs_v,
        "violations": seen.violations,
        "stop": STOP_REASONS.index(seen.stop_reason),
        "d_least": seen.d_least,
        **_event(seen.first_violation, "first_violation", "first_axis"),
        **_event(seen.stopped, "stopped", "stop_axis"),
        **_event(seen.bounds_left, "bounds_left", "bounds_axis"),
    }


def _event(event: Event | None, time: str, axis: str) -> dict[str, object]:
    return dict(zip((time, axis), event or (None, None), strict=True))
