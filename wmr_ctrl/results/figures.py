"""The catalogue of figures of merit: numbers of a run with one name in all tables.

Other packages add theirs through the entry-point group ``wmr_ctrl.figures`` (value = a `Figure`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property, partial
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from wmr_ctrl.core.data import data
from wmr_ctrl.core.errors import ArgumentError, UnknownNameError
from wmr_ctrl.core.fields.plugins import blamed, loaded

from . import measures
from .consistency import kept
from .obstacles import nearest
from .windows import WINDOWS, Span, named

if TYPE_CHECKING:
    from .run import Run

GROUP = "wmr_ctrl.figures"
Take = Callable[["Run"], float | None]
STATE = (("x", "m"), ("y", "m"), ("theta", "rad"), ("v1", "m/s"), ("omega", "rad/s"))
SHARES = ("violated", "tracked")
"""Figures that are 0 or 1 a run: their mean is a share of the runs."""


@dataclass(frozen=True)
class Sum:
    """Rule that makes a figure from the loop's sums over a window; several names are joined by "+".

    ``over``: the name of a window of `windows_of`; ``how``: "rms" of ``count`` numbers a sample,
    "mean", "largest" (of which the root is taken), or "integral" over time.
    """

    sums: str
    over: str
    how: str = "rms"
    count: int = 1


@dataclass(frozen=True)
class Figure:
    """A number of a run: name, SI unit, meaning, and its function (None if a run has no value).

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
        """Name and unit, as in headings of columns."""
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
    "filter_share": lambda run: measures.filter_share(run),
    "usable_speed": attrgetter("settings.usable"),
    "reference_speed": attrgetter("settings.asked"),
    "torque_change_rms": measures.torque_change_rms,
    "torque_needed_rms": measures.torque_needed_rms,
    "saturated_share": measures.saturated_share,
    "max_abs_v": attrgetter("monitor.max_abs_v"),
    "least_margin": attrgetter("monitor.least_margin"),
    "least_gap": lambda run: (nearest(run) or (None,))[0],
    "violations": attrgetter("monitor.violations"),
    "kept": kept,
    "rigid": _rigid,
    "d_least": attrgetter("monitor.d_least"),
    "dbar": attrgetter("settings.dbar"),
    "tau_peak": measures.tau_peak,
    "tau_rms": measures.tau_rms,
    "e_rms": lambda run: {f"{a}-{b}": measures.e_rms(run, a, b) for a, b in WINDOWS},
}
"""Keys of ``run --json``: numbers, pairs and tables of them, of which `Figure` are the elements."""


def _stopped(run: Run) -> tuple[float, ...] | None:
    """Time at which a run ended early, including a fall of the rigid body."""
    rigid = run.monitor.rigid
    tipped = None if rigid is None else rigid.tipped
    return run.monitor.stopped if tipped is None else (tipped,)


def _windowed(of: Callable[[Run, Span], float | None]) -> Callable[[Run], object]:
    """Function that evaluates ``of`` for every window of time, by the window's name."""
    return lambda run: {f"{a}-{b}": of(run, (a, b)) for a, b in WINDOWS}


_SOURCES: Mapping[str, Callable[[Run], object]] = {
    **READINGS,
    "first_violation": attrgetter("monitor.first_violation"),
    "bounds_left": attrgetter("monitor.bounds_left"),
    "stopped": _stopped,
    "barrier": measures.barrier,
    "weight_norm": measures.weight_norm,
    "limit_ratios": measures.limit_ratios,
    "limit_ratio": lambda run: max(measures.limit_ratios(run)),
    "d_start": measures.distance_at_start,
    "d_rms": _windowed(measures.distance_over),
    "d_max": _windowed(partial(measures.distance_over, largest=True)),
    "e1_mean": _windowed(measures.mean_e1),
    "halving_time": measures.halving_time,
    "settling_time": partial(measures.settling_time, within=0.1),
    "ise_orientation": measures.ise_orientation,
    "tau_peak_late": partial(measures.tau_peak, start=2.0),
}
"""Functions that have the numbers of figures.toml."""


def _at(of: Callable[[Run], object], path: Sequence[str | int]) -> Take:
    """Function that selects an element of the value of ``of``."""

    def take(run: Run) -> float | None:
        value: Any = of(run)
        for step in path:
            value = None if value is None else value[step]
        return None if value is None else float(value)

    return take


def _figures(
    name: str,
    unit: str,
    meaning: str,
    of: Sequence[Any] = (),
    sum: Sequence[Any] = (),
    windows: Sequence[int] = (),
) -> Iterator[Figure]:
    """Figures of a row of figures.toml: one, or one per window."""
    source, *path = of or [name]
    key = source if source in READINGS else ""
    reading, total = _SOURCES[source], Sum(*sum) if sum else None
    if not windows:
        yield Figure(name, unit, meaning, _at(reading, path), total, key)
    for a, b in (WINDOWS[place] for place in windows):
        over, text = named((a, b)), f"{meaning} over {a}-{b} s"
        of_window = total and replace(total, over=over)
        take = _at(reading, (f"{a}-{b}", *path))
        yield Figure(f"{name}_{over}", unit, text, take, of_window, key)


def _listed(rows: Mapping[str, dict[str, Any]]) -> tuple[Figure, ...]:
    return tuple(figure for name, row in rows.items() for figure in _figures(name, **row))


_CATALOGUE = data(__package__, "figures.toml")
SUMMED = (
    *_listed(_CATALOGUE["summed"]),
    *(
        Figure(f"final_{name}", unit, f"{name} at the end", lambda _: None)  # the log ends before
        for name, unit in STATE
    ),
)
"""Figures that the loop adds up without a log, in the order of a study's columns."""
RIGID = _listed(_CATALOGUE["rigid"])
"""Figures that runs on the rigid body have besides."""
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
    *_listed(_CATALOGUE["logged"]),
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
    """Figures of a run by name; missing and non-finite values are None.

    Raises ArgumentError if a figure of another package fails.
    """
    values: dict[str, float | None] = {}
    for figure in figures:
        remedy = "Mend or uninstall the package that has it."
        with blamed(f"the figure {figure.name!r} cannot be taken", remedy, passing=()):
            value = figure.of(run)
            values[figure.name] = float(value) if value is not None and np.isfinite(value) else None
    return values
