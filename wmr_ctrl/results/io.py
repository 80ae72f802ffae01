"""Saving and loading runs; the suffix of the path chooses the format."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np

from wmr_ctrl.errors import MissingExtraError, ResultFileError
from wmr_ctrl.fields.arguments import checks_arguments
from wmr_ctrl.results import format_csv, format_npz, format_parquet
from wmr_ctrl.results.files import atomic_write
from wmr_ctrl.results.metadata import metadata_text
from wmr_ctrl.results.run import FloatArray, Run

_ENCODERS: dict[str, Callable[[Run], bytes]] = {
    ".npz": format_npz.encode,
    ".csv": format_csv.encode,
    ".parquet": format_parquet.encode,
}
_DECODERS: dict[str, Callable[[bytes], Run]] = {
    ".npz": format_npz.decode,
    ".csv": format_csv.decode,
    ".parquet": format_parquet.decode,
}


@checks_arguments
def save_run(run: Run, path: str | os.PathLike[str]) -> None:
    """Write ``run`` to a .npz, .csv or .parquet file, whole or not at all.

    Raises ResultFileError for another suffix or where the file cannot be written,
    MissingExtraError for .parquet without pyarrow.
    """
    data = _ENCODERS[check_suffix(path)](run)
    with atomic_write(path) as file:
        file.write(data)


@checks_arguments
def load_run(path: str | os.PathLike[str]) -> Run:
    """Read a run that `Run.save` wrote; it compares equal to the one that was saved.

    Raises ResultFileError where the file is missing, damaged, or something else.
    """
    decode = _DECODERS[check_suffix(path)]
    data = _content(path)
    try:
        return decode(data)
    except MissingExtraError:
        raise
    except Exception as error:  # foreign bytes can break a decoder in any way
        detail = " ".join(f"{type(error).__name__}: {error}".split())[:300]
        raise ResultFileError(
            f"{os.fspath(path)!r} is not a run that this release saved, or it is damaged "
            f"({detail}). Save the run again."
        ) from error


@checks_arguments
def runs_equal(run_a: Run, run_b: Run) -> bool:
    """Whether two runs are the same in every bit, description included.

    Unlike with ==, a NaN equals a NaN, and 0.0 differs from -0.0.
    """
    return metadata_text(run_a) == metadata_text(run_b) and all(
        _same_bits(run_a.columns[name], run_b.columns[name]) for name in run_a.columns
    )


def check_suffix(path: str | os.PathLike[str]) -> str:
    """The lower-case suffix of ``path``; raises ResultFileError unless runs can be saved so."""
    suffix = Path(path).suffix.lower()
    if suffix not in _ENCODERS:
        raise ResultFileError(
            f"{os.fspath(path)!r} has the suffix {suffix!r}; runs are saved as "
            f"{' or '.join(_ENCODERS)}. Give the file one of these suffixes."
        )
    return suffix


def _content(path: str | os.PathLike[str]) -> bytes:
    try:
        return Path(path).read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise ResultFileError(
            f"cannot read {os.fspath(path)!r}: {reason}. Give the path of a saved run."
        ) from error


def _same_bits(a: FloatArray, b: FloatArray) -> bool:
    same = (a == b) & (np.signbit(a) == np.signbit(b)) | np.isnan(a) & np.isnan(b)
    return a.shape == b.shape and bool(same.all())
