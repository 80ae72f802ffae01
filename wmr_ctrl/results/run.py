"""Run: the one result type of all engines."""

from __future__ import annotations

import operator
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.core.errors import ArgumentError, UnknownNameError
from wmr_ctrl.core.fields.arguments import check_fields, checks_arguments
from wmr_ctrl.core.fields.files import AnyPath
from wmr_ctrl.core.fields.units import length
from wmr_ctrl.core.late_bound import late_bound
from wmr_ctrl.core.signals import REFERENCE, TIME, Signal, places

from .consistency import contradictions
from .obstacles import nearest
from .outcomes import Monitor, Outcome, outcome_of
from .settings import Settings

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

    from .remarks import Remark
    from .verdicts import CorridorLeft, Outlook

Floats: TypeAlias = NDArray[np.float64]
_WITHHELD = (Outcome.COMPLETED, Outcome.BOUNDS_LEFT, Outcome.LIMIT_VIOLATED)
"""Ends of which the sentence is withheld where the plant contradicts itself."""


@dataclass(frozen=True, eq=False, repr=False)
class Run:
    """A finished run of the closed loop: one row per control sample t_k = k * control.

    ``columns`` maps each signal's name to its log, shape (N,) for a scalar and (N, size) for a
    vector, in the signals' SI units; N is smaller than ``settings.samples`` if the run ended early.
    Arrays are copied and read-only. ``run["v1"]`` is a column, ``run["v_c0[1]"]`` an element of
    one. ``provenance`` says how the run was made (versions, hashes, scenario text). ``save``,
    ``plot``, ``animate``, ``summary()`` and ``to_dataframe()`` export it.  Raises ArgumentError if
    names, shapes, clock or outcome contradict one another.
    """

    scenario: str
    law: str
    guard: bool
    seed: int
    engine: str
    settings: Settings
    signals: tuple[Signal, ...]
    columns: Mapping[str, Floats]
    monitor: Monitor
    outcome: Outcome
    provenance: Mapping[str, str]

    def __post_init__(self) -> None:
        check_fields(self)
        columns = {name: _frozen(values) for name, values in self.columns.items()}
        provenance = {str(key): str(value) for key, value in self.provenance.items()}
        self._set("columns", MappingProxyType(columns))
        self._set("provenance", MappingProxyType(provenance))
        self._set("signals", tuple(self.signals))
        self._set("outcome", Outcome(self.outcome))
        self._set("seed", operator.index(self.seed))
        outcome = outcome_of(self.monitor, self.guard)
        if self.outcome != outcome:
            raise ArgumentError(
                f"run.outcome = {self.outcome.value!r} does not fit what the monitor saw, which is "
                f"{outcome.value!r}. Use outcome_of(monitor, guard)."
            )
        _check_columns(self)
        _check_clock(self)

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)

    def __reduce__(self) -> tuple[type[Run], tuple[Any, ...]]:
        """Pickle and copy by the constructor, since a mapping proxy cannot be pickled."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        values |= {"columns": dict(self.columns), "provenance": dict(self.provenance)}
        return Run, tuple(values.values())

    def __repr__(self) -> str:
        guarded = ", guarded" if self.guard else ""
        return (
            f"<Run {self.scenario}, {self.law}{guarded}, seed {self.seed}, {self.engine}: "
            f"{self.rows} rows, {self.outcome}>"
        )

    def _repr_html_(self) -> str:
        from .frames import run_html

        return run_html(self)

    @checks_arguments
    def save(self, path: AnyPath) -> None:
        """Write the run to a file, in the format of its suffix; `wmr_ctrl.load_run` reads it back.

        Raises ResultFileError, or MissingExtraError for .mcap without rosbags.
        """
        late_bound("save_run")(self, path)

    @checks_arguments
    def plot(self, path: AnyPath | None = None) -> Figure:
        """Draw the run on one page; with ``path`` (.png, .svg or .pdf) also write it there.

        Returns matplotlib's figure, which notebooks show.  Raises ResultFileError for a path that
        cannot be written, ArgumentError for a run without any sample.
        """
        return cast("Figure", late_bound("plot_run")(self, path))

    @checks_arguments
    def animate(self, path: AnyPath) -> None:
        """Film the robot on its path into a .gif or .html file.

        Raises ResultFileError, ArgumentError for a run without any sample.
        """
        late_bound("animate_runs")([self], path)

    @checks_arguments
    def summary(self) -> dict[str, object]:
        """Labels, outcome and figures as plain values, as printed by ``wmr-ctrl run --json``."""
        from .frames import summary  # it reads Runs, and so stands above

        return summary(self)

    @checks_arguments
    def to_dataframe(self) -> pandas.DataFrame:
        """A column per logged number by element name, index ``t`` [s]; units in ``attrs``.

        Raises MissingExtraError without pandas.
        """
        from .frames import run_frame

        return run_frame(self)

    @property
    def rows(self) -> int:
        """Number N of logged samples."""
        return len(self.columns[TIME.name])

    @property
    def time(self) -> Floats:
        """Sample times t_k [s], shape (N,)."""
        return self.columns[TIME.name]

    @property
    def explanation(self) -> str:
        """Sentence on the outcome: event, time, axis, and remedy.

        It states that nothing needs to be done only without `remarks` and assumed keys.
        """
        apart = contradictions(self)
        if apart and self.outcome in _WITHHELD:
            also = "".join(f" {text}" for text in apart.values())
            return f"The run completed, but the plant contradicts itself.{also}"
        lost = self._lost_reference() if self.outcome is Outcome.NON_FINITE else None
        if lost is None:
            text = self.outcome.sentence(self.monitor, self.guard)
            near = nearest(self)
            if near is not None and near[0] >= 0:
                text += f" It came within {length(near[0])} of obstacle {near[1]}."
            return text + self._judged()
        return (
            "The run ended early because the desired motion was no longer finite at "
            f"t = {lost:.6g} s; law and robot only followed it. Change the reference's numbers, or "
            "its graph."
        )

    @cached_property
    def outlook(self) -> Outlook | None:
        """Theory's Outlook on law and scenario without a run, with its objections.

        None if the scenario is not known here; of an unknown law it has no objections.
        """
        return cast("Outlook | None", late_bound("outlook_of")(self))

    @cached_property
    def needed(self) -> Floats | None:
        """Wheel torques [N m] that the desired motion needs, (N, 2); None as `outlook`."""
        return cast("Floats | None", late_bound("needed_by")(self))

    @cached_property
    def corridor_left(self) -> CorridorLeft | None:
        """First time at which a run that had settled in its certified corridor left it.

        None if it did not leave, if there is no corridor, and if only the plane model and effects
        of this package move the robot, since the certificate covers those.
        """
        return cast("CorridorLeft | None", late_bound("left_corridor")(self))

    @cached_property
    def remarks(self) -> tuple[Remark, ...]:
        """Faults of the run, with keys and remedies; empty if all is well.

        Objections of `wmr-ctrl check` are included, and computed once per scenario and law.
        """
        from .remarks import remarks_on  # it reads Runs, and so stands above

        return remarks_on(self)

    def _judged(self) -> str:
        """End of a completed run's sentence."""
        from .remarks import in_short

        if self.outcome is not Outcome.COMPLETED:
            return ""
        if self.remarks:
            return f" But {in_short(self.remarks)}."
        if self.outlook is None or not self.outlook.known:
            return " Its log shows no fault; its law or scenario, unknown here, was not checked."
        if self.outlook.assumed:
            return f" That holds for assumed {', '.join(self.outlook.assumed)}: measure them."
        return " Nothing needs to be done."

    def _lost_reference(self) -> float | None:
        """Time [s] of the first row with a non-finite reference; None if all are finite."""
        names = [signal.name for signal in REFERENCE if signal.name in self.columns]
        bad = [~np.isfinite(self.columns[name]) for name in names]
        rows = np.flatnonzero(np.any(bad, axis=0)) if bad else np.empty(0)
        return float(self.time[rows[0]]) if rows.size else None

    @property
    def elements(self) -> tuple[Signal, ...]:
        """One scalar signal per logged number of a row, in order (``v_c0[1]``, ``v_c0[2]``)."""
        return tuple(scalar for signal in self.signals for scalar in _scalars(signal))

    def __contains__(self, name: object) -> bool:
        return name in self.columns or any(name in signal.elements for signal in self.signals)

    @checks_arguments
    def __getitem__(self, name: str) -> Floats:
        """A column, shape (N,) or (N, size), or one element of it, shape (N,), by its name.

        Raises UnknownNameError for any other name.
        """
        if name in self.columns:
            return self.columns[name]
        owner = self._owner(name)
        return self.columns[owner.name][:, owner.elements.index(name)]

    @checks_arguments
    def signal(self, name: str) -> Signal:
        """Name, unit, size and meaning of a column, or of one element of it (size 1).

        Raises UnknownNameError for any other name.
        """
        owner = self._owner(name)
        if name == owner.name:
            return owner
        return _scalars(owner)[owner.elements.index(name)]

    def _owner(self, name: str) -> Signal:
        for signal in self.signals:
            if name == signal.name or name in signal.elements:
                return signal
        raise UnknownNameError("column", name, (signal.name for signal in self.signals))


def split_columns(signals: Sequence[Signal], rows: Floats) -> dict[str, Floats]:
    """Rows of a log (N, numbers) as one array per signal, (N,) or (N, size)."""
    parts = {name: rows[:, place] for name, place in places(signals).items()}
    return {name: part[:, 0] if part.shape[1] == 1 else part for name, part in parts.items()}


def _scalars(signal: Signal) -> tuple[Signal, ...]:
    pairs = zip(signal.elements, signal.units, strict=True)
    return tuple(Signal(name, unit, signal.meaning) for name, unit in pairs)


def _frozen(values: object) -> Floats:
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


def _check_columns(run: Run) -> None:
    names = [signal.name for signal in run.signals]
    if names[:1] != [TIME.name]:
        raise ArgumentError(f"run.signals must begin with the time {TIME.name!r}, not {names[:1]}.")
    if len(set(names)) != len(names) or set(names) != set(run.columns):
        raise ArgumentError(
            f"run.columns ({', '.join(run.columns)}) must have each signal ({', '.join(names)}) "
            "once."
        )
    rows = run.columns[TIME.name].shape[:1]
    for signal in run.signals:
        wanted = rows if signal.size == 1 else (*rows, signal.size)
        if run.columns[signal.name].shape != wanted:
            raise ArgumentError(
                f"run.columns[{signal.name!r}] has the shape {run.columns[signal.name].shape}; "
                f"it must be {wanted}, one row per sample."
            )


def _check_clock(run: Run) -> None:
    control = run.settings.control
    if run.rows > run.settings.samples:
        raise ArgumentError(
            f"the run has {run.rows} rows, more than the {run.settings.samples} samples of "
            f"{run.settings.duration:g} s at {control:g} s."
        )
    late = np.abs(run.time - control * np.arange(run.rows)) > 1e-6 * control
    if late.any() or not np.isfinite(run.time).all():
        raise ArgumentError(f"run.time must be k * {control:g} s in row k, counted from 0.")
