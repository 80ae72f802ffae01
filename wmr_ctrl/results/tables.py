"""Columns over time from a table of a robot's drive, with separate times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from wmr_ctrl.core.errors import ResultFileError, WmrError
from wmr_ctrl.core.fields.files import note_input
from wmr_ctrl.core.fields.tables import Table, TableReader
from wmr_ctrl.core.signals import TIME

from .run import Floats

SUFFIXES = (".csv", ".tsv", ".txt")
MOST_BYTES = 2**31
LATEST_START = 1e5
"""Time of a first row from which on times count from that row [s]: a clock of days or years."""
REMEDY = (
    'Say which is which, with its unit, as in --columns "t=time_ms [ms]" v_command=cmd_v, or name '
    "them so."
)
Timed = tuple[dict[str, Floats], dict[str, Floats], tuple[str, ...]]
"""Times and values of columns by name, and remarks."""


def is_table(path: str | Path) -> bool:
    """True if a file looks like a table, and not like a saved run."""
    if Path(path).suffix.lower() not in SUFFIXES:
        return False
    try:
        with Path(path).open(encoding="utf-8", errors="replace") as file:
            return file.read(3) != "# {"
    except OSError:
        return False


def reader_of(
    place: str,
    known: Mapping[str, str],
    columns: Mapping[str, str] | None,
    error: type[WmrError] = ResultFileError,
) -> TableReader:
    """Reader of a table over time; ``known`` has the unit of each column except the times."""
    known = {TIME.name: TIME.unit, **known}
    return TableReader(place, known, (TIME.name,), error, columns or {}, remedy=REMEDY)


def read_table(path: Path, reader: TableReader) -> Table:
    """Read the columns of a file; raises the reader's error."""
    note_input(path, "table")
    try:
        if path.stat().st_size > MOST_BYTES:
            raise reader.error(f"{reader.place} is larger than 2 GiB. Cut it into pieces.")
        with path.open(newline="", encoding="utf-8") as file:
            return reader.read(file)
    except (OSError, UnicodeDecodeError) as error:
        raise reader.error(f"{reader.place} cannot be read as UTF-8 text ({error}).") from None


def timed(table: Table, reader: TableReader, together: Sequence[Sequence[str]]) -> Timed:
    """Columns without empty cells; of the columns ``together``, rows with an empty cell are
    removed.
    """
    values = {name: np.frombuffer(column) for name, column in table.columns.items()}
    t = values.pop(TIME.name)
    if t.size and t[0] > LATEST_START:
        t = t - t[0]
    values = {name: column for name, column in values.items() if not np.isnan(column + t).all()}
    there = {}
    for name, column in values.items():
        group = next((item for item in together if name in item), ())
        beside = (values[other] for other in group if other in values)
        there[name] = ~np.isnan([t, column, *beside]).any(axis=0)
    if not there:
        raise reader.error(f"{reader.place} has no rows of numbers under its header.")
    remarks = [f"{reader.place}: not read: {', '.join(table.unread)}."] if table.unread else []
    if table.cut:
        remarks.append(f"{reader.place}: line {table.cut} is cut off, and left out.")
    times = {name: t[mask] for name, mask in there.items()}
    return times, {name: values[name][mask] for name, mask in there.items()}, tuple(remarks)
