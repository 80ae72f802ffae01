"""Runs as .csv: JSON in comment lines, a header of ``name [unit]``, one row per sample.

Numbers are written in the shortest form that reads back to the same bits.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence

import numpy as np

from wmr_ctrl.results.metadata import metadata_text, parsed, run_from, signals_in
from wmr_ctrl.results.run import FloatArray, Run
from wmr_ctrl.signals import Signal


def encode(run: Run) -> bytes:
    """The file's bytes, UTF-8."""
    text = io.StringIO()
    text.writelines(f"# {line}\n" for line in metadata_text(run).splitlines())
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([_heading(signal) for signal in run.elements])
    table = np.column_stack([run.columns[signal.name] for signal in run.signals])
    writer.writerows([repr(number) for number in row] for row in table.tolist())
    return text.getvalue().encode()


def decode(data: bytes) -> Run:
    """The run in a file; bytes that hold none raise whatever fits their fault."""
    text = data.decode()
    if not text.endswith("\n"):
        raise ValueError("its last line is not complete")
    lines = text.splitlines()
    comments = [line[1:] for line in lines if line.startswith("#")]
    metadata = parsed("\n".join(comments))
    signals = signals_in(metadata)
    header, *rows = csv.reader(lines[len(comments) :])
    _check_header(header, signals)
    return run_from(metadata, _columns(_table(rows, len(header)), signals))


def _heading(signal: Signal) -> str:
    return f"{signal.name} [{signal.unit}]"


def _check_header(header: Sequence[str], signals: Iterable[Signal]) -> None:
    pairs = (pair for s in signals for pair in zip(s.elements, s.units, strict=True))
    wanted = [f"{name} [{unit}]" for name, unit in pairs]
    if list(header) != wanted:
        raise ValueError("its header row does not name the columns of its description")


def _table(rows: Iterable[Sequence[str]], width: int) -> FloatArray:
    """The numbers, shape (N, width)."""
    numbers = []
    for count, row in enumerate(rows, start=1):
        if len(row) != width:
            raise ValueError(f"row {count} has {len(row)} of {width} numbers")
        numbers.append([float(cell) for cell in row])
    return np.array(numbers, dtype=np.float64).reshape(-1, width)


def _columns(table: FloatArray, signals: Iterable[Signal]) -> dict[str, FloatArray]:
    columns, first = {}, 0
    for signal in signals:
        part = table[:, first : first + signal.size]
        columns[signal.name] = part[:, 0] if signal.size == 1 else part
        first += signal.size
    return columns
