"""Compare another tool's result with the reference result of one of our FMUs.

    python -m tests.importers.match result.csv wmr_plant.fmi2.fmu

Exit code 0: every common column agrees at every common instant; 1: one does not; 2: there is
nothing to compare.  Only the standard library is used, so that it runs beside any tool.
"""

from __future__ import annotations

import argparse
import csv
import io
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path

REFERENCE = "extra/org.wmr-ctrl/reference.csv"
SAME_TIME = 1e-5
"""Times [s] that are equal to so much are the same instant."""
LEAST = 10
"""Fewer common instants are no comparison."""


@dataclass(frozen=True)
class Table:
    """Times [s] and columns of a result."""

    times: list[float]
    columns: dict[str, list[float]]


class NothingToCompareError(Exception):
    """A file that is not a result, or two that have no columns or instants in common."""


def read(path):
    """A result in a CSV file, or the reference result inside of an FMU.

    Its first column, or that named time, is the time.
    """
    try:
        if zipfile.is_zipfile(path):
            with zipfile.ZipFile(path) as archive:
                text = archive.read(REFERENCE).decode()
        else:
            text = path.read_text(encoding="utf-8")
        names, *rows = (row for row in csv.reader(io.StringIO(text)) if row)
        names = [name.strip().strip('"') for name in names]
        numbers = zip(*(map(float, row) for row in rows), strict=True)
        columns = {name: list(column) for name, column in zip(names, numbers, strict=True)}
    except (OSError, KeyError, ValueError) as error:  # UnicodeDecodeError is a ValueError
        raise NothingToCompareError(f"{path} is no table of numbers: {error}.") from None
    return Table(columns.pop("time" if "time" in columns else names[0]), columns)


def pairs(found, wanted):
    """Rows of the same instant.

    A tool may write two rows for an instant with a sample: the last one counts.
    """
    last = {round(time / SAME_TIME): i for i, time in enumerate(found)}
    places = (last.get(round(time / SAME_TIME)) for time in wanted)
    return [(i, k) for k, i in enumerate(places) if i is not None]


def differences(found, wanted, only=()):
    """Largest difference of each common column, in its unit."""
    asked = set(only) or set(wanted.columns)
    common = [name for name in wanted.columns if name in asked and name in found.columns]
    if missing := set(only) - set(common):
        raise NothingToCompareError(f"{', '.join(sorted(missing))}: not in both results.")
    rows = pairs(found.times, wanted.times)
    if not common or len(rows) < LEAST:
        raise NothingToCompareError(
            f"{len(common)} common columns at {len(rows)} common instants: nothing to compare. The "
            f"result has {', '.join(found.columns)}."
        )
    return {
        name: max(abs(found.columns[name][i] - wanted.columns[name][k]) for i, k in rows)
        for name in common
    }


def main(arguments=None):
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("result", type=Path)
    parser.add_argument("reference", type=Path, help="one of our FMUs, or a CSV file")
    parser.add_argument("--tolerance", type=float, default=1e-9, help="in each column's unit")
    parser.add_argument("--columns", nargs="*", default=[], help="only these; all must be there")
    given = parser.parse_args(arguments)
    try:
        worst = differences(read(given.result), read(given.reference), given.columns)
    except NothingToCompareError as error:
        print(error, file=sys.stderr)
        return 2
    for name, difference in sorted(worst.items(), key=lambda item: -item[1]):
        print(f"{name:24} {difference:.3g}")
    kept = all(difference <= given.tolerance for difference in worst.values())
    print(f"{'AGREES' if kept else 'DIFFERS'} to {given.tolerance:g} in {len(worst)} columns")
    return 0 if kept else 1


if __name__ == "__main__":
    sys.exit(main())
