"""Runs as .parquet: a column per logged number, and the rest as JSON in the file's metadata.

Read by pandas, Polars, DuckDB and others as it is; pyarrow writes it, and is imported here alone.
"""

from __future__ import annotations

import io

import numpy as np

from wmr_ctrl.fields.limits import may_unpack
from wmr_ctrl.results.frames import library
from wmr_ctrl.results.metadata import metadata_text, parsed, run_from, signals_in
from wmr_ctrl.results.run import Run

_METADATA = b"wmr_ctrl"


def encode(run: Run) -> bytes:
    """The file's bytes.  Raises MissingExtraError without pyarrow."""
    arrow, parquet = library("pyarrow"), library("pyarrow.parquet")
    table = arrow.table({signal.name: run[signal.name] for signal in run.elements})
    table = table.replace_schema_metadata({_METADATA: metadata_text(run)})
    buffer = io.BytesIO()
    parquet.write_table(table, buffer)
    return buffer.getvalue()


def decode(data: bytes) -> Run:
    """The run in a file.  Raises MissingExtraError; bytes that hold none raise what fits."""
    file = library("pyarrow.parquet").ParquetFile(io.BytesIO(data))
    numbers = file.metadata.num_rows * file.metadata.num_columns
    if not may_unpack(len(data), np.dtype(float).itemsize * numbers):
        raise ValueError(f"it says to hold {numbers} numbers, more than its size can be true of")
    table = file.read()
    metadata = parsed((table.schema.metadata or {}).get(_METADATA, b"null"))
    columns = {}
    for signal in signals_in(metadata):
        parts = [np.asarray(table[name].to_numpy(), float) for name in signal.elements]
        columns[signal.name] = parts[0] if signal.size == 1 else np.column_stack(parts)
    return run_from(metadata, columns)
