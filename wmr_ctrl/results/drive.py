"""A robot's recorded drive: columns with separate times, as in a bag's topics."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from wmr_ctrl.core import signals
from wmr_ctrl.core.errors import ArgumentError, ResultFileError, UnknownNameError, show
from wmr_ctrl.core.fields.arguments import check_fields, checks_arguments
from wmr_ctrl.core.fields.files import AnyPath
from wmr_ctrl.core.fields.orientation import inward
from wmr_ctrl.core.late_bound import late_bound
from wmr_ctrl.core.signals import Signal, elements

from .files import write_csv
from .run import Floats, Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure


WHEEL_ANGLES = Signal("wheel_angle", "rad", "angles of the wheels (right, left)", 2)
WHEEL_ANGLE, WHEEL_SPEEDS = WHEEL_ANGLES.elements, signals.WHEEL_SPEED.elements
POSES, SPEEDS, COMMANDS, TORQUES = map(
    elements, (signals.MEASURED_POSE, signals.MEASURED_VELOCITY, signals.COMMAND, signals.TORQUE)
)
UNITS: Mapping[str, str] = {
    name: unit
    for signal in (
        *signals.MEASURED, *signals.COMMAND, *signals.TORQUE, signals.WHEEL_SPEED, WHEEL_ANGLES,
    )
    for name, unit in zip(signal.elements, signal.units, strict=True)
}  # fmt: skip
"""Columns that a drive may have, and the unit of each."""
NEVER = "desired motion, errors, limits or V1"
"""Quantities that no drive has."""


@dataclass(frozen=True)
class ColumnFacts:
    """A column of a drive: number of samples, their begin and end, and their range.

    ``first``, ``last`` and ``longest_gap`` [s]; ``least`` and ``largest`` in ``unit``.
    """

    unit: str
    samples: int
    first: float
    last: float
    longest_gap: float
    least: float
    largest: float


@dataclass(frozen=True, eq=False, repr=False)
class RecordedDrive:
    """A recorded drive: columns by name, each (N,) with its times [s] from the first message.

    ``drive["v1_measured"]`` is a column and ``drive.times["v1_measured"]`` its times; ``missing``
    names the columns that it lacks. Theta is 0 along +Y; ``remarks`` are sentences on clocks, gaps
    and omitted data. A drive has no desired motion and no limits, so nothing is judged. ``save``,
    ``plot``, ``summary()``, `wmr_ctrl.compare` and `wmr_ctrl.identify` use it. Raises
    ArgumentError if columns and times do not match.
    """

    name: str
    times: Mapping[str, Floats]
    columns: Mapping[str, Floats]
    remarks: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        check_fields(self)
        sizes = {name: np.shape(values) for name, values in self.columns.items()}
        if not sizes or sizes != {name: np.shape(t) for name, t in self.times.items()}:
            raise ArgumentError("a drive must have at least one column, each with its times.")
        for name, size in sizes.items():
            if len(size) != 1 or size == (0,) or name not in UNITS:
                raise ArgumentError(
                    f"drive.columns[{show(name)}] must be one of {', '.join(UNITS)}, with at least "
                    "one number and no axis but that of time."
                )

    def __repr__(self) -> str:
        return f"<RecordedDrive {self.name}, {self.duration:.4g} s: {', '.join(self.columns)}>"

    def __contains__(self, name: object) -> bool:
        return name in self.columns

    @checks_arguments
    def __getitem__(self, name: str) -> Floats:
        """A column, shape (N,).  Raises UnknownNameError, which lists the existing ones."""
        if name not in self.columns:
            raise UnknownNameError("column of this drive", name, self.columns)
        return self.columns[name]

    def has(self, names: Sequence[str]) -> bool:
        """True if all of these columns are there."""
        return all(name in self.columns for name in names)

    @property
    def missing(self) -> tuple[str, ...]:
        """Columns that a drive may have but this one lacks."""
        return tuple(name for name in UNITS if name not in self.columns)

    @property
    def duration(self) -> float:
        """Time of the last message [s]."""
        return max(float(t[-1]) for t in self.times.values())

    def facts(self) -> dict[str, ColumnFacts]:
        """Samples, gaps and range of each column, by name."""
        return {name: self._fact(name) for name in UNITS if name in self.columns}

    def _fact(self, name: str) -> ColumnFacts:
        t, values = self.times[name], self.columns[name]
        gap = float(np.diff(t).max(initial=0.0))
        least, largest = float(values.min()), float(values.max())
        return ColumnFacts(UNITS[name], len(t), float(t[0]), float(t[-1]), gap, least, largest)

    def figures(self) -> dict[str, float | None]:
        """Path length [m], largest speeds [m/s, rad/s] and torque [N m]; None: unknown."""
        way = None
        if self.has(POSES):
            x, y = (self.columns[name] for name in POSES[:2])
            way = float(np.hypot(np.diff(x), np.diff(y)).sum())
        largest = {
            "max_abs_v1": SPEEDS[:1], "max_abs_v2": SPEEDS[1:], "max_abs_v_command": COMMANDS[:1],
            "max_abs_omega_command": COMMANDS[1:], "tau_peak": TORQUES,
        }  # fmt: skip
        return {"way": way} | {key: self._largest(names) for key, names in largest.items()}

    def _largest(self, names: Sequence[str]) -> float | None:
        if not self.has(names):
            return None
        return float(max(np.abs(self.columns[name]).max() for name in names))

    def summary(self) -> dict[str, object]:
        """Figures, columns, missing columns, remarks: the output of ``wmr-ctrl show --json``."""
        columns = {name: asdict(fact) for name, fact in self.facts().items()}
        return {
            "drive": self.name, "duration": self.duration, **self.figures(), "columns": columns,
            "missing": list(self.missing), "remarks": list(self.remarks),
        }  # fmt: skip

    @checks_arguments
    def plot(self, path: AnyPath | None = None) -> Figure:
        """Draw all columns on one page; with ``path`` (.png, .svg or .pdf) also write it there.

        Returns matplotlib's figure, which notebooks show.  Raises ResultFileError for a path that
        cannot be written.
        """
        return cast("Figure", late_bound("plot_drives")([self], path))

    @checks_arguments
    def save(self, path: AnyPath) -> None:
        """Write a .csv log that `identify` reads: t and the columns, with gaps for missing values.

        Raises ResultFileError for another suffix or if the file cannot be written.
        """
        if Path(path).suffix.lower() != ".csv":
            raise ResultFileError(
                f"{os.fspath(path)!r} must end in .csv: a drive is saved as a log."
            )
        t = np.unique(np.concatenate(list(self.times.values())))
        cells = np.full((len(t), len(self.columns)), "", dtype=object)
        for place, (name, values) in enumerate(self.columns.items()):
            cells[np.searchsorted(t, self.times[name]), place] = values.tolist()
        units = {signals.TIME.name: signals.TIME.unit, **UNITS}
        header = [f"{name} [{units[name]}]" for name in (signals.TIME.name, *self.columns)]
        rows = zip(t.tolist(), cells, strict=True)
        write_csv(path, header, ([at, *row] for at, row in rows))


def drive_of(run: Run, name: str = "") -> RecordedDrive:
    """Drive as the base of a run would record it: measured values if the run has them, else true
    ones.

    Wheel angles are included if the run has counts.
    """
    columns = dict(_told(run))
    remarks = () if POSES[0] in run else ("poses and velocities are the true ones of a run.",)
    return RecordedDrive(name or run.scenario, dict.fromkeys(columns, run.time), columns, remarks)


def _told(run: Run) -> Iterator[tuple[str, Floats]]:
    for seen, true in ((POSES, elements(signals.POSE)), (SPEEDS, elements(signals.VELOCITY))):
        own = seen if seen[0] in run else true
        for name, source in zip(seen, own, strict=True):
            turned = name == POSES[2]
            yield name, inward(run[source], run.settings.frames) if turned else run[source]
    for name in (*COMMANDS, *TORQUES):
        if name in run:
            yield name, run[name]
    if signals.WHEEL_SPEED.name in run.columns:
        yield from zip(WHEEL_SPEEDS, run[signals.WHEEL_SPEED.name].T, strict=True)
    encoder = tomllib.loads(run.provenance.get("scenario_toml", "")).get("encoder", {})
    if "wheel_counts" in run.columns and encoder.get("counts"):
        turn = 2 * np.pi / encoder["counts"]
        yield from zip(WHEEL_ANGLE, run["wheel_counts"].T * turn, strict=True)
