"""The catalogue of figures of merit: a number of a run, under one name wherever runs are tabulated.

Other packages add theirs through the entry-point group ``wmr_ctrl.figures`` (value = a `Figure`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import cached_property, partial
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from wmr_ctrl.core.errors import ArgumentError, UnknownNameError
from wmr_ctrl.core.fields.plugins import blamed, loaded

from . import measures
from .windows import BEFORE, LATE, WINDOWS, Span, named

if TYPE_CHECKING:
    from .run import Run

GROUP = "wmr_ctrl.figures"
Take = Callable[["Run"], float | None]
STATE = (("x", "m"), ("y", "m"), ("theta", "rad"), ("v1", "m/s"), ("omega", "rad/s"))
SHARES = ("violated", "tracked")
"""Figures that are 0 or 1 a run: their mean is a share of the runs."""


@dataclass(frozen=True, slots=True)
class Sum:
    """Rule that makes a figure from the loop's sums over a window, named with "+" between.

    ``over``: the name of a window of `windows_of`; ``how``: "rms" of ``count`` numbers a sample,
    "mean", "largest" (a root), or "integral" over time.
    """

    sums: str
    over: str
    how: str = "rms"
    count: int = 1


@dataclass(frozen=True, slots=True)
class Figure:
    """A number of a run: name, SI unit, meaning, and how to take it (None where it has none).

    ``sum``: the loop's sums from which it is computed without a log; ``key``: the key of
    ``run --json`` that contains it, by itself or as an element; empty for one in `figures`.
    """

    name: str
    unit: str
    meaning: str
    of: Take
    sum: Sum | None = None
    key: str = ""

    @property
    def heading(self) -> str:
        """Name and unit, as columns are headed."""
        return f"{self.name} [{self.unit}]"


def _rigid(run: Run) -> dict[str, float | None] | None:
    return asdict(run.monitor.rigid) if run.monitor.rigid else None


READINGS: Mapping[str, Callable[[Run], object]] = {
    "ise": measures.ise,
    "position_rms": measures.position_rms,
    "position_max": measures.position_max,
    "tracking": measures.tracking,
    "tracked": measures.tracked,
    "arrival": measures.arrival,
    "guard_share": measures.guard_share,
    "filter_share": measures.filter_share,
    "usable_speed": attrgetter("settings.usable"),
    "reference_speed": attrgetter("settings.asked"),
    "torque_change_rms": measures.torque_change_rms,
    "torque_needed_rms": measures.torque_needed_rms,
    "saturated_share": measures.saturated_share,
    "max_abs_v": attrgetter("monitor.max_abs_v"),
    "violations": attrgetter("monitor.violations"),
    "rigid": _rigid,
    "d_least": attrgetter("monitor.d_least"),
    "dbar": attrgetter("settings.dbar"),
    "tau_peak": measures.tau_peak,
    "tau_rms": measures.tau_rms,
    "e_rms": lambda run: {f"{a}-{b}": measures.e_rms(run, a, b) for a, b in WINDOWS},
}
"""Keys of ``run --json``: numbers, pairs and tables of them, of which `Figure` are the elements."""


def _at(of: Callable[[Run], object], *path: str | int) -> Take:
    """An element of a reading."""

    def take(run: Run) -> float | None:
        value: Any = of(run)
        for step in path:
            value = None if value is None else value[step]
        return None if value is None else float(value)

    return take


def _stopped(run: Run) -> tuple[float, ...] | None:
    """Time at which a run ended early, also of the rigid body's fall."""
    rigid = run.monitor.rigid
    tipped = None if rigid is None else rigid.tipped
    return run.monitor.stopped if tipped is None else (tipped,)


def _event(name: str, meaning: str) -> Figure:
    return Figure(name, "s", meaning, _at(attrgetter(f"monitor.{name}"), 0))


_SUMS = {
    "position_max": Sum("farthest", "last_quarter", "largest"),
    "tau_rms": Sum("torque", "torque", count=2),
    "torque_change_rms": Sum("change", "working", count=2),
    "torque_needed_rms": Sum("needed", "working", count=2),
    "saturated_share": Sum("saturated", "working", "mean"),
}


def _reading(name: str, unit: str, meaning: str) -> Figure:
    """A figure that is a reading by itself."""
    return Figure(name, unit, meaning, _at(READINGS[name]), _SUMS.get(name), name)


def _pair(name: str, units: tuple[str, str], meaning: str) -> Iterator[Figure]:
    """Figures of an axis each, counted from 1."""
    for axis in (0, 1):
        text = f"{meaning}, axis {axis + 1}"
        yield Figure(f"{name}{axis + 1}", units[axis], text, _at(READINGS[name], axis), key=name)


def _ise(part: str, over: str, meaning: str) -> Figure:
    """The integral squared error over a window, or of the position alone."""
    alone, name = part == "position", f"ise_{part}"
    unit, sums = ("m2.s", part) if alone else ("m2.s + rad2.s", "position + angle")
    total = Sum(sums, over, "integral")
    return Figure(name, unit, f"ISE {meaning}", _at(measures.ise, part), total, "ise")


def _position(tail: str, over: str, where: str) -> Figure:
    of, text = _at(measures.position_rms, over), f"RMS distance {where}"
    return Figure(f"position_rms{tail}", "m", text, of, Sum("position", over), "position_rms")


def _tracking(part: str, when: str) -> Iterator[Figure]:
    totals = {"rms": Sum("position", part), "max": Sum("farthest", part, "largest")}
    for short, text in (("rms", "RMS"), ("max", "largest")):
        of, name = _at(measures.tracking, part, f"position_{short}"), f"tracking_{part}_{short}"
        yield Figure(name, "m", f"{text} distance {when}", of, totals[short], "tracking")


def _seconds(span: Span) -> str:
    return f"{span[0]}-{span[1]} s"


def _errors(axis: int, unit: str) -> Iterator[Figure]:
    for span in WINDOWS:
        text, total = f"RMS of e{axis} over {_seconds(span)}", Sum(f"e{axis}", named(span))
        of = _at(partial(measures.e_rms, start=span[0], end=span[1]), axis - 1)
        name = f"e{axis}_rms_{named(span)}"
        yield Figure(name, unit, text, of, total, "e_rms")


def _barrier(part: str, meaning: str) -> Figure:
    return Figure(f"V1_{part}", "1", meaning, _at(measures.barrier, part))


def _weights(axis: int) -> Iterator[Figure]:
    for when, text in (("end", "last sample"), ("largest", "largest")):
        meaning = f"norm of the weights of axis {axis}, {text}"
        of = _at(measures.weight_norm, when, axis - 1)
        yield Figure(f"W{axis}_{when}", "1", meaning, of)


def _over(span: Span, name: str, text: str, of: Callable[[Run, Span], float | None]) -> Figure:
    meaning = f"{text} over {_seconds(span)}"
    return Figure(f"{name}_{named(span)}", "m", meaning, lambda run: of(run, span))


SUMMED: tuple[Figure, ...] = (
    _reading("violations", "1", "plant steps beyond a velocity limit"),
    _position("", "all", "from the desired position, whole run"),
    _position("_last_quarter", "last_quarter", "over the last quarter"),
    _reading("position_max", "m", "largest distance over the last quarter"),
    *_tracking("drive", "while driving"),
    *_tracking("end", "after arrival"),
    _ise("total", "all", "over the whole run"),
    _ise("before", "before", "before the split"),
    _ise("after", "after", "from the split on"),
    _ise("position", "all", "of the position alone"),
    *_pair("max_abs_v", ("m/s", "rad/s"), "largest |v1| or |omega|"),
    _event("first_violation", "time of the first violation"),
    _reading("tau_peak", "N.m", "largest commanded wheel torque"),
    _reading("tau_rms", "N.m", "RMS of the wheel torques"),
    _reading("torque_change_rms", "N.m", "RMS change of the torques from sample to sample"),
    _reading("torque_needed_rms", "N.m", "RMS of the torques that the desired motion needs"),
    _reading("saturated_share", "1", "share of samples with a wheel at its torque limit"),
    *_pair("guard_share", ("1", "1"), "share of samples in which the guard changed the force"),
    *_pair("filter_share", ("1", "1"), "share of samples in which the filter changed the command"),
    *_pair("d_least", ("N", "N.m"), "largest least disturbance"),
    _event("bounds_left", "first motion that contradicts the guard's bounds"),
    Figure("stopped", "s", "time at which a run ended early", _at(_stopped, 0)),
    *(figure for axis, unit in ((1, "m"), (2, "m"), (3, "rad")) for figure in _errors(axis, unit)),
    *(
        Figure(f"final_{name}", unit, f"{name} at the end", lambda _: None)  # the log ends before
        for name, unit in STATE
    ),
)
"""Figures that the loop adds up without a log, in the order of a study's columns."""
RIGID: tuple[Figure, ...] = tuple(
    Figure(name, unit, meaning, _at(_rigid, name), key="rigid")
    for name, unit, meaning in (
        ("slipped", "s", "first time at which a tread slid by more than body.slip_max"),
        ("tipped", "s", "time at which the robot had fallen over"),
        ("max_slip", "m/s", "largest speed of a tread over the ground"),
        ("max_wheel_speed", "rad/s", "largest speed of a wheel"),
        ("max_tilt", "rad", "largest lean of the robot's axis"),
        ("least_tip_margin", "1", "least distance of the load's centre from tipping, 0 to 1"),
    )
)
"""Figures that runs on the rigid body have besides."""
_SETTLED = partial(measures.settling_time, within=0.1)
_LATE_PEAK = partial(measures.tau_peak, start=2.0)
_LOGGED: tuple[Figure, ...] = (
    Figure("d_start", "m", "distance from the reference at the start", measures.distance_at_start),
    *(_over(span, "d_rms", "RMS of the distance", measures.distance_over) for span in WINDOWS),
    _over(LATE, "d_max", "largest distance", partial(measures.distance_over, largest=True)),
    Figure("halving_time", "s", "first time at half the start's distance", measures.halving_time),
    Figure("settling_time", "s", "time after which the distance stays within 0.1 m", _SETTLED),
    Figure(
        "ise_orientation", "rad2.s", "ISE of the whole run of theta alone", measures.ise_orientation
    ),
    *(_over(span, "e1_mean", "mean of |e1|", measures.mean_e1) for span in (BEFORE, LATE)),
    Figure(
        "max_abs_omega", "rad/s", "largest |omega|", _at(READINGS["max_abs_v"], 1), key="max_abs_v"
    ),
    Figure(
        "limit_ratio",
        "1",
        "largest |v_i|/v_u1_i over both axes",
        lambda run: max(measures.limit_ratios(run)),
    ),
    Figure("limit_ratio1", "1", "largest |v1|/v_u1[1]", _at(measures.limit_ratios, 0)),
    Figure("limit_ratio2", "1", "largest |omega|/v_u1[2]", _at(measures.limit_ratios, 1)),
    Figure("tau_peak_late", "N.m", "largest commanded wheel torque from 2 s on", _LATE_PEAK),
    _barrier("start", "V1 at the start"),
    _barrier("late", "mean of V1 over 30-40 s, relative to its start"),
    _barrier("rises", "number of samples before the split at which V1 rose"),
    _barrier("rise_share", "sum of these rises, relative to V1 at the start"),
    *_weights(1),
    *_weights(2),
)
_OURS = (
    Figure("violated", "1", "1 if violated, else 0", lambda run: float(run.monitor.violations > 0)),
    Figure(
        "tracked",
        "1",
        "1 if tracked, else 0",
        lambda run: float(bool(measures.tracked(run))),
        key="tracked",
    ),
    *SUMMED,
    *RIGID,
    *_LOGGED,
)


class FigureRegistry:
    """All figures: ours, then those of other packages in the order of their names."""

    @cached_property
    def plugins(self) -> tuple[Figure, ...]:
        """Figures of other packages."""
        foreign = loaded(GROUP, Figure)
        for place, figure in enumerate(foreign):
            if figure.name in {other.name for other in (*_OURS, *foreign[:place])}:
                raise ArgumentError(
                    f"the figure {figure.name!r} of another package has the name of an existing "
                    "one. The author of that package must rename it."
                )
        return foreign

    def __iter__(self) -> Iterator[Figure]:
        yield from (*_OURS, *self.plugins)

    def __getitem__(self, name: str) -> Figure:
        """The figure of that name; raises UnknownNameError."""
        for figure in self:
            if figure.name == name:
                return figure
        raise UnknownNameError("figure", name, (figure.name for figure in self))

    def with_others(self, names: Iterable[str]) -> tuple[Figure, ...]:
        """The figures of those names in their order, then those of other packages."""
        return (*map(self.__getitem__, names), *self.plugins)


FIGURES = FigureRegistry()


@np.errstate(over="ignore", invalid="ignore")
def values_of(run: Run, figures: Iterable[Figure]) -> dict[str, float | None]:
    """Figures of a run by name; None where it has none or where it is not finite.

    Raises ArgumentError where a figure of another package fails.
    """
    values: dict[str, float | None] = {}
    for figure in figures:
        remedy = "Mend or uninstall the package that has it."
        with blamed(f"the figure {figure.name!r} cannot be taken", remedy, passing=()):
            value = figure.of(run)
            values[figure.name] = float(value) if value is not None and np.isfinite(value) else None
    return values
