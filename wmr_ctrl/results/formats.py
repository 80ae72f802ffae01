"""Saving and loading of runs; the suffix of the path selects the format.

All data of a run except its columns are one JSON object, which each format stores in its own way:
.npz in ``run.json`` beside an array per column, for ``numpy.load``; .csv in comment lines above a
header of ``name [unit]`` and a row per sample.  A .mcap has only what a base would publish.
"""

import csv
import io
import json
import math
import os
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from wmr_ctrl.core.errors import ResultFileError, library
from wmr_ctrl.core.fields.arguments import check_fields, checks_arguments
from wmr_ctrl.core.fields.files import AnyPath, note_input
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.core.suffixes import BAG, RUNS

from .bag import is_bag, run_as_mcap
from .drive import NEVER
from .files import atomic_write
from .outcomes import Monitor, Outcome, RigidMonitor
from .run import Floats, Run, split_columns
from .settings import Settings

_FORMAT = "wmr_ctrl run, version 1"
_LABELS = ("scenario", "law", "guard", "seed", "engine")
_JSON_MEMBER = "run.json"


@checks_arguments
def save_run(run: Run, path: AnyPath) -> None:
    """Write ``run`` atomically to a file whose suffix is one of `RUNS`.

    Raises ResultFileError for another suffix or if the file cannot be written, MissingExtraError
    for .mcap without rosbags.
    """
    suffix = check_suffix(path)
    data = run_as_mcap(run) if suffix == BAG else _FORMATS[suffix][0](run)
    with atomic_write(path) as file:
        file.write(data)


@checks_arguments
def load_run(path: AnyPath) -> Run:
    """Read a run that `Run.save` wrote; it equals the saved run.

    Raises ResultFileError if the file is missing, damaged, or something else: bags are read by
    `load_drive`.
    """
    if is_bag(Path(path)):
        raise ResultFileError(
            f"{os.fspath(path)!r} is a bag: it has no {NEVER}. Read it by wmr_ctrl.load_drive; its "
            "result names what else is missing."
        )
    _, decode = _FORMATS[check_suffix(path)]
    note_input(path, "run")
    try:
        data = Path(path).read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise ResultFileError(
            f"cannot read {os.fspath(path)!r}: {reason}. Give the path of a saved run."
        ) from error
    try:
        return decode(data)
    except Exception as error:  # foreign bytes can break a decoder in any way
        table = isinstance(error, json.JSONDecodeError) and Path(path).suffix.lower() == ".csv"
        words = " ".join(f"{type(error).__name__}: {error}".split())[:300]
        detail, other = ("", OTHER_TABLES) if table else (f" ({words})", "")
        raise ResultFileError(
            f"{os.fspath(path)!r} is not a run that this release saved, or it is damaged"
            f"{detail}. Save the run again{other}."
        ) from error


OTHER_TABLES = "; a log is read by `wmr-ctrl identify`, a path by reference.file of a scenario"
"""Sentence on other tables that a .csv file may contain."""


def check_suffix(path: AnyPath) -> str:
    """The lower-case suffix of ``path``; raises ResultFileError if no run format has it."""
    suffix = Path(path).suffix.lower()
    if suffix not in RUNS:
        raise ResultFileError(
            f"{os.fspath(path)!r} has the suffix {suffix!r}; runs are saved as "
            f"{' or '.join(RUNS)}. Give the file one of these suffixes."
        )
    return suffix


def check_format(path: AnyPath) -> None:
    """Raise MissingExtraError if the format of ``path`` needs a missing package."""
    if check_suffix(path) == BAG:
        library("rosbags.rosbag2", "logs")


def metadata_text(run: Run) -> str:
    """All of a run except its columns as indented JSON, in ASCII so that no encoding can damage it.

    Floats that JSON cannot express are the texts "inf", "-inf" and "nan".
    """
    metadata = {
        "format": _FORMAT,
        **{name: getattr(run, name) for name in _LABELS},
        "outcome": run.outcome.value,
        "settings": _encoded(asdict(run.settings)),
        "monitor": _encoded(asdict(run.monitor)),
        "provenance": dict(run.provenance),
        "rows": run.rows,
        "signals": [asdict(signal) for signal in run.signals],
    }
    return json.dumps(metadata, indent=2, allow_nan=False)


def _encoded(value: object) -> object:
    if isinstance(value, dict):
        return {key: _encoded(item) for key, item in value.items()}
    if isinstance(value, tuple):
        return [_encoded(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return repr(value)
    return value


def _decoded(value: Any) -> Any:
    """Inverse of `_encoded`."""
    if isinstance(value, dict):
        return {key: _decoded(item) for key, item in value.items()}
    if isinstance(value, list):
        return tuple(map(_decoded, value))
    return float(value) if value in ("inf", "-inf", "nan") else value


def _parsed(text: str | bytes) -> Mapping[str, Any]:
    """The JSON object in a file; raises ValueError unless this release can read it."""
    metadata = json.loads(text)
    if not isinstance(metadata, dict) or metadata.get("format") != _FORMAT:
        raise ValueError(f"its description is not of the format {_FORMAT!r}")
    return metadata


def _signals_in(metadata: Mapping[str, Any]) -> tuple[Signal, ...]:
    return tuple(Signal(**entry) for entry in metadata["signals"])


def _run_from(metadata: Mapping[str, Any], columns: Mapping[str, Floats]) -> Run:
    """The run in a file; raises ValueError if rows are missing, and Run's own errors."""
    settings, seen = Settings(**_decoded(metadata["settings"])), _decoded(metadata["monitor"])
    rigid = seen.pop("rigid")
    monitor = Monitor(**seen, rigid=rigid and RigidMonitor(**rigid))
    for part in (settings, monitor):
        check_fields(part)
    run = Run(
        **{name: metadata[name] for name in _LABELS},
        settings=settings,
        signals=_signals_in(metadata),
        columns=columns,
        monitor=monitor,
        outcome=Outcome(metadata["outcome"]),
        provenance=metadata["provenance"],
    )
    if run.rows != metadata["rows"]:
        raise ValueError(f"it holds {run.rows} of {metadata['rows']} rows")
    return run


def _npz_of(run: Run) -> bytes:
    """Bytes of an archive, equal for equal runs at any time of writing."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        # ZipInfo without a date writes 1980, so that the bytes do not depend on the clock.
        archive.writestr(zipfile.ZipInfo(_JSON_MEMBER), metadata_text(run))
        for signal in run.signals:
            column = io.BytesIO()
            np.lib.format.write_array(column, run.columns[signal.name], allow_pickle=False)
            archive.writestr(zipfile.ZipInfo(f"{signal.name}.npy"), column.getvalue())
    return buffer.getvalue()


def _run_in_npz(data: bytes) -> Run:
    with np.load(io.BytesIO(data), allow_pickle=False) as archive:
        if sum(item.file_size for item in archive.zip.infolist()) > len(data):
            raise ValueError("it claims more than its own size, and runs are not compressed")
        metadata = _parsed(archive[_JSON_MEMBER])
        columns = {signal.name: archive[signal.name] for signal in _signals_in(metadata)}
    for name, column in columns.items():
        if column.dtype != np.float64:
            raise ValueError(f"the column {name} holds {column.dtype}, not double precision")
    return _run_from(metadata, columns)


def _csv_of(run: Run) -> bytes:
    """Bytes of a CSV file in UTF-8, with the shortest decimals that read back to the same bits."""
    text = io.StringIO()
    text.writelines(f"# {line}\n" for line in metadata_text(run).splitlines())
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([f"{signal.name} [{signal.unit}]" for signal in run.elements])
    table = np.column_stack([run.columns[signal.name] for signal in run.signals])
    writer.writerows(table.tolist())
    return text.getvalue().encode()


def _run_in_csv(data: bytes) -> Run:
    text = data.decode()
    if not text.endswith("\n"):
        raise ValueError("its last line is not complete")
    lines = text.splitlines()
    comments = [line[1:] for line in lines if line.startswith("#")]
    metadata = _parsed("\n".join(comments))
    signals = _signals_in(metadata)
    (header,) = csv.reader(lines[len(comments) :][:1])
    rows = lines[len(comments) + 1 :]
    pairs = (pair for signal in signals for pair in zip(signal.elements, signal.units, strict=True))
    if header != [f"{name} [{unit}]" for name, unit in pairs]:
        raise ValueError("its header row does not name the columns of its description")
    table = np.loadtxt(rows, delimiter=",", ndmin=2) if rows else np.empty((0, len(header)))
    if table.shape[1] != len(header):
        raise ValueError(f"its rows have {table.shape[1]} of {len(header)} numbers")
    return _run_from(metadata, split_columns(signals, table))


_FORMATS: Mapping[str, tuple[Callable[[Run], bytes], Callable[[bytes], Run]]] = {
    ".npz": (_npz_of, _run_in_npz),
    ".csv": (_csv_of, _run_in_csv),
}
"""Writer and reader of each suffix."""
