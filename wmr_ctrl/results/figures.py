"""The catalogue of figures of merit: a number of a run, under one name wherever runs are tabulated.

Other packages add theirs through the entry-point group ``wmr_ctrl.figures`` (value = a `Figure`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np

from wmr_ctrl.errors import ArgumentError, UnknownNameError
from wmr_ctrl.fields.plugins import blamed, loaded
from wmr_ctrl.results.diagnostics import distance, rises, settling_time, weight_norm
from wmr_ctrl.results.metrics import e_rms, ise, tau_peak, tau_rms
from wmr_ctrl.results.tracking import (
    guard_share,
    position_max,
    position_rms,
    saturated_share,
    torque_change_rms,
    torque_needed_rms,
    tracked,
    tracking,
)
from wmr_ctrl.results.windows import BEFORE, LATE, WINDOWS, Span, named, window

if TYPE_CHECKING:
    from wmr_ctrl.results.run import Run

GROUP = "wmr_ctrl.figures"
Take = Callable[["Run"], float | None]


@dataclass(frozen=True, slots=True)
class Figure:
    """A number of a run: name, SI unit, meaning, and how to take it (None where it has none).

    ``array`` and ``index``: where the tables of `sim.figures.SHAPES` have it without a log.
    """

    name: str
    unit: str
    meaning: str
    of: Take
    array: str = ""
    index: tuple[int, ...] = ()

    @property
    def heading(self) -> str:
        """Name and unit, as columns are headed."""
        return f"{self.name} [{self.unit}]"


def distance_over(run: Run, start: float, end: float, *, largest: bool = False) -> float | None:
    """RMS of the distance from the reference over [start, end) [m], or the largest."""
    rows = window(run, start, end)
    if rows is None or rows.start == rows.stop:
        return None
    gap = distance(run)[rows]
    return float(gap.max() if largest else np.sqrt(np.mean(gap**2)))


def halving_time(run: Run) -> float | None:
    """First sample time at which the distance is at most half of that at the start [s]."""
    gap = distance(run)
    reached = np.flatnonzero(gap <= 0.5 * gap[0]) if run.rows else np.array([])
    return float(run.time[reached[0]]) if reached.size else None


def barrier_late(run: Run) -> float | None:
    """Mean of V1 over 30-40 s, divided by V1 at the first sample."""
    rows = window(run, *BEFORE)
    return None if rows is None else _relative(run, float(np.mean(run["V1"][rows])))


def barrier_rises(run: Run) -> float | None:
    """Number of samples before the split at which V1 is larger than one sample earlier."""
    climb = rises(run, 0.0, run.settings.split)
    return None if climb is None else float(climb.count)


def barrier_rise_share(run: Run) -> float | None:
    """Sum of the rises of V1 before the split, divided by V1 at the first sample."""
    climb = rises(run, 0.0, run.settings.split)
    return None if climb is None else _relative(run, climb.total)


def _relative(run: Run, value: float) -> float | None:
    start = _first("V1", run)
    return value / start if start else None


def _first(name: str, run: Run) -> float | None:
    return float(run[name][0]) if run.rows else None


def _weights(axis: int, when: str, run: Run) -> float | None:
    norm = weight_norm(run)
    return None if norm is None else (norm.end if when == "end" else norm.largest)[axis]


def _ise_orientation(run: Run) -> float | None:
    parts = ise(run)
    total, position = parts["total"], parts["position"]
    return None if total is None or position is None else total - position


def _mean_e1(run: Run, between: Span) -> float | None:
    rows = window(run, *between)
    return None if rows is None else float(np.mean(np.abs(run["e"][rows, 0])))


def _ratio(axis: int, run: Run) -> float:
    return run.monitor.max_abs_v[axis] / run.settings.v_u1[axis]


def _stopped(run: Run) -> float | None:
    """Also when the rigid body had fallen over."""
    rigid = run.monitor.rigid
    tipped = None if rigid is None else rigid.tipped
    return _time("stopped", run) if tipped is None else tipped


def _time(event: str, run: Run) -> float | None:
    seen = {"first_violation": run.monitor.first_violation, "stopped": run.monitor.stopped,
            "bounds_left": run.monitor.bounds_left}[event]  # fmt: skip
    return None if seen is None else seen[0]


def _rigid(name: str, run: Run) -> float | None:
    value: float | None = asdict(run.monitor.rigid)[name] if run.monitor.rigid else None
    return value


def _not_logged(_: Run) -> None:
    """The log ends a period before the run does."""


def _part(of: Callable[[Run], Mapping[str, float | None]], key: str) -> Take:
    return lambda run: of(run)[key]


def _axis(of: Callable[[Run], tuple[float, ...] | None], axis: int) -> Take:
    def take(run: Run) -> float | None:
        values = of(run)
        return None if values is None else values[axis]

    return take


def _tracking(part: str, key: str) -> Take:
    def take(run: Run) -> float | None:
        seen = tracking(run)[part]
        return None if seen is None else seen[key]

    return take


def _summed(name: str, unit: str, meaning: str, of: Take, *index: int) -> Figure:
    """A figure that the loop adds up, in an array of its name (a pair's less the axis)."""
    return Figure(name, unit, meaning, of, name.rstrip("12") if index else name, index)


def _pair(
    name: str, units: tuple[str, str], meaning: str, of: Callable[[Run], tuple[float, ...] | None]
) -> Iterator[Figure]:
    """Figures of an axis each, counted from 1."""
    for axis in (0, 1):
        text = f"{meaning}, axis {axis + 1}"
        yield _summed(f"{name}{axis + 1}", units[axis], text, _axis(of, axis), axis)


_MIXED = "m2.s + rad2.s"
_OVER = (("total", "over the whole run"), ("before", "before the split"),
         ("after", "from the split on"), ("position", "of the position alone"))  # fmt: skip
_AXES = tuple(enumerate(("m", "m", "rad")))
_STATE = (("x", "m"), ("y", "m"), ("theta", "rad"), ("v1", "m/s"), ("omega", "rad/s"))

SHARES = ("violated", "tracked")
"""Figures that are 0 or 1 a run: their mean is a share of the runs."""

SUMMED: tuple[Figure, ...] = (
    _summed("violations", "1", "plant steps beyond a velocity limit",
            lambda run: float(run.monitor.violations)),
    _summed("position_rms", "m", "RMS distance from the desired position, whole run",
            _part(position_rms, "all"), 0),
    Figure("position_rms_last_quarter", "m", "RMS distance over the last quarter",
           _part(position_rms, "last_quarter"), "position_rms", (1,)),
    _summed("position_max", "m", "largest distance over the last quarter", position_max),
    *(
        Figure(f"tracking_{part}_{short}", "m", f"{meaning} distance {when}",
               _tracking(part, f"position_{short}"), f"tracking_{part}", (place,))
        for part, when in (("drive", "while driving"), ("end", "after arrival"))
        for place, (short, meaning) in enumerate((("rms", "RMS"), ("max", "largest")))
    ),
    *(_summed(f"ise_{k}", "m2.s" if k == "position" else _MIXED, f"ISE {over}", _part(ise, k))
      for k, over in _OVER),
    *_pair("max_abs_v", ("m/s", "rad/s"), "largest |v1| or |omega|",
           lambda run: run.monitor.max_abs_v),
    _summed("first_violation", "s", "time of the first violation",
            partial(_time, "first_violation")),
    _summed("tau_peak", "N.m", "largest commanded wheel torque", tau_peak),
    _summed("tau_rms", "N.m", "RMS of the wheel torques", tau_rms),
    _summed("torque_change_rms", "N.m", "RMS change of the torques from sample to sample",
            torque_change_rms),
    _summed("torque_needed_rms", "N.m", "RMS of the torques that the desired motion needs",
            torque_needed_rms),
    _summed("saturated_share", "1", "share of samples with a wheel at its torque limit",
            saturated_share),
    *_pair("guard_share", ("1", "1"), "share of samples in which the guard changed the force",
           guard_share),
    *_pair("d_least", ("N", "N.m"), "largest least disturbance", lambda run: run.monitor.d_least),
    _summed("bounds_left", "s", "first motion that contradicts the guard's bounds",
            partial(_time, "bounds_left")),
    _summed("stopped", "s", "time at which a run ended early", _stopped),
    *(
        Figure(f"e{axis + 1}_rms_{named(span)}", unit,
               f"RMS of e{axis + 1} over {span[0]}-{span[1]} s",
               _axis(partial(e_rms, start=span[0], end=span[1]), axis), "e_rms", (place, axis))
        for axis, unit in _AXES
        for place, span in enumerate(WINDOWS)
    ),
    *(
        Figure(f"final_{name}", unit, f"{name} at the end", _not_logged, "final_state", (place,))
        for place, (name, unit) in enumerate(_STATE)
    ),
)  # fmt: skip
"""What the loop adds up without a log, in the order of a study's columns."""

RIGID: tuple[Figure, ...] = tuple(
    _summed(name, unit, meaning, partial(_rigid, name))
    for name, unit, meaning in (
        ("slipped", "s", "first time at which a tread slid by more than body.slip_max"),
        ("tipped", "s", "time at which the robot had fallen over"),
        ("max_slip", "m/s", "largest speed of a tread over the ground"),
        ("max_wheel_speed", "rad/s", "largest speed of a wheel"),
        ("max_tilt", "rad", "largest lean of the robot's axis"),
        ("least_tip_margin", "1", "least distance of the load's centre from tipping, 0 to 1"),
    )
)
"""What runs on the rigid body have besides."""

_LOGGED: tuple[Figure, ...] = (
    Figure("d_start", "m", "distance from the reference at the start",
           lambda run: float(distance(run)[0]) if run.rows else None),
    *(
        Figure(f"d_rms_{named(span)}", "m", f"RMS of the distance over {span[0]}-{span[1]} s",
               partial(distance_over, start=span[0], end=span[1]))
        for span in WINDOWS
    ),
    Figure(f"d_max_{named(LATE)}", "m", f"largest distance over {LATE[0]}-{LATE[1]} s",
           partial(distance_over, start=LATE[0], end=LATE[1], largest=True)),
    Figure("halving_time", "s", "first time at half the start's distance", halving_time),
    Figure("settling_time", "s", "time after which the distance stays within 0.1 m",
           partial(settling_time, within=0.1)),
    Figure("ise_orientation", "rad2.s", "ISE of the whole run of theta alone", _ise_orientation),
    *(
        Figure(f"e1_mean_{named(span)}", "m", f"mean of |e1| over {span[0]}-{span[1]} s",
               partial(_mean_e1, between=span))
        for span in (BEFORE, LATE)
    ),
    Figure("max_abs_omega", "rad/s", "largest |omega|", _axis(lambda r: r.monitor.max_abs_v, 1)),
    Figure("limit_ratio", "1", "largest |v_i|/v_u1_i over both axes",
           lambda run: max(_ratio(0, run), _ratio(1, run))),
    *(Figure(f"limit_ratio{axis + 1}", "1", f"largest {v}/v_u1[{axis + 1}]", partial(_ratio, axis))
      for axis, v in enumerate(("|v1|", "|omega|"))),
    Figure("tau_peak_late", "N.m", "largest commanded wheel torque from 2 s on",
           partial(tau_peak, start=2.0)),
    Figure("V1_start", "1", "V1 at the start", partial(_first, "V1")),
    Figure("V1_late", "1", "mean of V1 over 30-40 s, relative to its start", barrier_late),
    Figure("V1_rises", "1", "number of samples before the split at which V1 rose", barrier_rises),
    Figure("V1_rise_share", "1", "sum of these rises, relative to V1 at the start",
           barrier_rise_share),
    *(
        Figure(f"W{axis + 1}_{when}", "1", f"norm of the weights of axis {axis + 1}, {text}",
               partial(_weights, axis, when))
        for axis in (0, 1)
        for when, text in (("end", "last sample"), ("largest", "largest"))
    ),
)  # fmt: skip
_OURS = (
    Figure("violated", "1", "1 if violated, else 0", lambda run: float(run.monitor.violations > 0)),
    Figure("tracked", "1", "1 if tracked, else 0", lambda run: float(bool(tracked(run)))),
    *SUMMED, *RIGID, *_LOGGED,
)  # fmt: skip


class FigureRegistry:
    """All figures: ours, then those of other packages in the order of their names."""

    @cached_property
    def plugins(self) -> tuple[Figure, ...]:
        """Figures of other packages."""
        foreign = loaded(GROUP, Figure)
        for place, figure in enumerate(foreign):
            if figure.name in {other.name for other in (*_OURS, *foreign[:place])}:
                raise ArgumentError(
                    f"the figure {figure.name!r} of another package has the name of another one. "
                    "Its author gives it a name of its own."
                )
        return foreign

    def __iter__(self) -> Iterator[Figure]:
        """Yield every figure."""
        yield from (*_OURS, *self.plugins)

    def __getitem__(self, name: str) -> Figure:
        """The figure of that name; raises UnknownNameError."""
        for figure in self:
            if figure.name == name:
                return figure
        raise UnknownNameError("figure", name, (figure.name for figure in self))


FIGURES = FigureRegistry()


@np.errstate(over="ignore", invalid="ignore")
def values_of(run: Run, figures: Iterable[Figure]) -> dict[str, float | None]:
    """Figures of a run by name; None where it has none or where it is not finite.

    Raises ArgumentError where a figure of another package fails.
    """
    values: dict[str, float | None] = {}
    for figure in figures:
        remedy = "Mend or uninstall the package that has it."
        with blamed(f"the figure {figure.name!r} cannot be taken", remedy):
            value = figure.of(run)
            values[figure.name] = float(value) if value is not None and np.isfinite(value) else None
    return values
