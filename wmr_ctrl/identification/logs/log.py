"""A log: columns by the names of our runs, in SI units, each with the clock that it came with."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.core.errors import ArgumentError, WmrError
from wmr_ctrl.core.fields.files import note_input
from wmr_ctrl.core.fields.tables import Table, TableReader
from wmr_ctrl.core.signals import POSE, VELOCITY, elements
from wmr_ctrl.core.suffixes import RUN_FILE, RUNS
from wmr_ctrl.results import Floats, Run, drive
from wmr_ctrl.results.bag import is_bag
from wmr_ctrl.results.bag_topics import load_source
from wmr_ctrl.results.tables import SUFFIXES as TABLES
from wmr_ctrl.results.tables import is_table, read_table, reader_of, timed
from wmr_ctrl.world.encoder import COUNTS
from wmr_ctrl.world.scenario import Scenario, loads_scenario

Pair = tuple[float, float]
Names = tuple[str, ...]
Texts = tuple[str, ...]
AXES, UNITS = ("v", "omega"), ("m/s", "rad/s")
Mask = NDArray[np.bool_]
BETWEEN = 10.0
"""Time between logs that count as one [s]."""
WHEEL_ANGLE, WHEEL_SPEED = drive.WHEEL_ANGLE, drive.WHEEL_SPEEDS
COMMAND, TORQUES = drive.COMMANDS, drive.TORQUES
CURRENT = ("current_right", "current_left")
VOLTAGE = ("voltage_right", "voltage_left")
SPEEDS = (drive.SPEEDS, elements(VELOCITY))
POSES = (drive.POSES, elements(POSE))
KNOWN: Mapping[str, str] = {
    **drive.UNITS,
    **dict.fromkeys(COUNTS.elements, "1"),
    **dict.fromkeys(CURRENT, "A"),
    **dict.fromkeys(VOLTAGE, "V"),
    **{signal.name: signal.unit for signal in (*POSE, *VELOCITY)},
}
"""Columns that are read, and the unit of each."""
TOGETHER = (
    COUNTS.elements, WHEEL_ANGLE, WHEEL_SPEED, TORQUES, CURRENT, VOLTAGE, COMMAND, *SPEEDS, *POSES,
)  # fmt: skip
"""Columns that come in the same rows."""


def usual_step(t: Floats) -> float:
    """Median time between rows [s]."""
    return float(np.median(np.diff(t)))


def quick(values: Floats, share: float = 0.95) -> float:
    """Size that this share of the values does not exceed."""
    return float(np.quantile(np.abs(values), share))


class LogError(WmrError, ValueError):
    """A log that cannot be read, or that shows a fault."""


class Note(NamedTuple):
    """A remark on a log: a key of ``diagnosis``, the axis if it concerns one, a sentence."""

    key: str
    axis: str
    text: str


class LeftOut(NamedTuple):
    """A stretch of a log that fits leave out [s], and why."""

    begin: float
    end: float
    reason: str


@dataclass(frozen=True)
class Log:
    """Columns by name, each with its own times: a log may contain several sampling rates.

    ``times`` and ``columns`` map a name to (N,) numbers; ``base`` is the scenario that a saved run
    was made with.
    """

    name: str
    times: Mapping[str, Floats]
    columns: Mapping[str, Floats]
    base: Scenario | None = None
    remarks: Texts = ()
    notes: tuple[Note, ...] = ()

    def has(self, names: Sequence[str]) -> bool:
        """True if all of these columns are there."""
        return all(name in self.columns for name in names)

    def scaled(self, names: Names, of: Names, factor: float, *remarks: str) -> "Log":
        """The log with further columns, scaled copies of others, and with remarks."""
        pairs = [*zip(names, of, strict=True)]
        times = {**self.times, **{name: self.times[other] for name, other in pairs}}
        columns = {name: factor * self.columns[other] for name, other in pairs}
        columns = {**self.columns, **columns}
        return replace(self, times=times, columns=columns, remarks=(*self.remarks, *remarks))

    def pair(self, names: Sequence[str]) -> tuple[Floats, Floats]:
        """Times (N,) and values (N, len(names)) of columns with common times."""
        return self.times[names[0]], np.column_stack([self.columns[name] for name in names])


def log_of(
    given: str | Path | Run | drive.RecordedDrive | Mapping[str, list[float]],
    topics: Mapping[str, str] | None = None,
    columns: Mapping[str, str] | None = None,
) -> Log:
    """A log from a file, a run, a drive, or columns by ``name [unit]``.

    ``topics`` are of a bag, by role, and ``columns`` a table's names by ours.  Raises LogError,
    ResultFileError, ArgumentError, MissingExtraError.
    """
    if topics and not isinstance(given, str | Path):
        raise ArgumentError("topics can only be given with the path of a bag. Leave them out.")
    if isinstance(given, Mapping):
        return of_columns("log", given, columns)
    name = ""
    if isinstance(given, str | Path):
        path = Path(given)
        name = path.name
        if is_table(path) and not topics:
            reader = reader_of(name, KNOWN, columns, LogError)
            return _of_table(read_table(path, reader), reader)
        given = _loaded(path, topics)
    if columns:
        raise ArgumentError("columns can only be given with a table. Leave them out.")
    if isinstance(given, drive.RecordedDrive):
        return Log(given.name, given.times, given.columns, None, given.remarks)
    read = {key: given[key] for key in (s.name for s in given.elements) if key in KNOWN}
    text = given.provenance.get("scenario_toml")
    base = None if text is None else loads_scenario(text)
    return Log(name or given.scenario, dict.fromkeys(read, given.time), read, base)


def joined(logs: Sequence[Log]) -> Log:
    """Join several logs of one robot, with rest and no commands between them.

    Raises LogError if no column is in all of them.
    """
    if len(logs) == 1:
        return logs[0]
    names = [name for name in logs[0].columns if all(log.has([name]) for log in logs)]
    if not names:
        raise LogError("no column is in all of these logs. Give logs with the same columns.")
    times, columns, begin = dict[str, Floats](), dict[str, Floats](), 0.0
    for log in logs:
        ends = [log.times[name][[0, -1]] for name in names]
        first, last = np.min(ends), np.max(ends)
        for name in names:
            rest = [begin - BETWEEN / 2] if name in (*COMMAND, *TORQUES) else []
            own, values = [*rest, *(log.times[name] - first + begin)], log.columns[name]
            times[name] = np.append(times.get(name, []), own)
            columns[name] = np.append(columns.get(name, []), [*np.zeros(len(rest)), *values])
        begin += float(last - first) + BETWEEN
    remarks = dict.fromkeys(text for log in logs for text in log.remarks)
    name = ", ".join(log.name for log in logs)
    return Log(name, times, columns, logs[0].base, tuple(remarks))


def _loaded(path: Path, topics: Mapping[str, str] | None) -> Run | drive.RecordedDrive:
    """A saved run or a bag."""
    note_input(path, "log")
    if not (is_bag(path) or topics or path.suffix.lower() in RUNS):
        raise LogError(
            f"{str(path)!r} is no log by its name; a log is a table ({', '.join(TABLES)}), a ROS "
            "bag (.mcap, .db3, .bag, or a folder that has a metadata.yaml), or a saved run "
            f"({RUN_FILE})."
        )
    return load_source(path, topics)


def of_columns(
    name: str, columns: Mapping[str, Sequence[float]], theirs: Mapping[str, str] | None = None
) -> Log:
    """A log from columns by header (``name`` or ``name [unit]``), all of one length."""
    if len({len(values) for values in columns.values()}) != 1:
        raise ArgumentError("log: all columns must have the same length.")
    reader = reader_of(name, KNOWN, theirs, LogError)
    return _of_table(reader.scaled(columns), reader)


def _of_table(table: Table, reader: TableReader) -> Log:
    times, columns, remarks = timed(table, reader, TOGETHER)
    for group in TOGETHER:
        own = [item for item in group if item in columns]
        if 0 < len(own) < len(group):
            raise LogError(
                f"{reader.place}: {', '.join(group)} belong together, in the same rows; there "
                f"{'is' if len(own) == 1 else 'are'} {', '.join(own)}."
            )
    return Log(reader.place, times, columns, None, remarks)


def with_torques(log: Log, constant: float | None, resistance: float | None = None) -> Log:
    """The log with torques computed from motor currents or voltages.

    ``constant``: newton metres at a wheel per ampere; ``resistance`` of a motor [ohm], for
    voltages. Raises ArgumentError if one is not positive, or no column needs it; LogError if there
    are only currents or voltages and one is missing.
    """
    source: Names = next((names for names in (CURRENT, VOLTAGE) if log.has(names)), ())
    for name, value in {"torque_constant": constant, "resistance": resistance}.items():
        if value is not None and not 0 < value < math.inf:
            raise ArgumentError(f"{name} = {value:g} must be positive and finite.")
        if value is not None and (not source or (name == "resistance" and source == CURRENT)):
            needs = VOLTAGE if name == "resistance" else (*CURRENT, *VOLTAGE)
            raise ArgumentError(f"{name} is for {' or '.join(needs)}, which {log.name} lacks.")
    if constant is None or (source == VOLTAGE and resistance is None):
        if source and not log.has(TORQUES):
            raise LogError(
                f"{log.name} has no torques but {' and '.join(source)}. Give the torque at the "
                "wheel per ampere, gear included, as in --torque-constant 0.6, and for voltages "
                "the motor's --resistance too. If you do not know them, give 1: delay and lag come "
                "out right, but m, I and friction come out divided by that torque, so do not run "
                "such a scenario."
            )
        return log
    factor = constant if source == CURRENT else constant / (resistance or 1.0)
    said = (
        f"torques are {' and '.join(source)} times {factor:.4g}: an error of that factor "
        "scales m, I and all frictions, and no interval contains it; delay and lag do not depend "
        "on it."
    )
    if source == VOLTAGE:
        said += " What the motors induce as they turn counts as viscous friction."
    return log.scaled(TORQUES, source, factor, said)


MOST_COUNTS = 1_000_000
"""Counts of a turn where angles show no steps."""


def with_counts(log: Log, counts: float | None) -> tuple[Log, float | None]:
    """The log with wheel angles converted to counts, and the number of counts per turn.

    If ``counts`` is None, the smallest step of the angles is one count.
    """
    if log.has(COUNTS.elements) or not log.has(WHEEL_ANGLE):
        return log, counts
    remarks = []
    if counts is None:
        step = np.abs(np.diff([log.columns[name] for name in WHEEL_ANGLE]))
        least = float(step.min(where=step > 2 * math.pi / MOST_COUNTS, initial=2 * math.pi))
        counts = float(round(2 * math.pi / least))
        remarks = [
            f"the smallest step of the wheels' angles makes {counts:g} counts a turn; if that is "
            "not so, say it by --set encoder.counts=N."
        ]
    return log.scaled(COUNTS.elements, WHEEL_ANGLE, counts / (2 * math.pi), *remarks), counts


def seen_by(log: Log) -> str:
    """Name of the columns that show the motion: counts before speeds, measured before true."""
    if log.has(COUNTS.elements):
        return COUNTS.name
    if log.has(WHEEL_SPEED):
        return "wheel_speed"
    for pair in SPEEDS:
        if log.has(pair):
            return pair[0]
    raise LogError(
        f"{log.name}: no column shows the motion. It needs {' and '.join(COUNTS.elements)} "
        f"(encoder counts), {' and '.join(WHEEL_SPEED)}, {' and '.join(SPEEDS[0])} or "
        f"{' and '.join(SPEEDS[1])}; poses alone are not enough."
    )


FACTORS = {
    57.29577951308232: "degrees for radians", 9.549296585513721: "revolutions a minute for rad/s",
    1000.0: "millimetres for metres", 100.0: "per cent for a share", 3.6: "km/h for m/s",
    4.0: "a quarter of the counts in a turn (or all four edges)",
}  # fmt: skip
NEAR = 0.08
"""Tolerance within which a ratio is named after one of these factors."""


def unit_of(ratio: float, near: float = NEAR) -> str | None:
    """Units that may have been confused if two columns have about this ratio."""
    size = max(ratio, 1 / ratio) if ratio > 0 else 0.0
    factor = min(FACTORS, key=lambda item: abs(size / item - 1))
    if abs(size / factor - 1) > near:
        return None
    word = FACTORS[factor]
    return word if ratio > 1 else " for ".join(reversed(word.split(" for ")))
