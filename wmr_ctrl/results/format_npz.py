"""Runs as .npz: one array per column, for ``numpy.load``, and the rest as JSON in ``run.json``."""

from __future__ import annotations

import io
import zipfile

import numpy as np

from wmr_ctrl.results.metadata import metadata_text, parsed, run_from, signals_in
from wmr_ctrl.results.run import FloatArray, Run

_METADATA = "run.json"


def encode(run: Run) -> bytes:
    """The archive's bytes, the same for equal runs whenever they are written."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        # ZipInfo without a date writes 1980, so that the bytes do not depend on the clock.
        archive.writestr(zipfile.ZipInfo(_METADATA), metadata_text(run))
        for signal in run.signals:
            name = zipfile.ZipInfo(f"{signal.name}.npy")
            archive.writestr(name, _array_bytes(run.columns[signal.name]))
    return buffer.getvalue()


def decode(data: bytes) -> Run:
    """The run in an archive; bytes that are none raise whatever fits their fault."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        if sum(item.file_size for item in archive.infolist()) > len(data):
            raise ValueError("it says to hold more than its own size, and runs are not compressed")
        metadata = parsed(archive.read(_METADATA))
        names = [signal.name for signal in signals_in(metadata)]
        columns = {name: _array(archive.read(f"{name}.npy")) for name in names}
    return run_from(metadata, columns)


def _array_bytes(values: FloatArray) -> bytes:
    buffer = io.BytesIO()
    np.lib.format.write_array(buffer, values, allow_pickle=False)
    return buffer.getvalue()


def _array(data: bytes) -> FloatArray:
    array = np.lib.format.read_array(io.BytesIO(data), allow_pickle=False)
    if array.dtype != np.float64:
        raise ValueError(f"a column holds {array.dtype}, not double precision")
    return np.asarray(array, dtype=np.float64)
