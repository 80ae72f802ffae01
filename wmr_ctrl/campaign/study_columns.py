"""The table of a study by columns, as .parquet: read from table.csv in blocks, in little memory.

Read by pandas, Polars, DuckDB and others as it is; pyarrow writes it, and is imported here alone.
"""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

from wmr_ctrl.errors import ResultFileError
from wmr_ctrl.results import atomic_path
from wmr_ctrl.results.frames import library

TEXTS, COUNTS = ("law", "outcome", "refusal"), ("index", "seed")


def write_columns(folder: str | Path) -> Path:
    """Write table.parquet beside a study's table.csv, whole or not at all; returns its path.

    Numbers are doubles, empty cells null; index and seed whole numbers, guard a Boolean, lists of
    a grid their JSON text.  Raises ResultFileError where no study is finished or the file cannot be
    written, MissingExtraError without pyarrow.
    """
    where = Path(folder)
    arrow: Any = library("pyarrow")
    read, write = library("pyarrow.csv"), library("pyarrow.parquet")
    named = {"string": arrow.string(), "int64": arrow.int64(), "bool": arrow.bool_(),
             "double": arrow.float64()}  # fmt: skip
    kinds = {name: named[kind] for name, kind in _kinds(where).items()}
    options = read.ConvertOptions(column_types=kinds, strings_can_be_null=False)
    target = where / "table.parquet"
    with (
        atomic_path(target) as scratch,
        read.open_csv(where / "table.csv", convert_options=options) as blocks,
        write.ParquetWriter(scratch, blocks.schema) as file,
    ):
        for block in blocks:
            file.write_batch(block)
    return target


def _kinds(folder: Path) -> dict[str, str]:
    """What each column of the table holds."""
    try:
        plan = json.loads((folder / "study.json").read_text(encoding="utf-8"))["plan"]
        with (folder / "table.csv").open(newline="", encoding="utf-8") as file:
            names = next(csv.reader(file))
    except (OSError, ValueError, KeyError, StopIteration):
        raise ResultFileError(
            f"{str(folder)!r} holds no finished study. Name the folder of `wmr-ctrl study --out`, "
            "once it has its table.csv."
        ) from None
    kinds = dict.fromkeys(names, "double") | dict.fromkeys(TEXTS, "string")
    kinds |= dict.fromkeys(COUNTS, "int64") | {"guard": "bool"}
    for key, values in plan["grid"].items():
        numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in values)
        kinds[key] = "double" if numbers else "string"
    return kinds
