"""A robot's drive: columns that each have their own times, as a bag of its topics holds them."""

from __future__ import annotations

import csv
import io
import os
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from wmr_ctrl.fields.orientation import inward
from wmr_ctrl.results.files import atomic_write
from wmr_ctrl.results.run import FloatArray, Run
from wmr_ctrl.signals import (
    COMMAND,
    MEASURED_POSE,
    MEASURED_VELOCITY,
    POSE,
    TIME,
    TORQUE,
    VELOCITY,
    WHEEL_SPEED,
    Signal,
)


def names_of(signals: Sequence[Signal]) -> tuple[str, ...]:
    """Names of scalar signals."""
    return tuple(signal.name for signal in signals)


WHEEL_ANGLES = Signal("wheel_angle", "rad", "angles of the wheels (right, left)", 2)
WHEEL_ANGLE, WHEEL_SPEEDS = WHEEL_ANGLES.elements, WHEEL_SPEED.elements
POSES, SPEEDS, COMMANDS, TORQUES = map(
    names_of, (MEASURED_POSE, MEASURED_VELOCITY, COMMAND, TORQUE)
)
UNITS: Mapping[str, str] = {
    name: unit
    for signal in (
        *MEASURED_POSE, *MEASURED_VELOCITY, *COMMAND, *TORQUE, WHEEL_SPEED, WHEEL_ANGLES,
    )
    for name, unit in zip(signal.elements, signal.units, strict=True)
}  # fmt: skip
"""Columns that a drive may have, and the unit of each."""


@dataclass(frozen=True)
class ColumnFacts:
    """A column of a drive: its samples, when they begin and end, and their range.

    ``first``, ``last`` and ``longest_gap`` [s]; ``least`` and ``largest`` in ``unit``.
    """

    unit: str
    samples: int
    first: float
    last: float
    longest_gap: float
    least: float
    largest: float


@dataclass(frozen=True)
class RecordedDrive:
    """Columns of a drive by name, each (N,) with its own times [s] from the first message's.

    Units are those of `UNITS`, theta is 0 along +Y; ``remarks`` are sentences on clocks, gaps and
    what was left out.
    """

    name: str
    times: Mapping[str, FloatArray]
    columns: Mapping[str, FloatArray]
    remarks: tuple[str, ...] = ()

    def has(self, names: Sequence[str]) -> bool:
        """True if all of these columns are there."""
        return all(name in self.columns for name in names)

    @property
    def missing(self) -> tuple[str, ...]:
        """Columns that a drive may have and this one has not."""
        return tuple(name for name in UNITS if name not in self.columns)

    @property
    def duration(self) -> float:
        """Time of the last message [s]."""
        return max(float(t[-1]) for t in self.times.values())

    def facts(self) -> dict[str, ColumnFacts]:
        """What each column is, by name."""
        return {name: self._fact(name) for name in UNITS if name in self.columns}

    def _fact(self, name: str) -> ColumnFacts:
        t, values = self.times[name], self.columns[name]
        gap = float(np.diff(t).max(initial=0.0))
        least, largest = float(values.min()), float(values.max())
        return ColumnFacts(UNITS[name], len(t), float(t[0]), float(t[-1]), gap, least, largest)

    def figures(self) -> dict[str, float | None]:
        """Way [m] by the poses, largest speeds [m/s, rad/s] and torque [N m]; None: not there."""
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
        """All that is said of it, as plain values."""
        columns = {name: asdict(fact) for name, fact in self.facts().items()}
        return {
            "drive": self.name, "duration": self.duration, **self.figures(), "columns": columns,
            "missing": list(self.missing), "remarks": list(self.remarks),
        }  # fmt: skip

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a .csv log that `identify` reads: t, then a column each, empty where it has none.

        Raises ResultFileError where the file cannot be written.
        """
        t = np.unique(np.concatenate(list(self.times.values())))
        cells = np.full((len(t), len(self.columns)), "", dtype=object)
        for place, (name, values) in enumerate(self.columns.items()):
            cells[np.searchsorted(t, self.times[name]), place] = list(map(repr, values.tolist()))
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        units = {TIME.name: TIME.unit, **UNITS}
        writer.writerow([f"{name} [{units[name]}]" for name in (TIME.name, *self.columns)])
        writer.writerows([repr(at), *row] for at, row in zip(t.tolist(), cells, strict=True))
        with atomic_write(path) as file:
            file.write(text.getvalue().encode())


def drive_of(run: Run, name: str = "") -> RecordedDrive:
    """What the base of a run tells of it: what was measured, where the run has that, else the true.

    Wheels' angles are there where the run has counts.
    """
    columns = dict(_told(run))
    remarks = () if POSES[0] in run else ("poses and velocities are the true ones of a run.",)
    return RecordedDrive(name or run.scenario, dict.fromkeys(columns, run.time), columns, remarks)


def _told(run: Run) -> Iterator[tuple[str, FloatArray]]:
    for seen, true in ((POSES, names_of(POSE)), (SPEEDS, names_of(VELOCITY))):
        own = seen if seen[0] in run else true
        for name, source in zip(seen, own, strict=True):
            turned = name == POSES[2]
            yield name, inward(run[source], run.settings.frames) if turned else run[source]
    for name in (*COMMANDS, *TORQUES):
        if name in run:
            yield name, run[name]
    if WHEEL_SPEED.name in run.columns:
        yield from zip(WHEEL_SPEEDS, run[WHEEL_SPEED.name].T, strict=True)
    encoder = tomllib.loads(run.provenance.get("scenario_toml", "")).get("encoder", {})
    if "wheel_counts" in run.columns and encoder.get("counts"):
        turn = 2 * np.pi / encoder["counts"]
        yield from zip(WHEEL_ANGLE, run["wheel_counts"].T * turn, strict=True)
