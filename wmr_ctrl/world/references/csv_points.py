"""Waypoints from a CSV file: one point a row, perhaps a header that names x and y and their unit.

Cells are separated by commas, semicolons, tabs or blanks; where it is not commas, a comma is a
decimal sign.  Of more than two columns a header must say which are x and y.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.fields.files import read_text
from wmr_ctrl.fields.problems import show

Point = tuple[float, float]
SUFFIXES = (".csv", ".tsv", ".txt", ".yaml", ".yml")
"""Of a path's file: the last two are `path_yaml`'s."""
LARGEST_PATH = 10_000_000
"""Bytes; a planner's path has some fifty a point."""
AXES = ("x", "y")
UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "km": 1e3}
"""Units that a header may state, in m."""
_UNIT = "|".join(UNITS)
NAME = re.compile(rf"([xyXY])\s*(?:\[\s*({_UNIT})\s*\]|\(\s*({_UNIT})\s*\)|_({_UNIT}))?")
"""Of a column: x or y, perhaps with a unit in brackets or parentheses, or after an underscore."""
AXIS = re.compile(r"[xy](?![a-z]).*", re.IGNORECASE | re.DOTALL)
"""What begins as the name of an axis does, whatever unit or frame follows."""
SAME = 1e-9
"""Points nearer to each other than this, m, are the same."""


@dataclass(frozen=True)
class Columns:
    """Where x and y stand, from 0, of how many cells, and the unit of each [m]."""

    x: int = 0
    y: int = 1
    width: int = 2
    units: tuple[float, float] = (1.0, 1.0)
    named: bool = False


def read_points(file: Path, path: str = "reference.file") -> tuple[Point, ...]:
    """Return the points of a CSV file [m]; blank rows and those that start with ``#`` are skipped.

    A header says which column is x and which is y, and perhaps their unit; without one, x comes
    first and both are in m.  It may stand in a comment, as NumPy's `savetxt` writes it.
    Raises ScenarioError, starting with the key ``path`` and naming row and column from 1.
    """
    place = f"{path}: {file.name}"
    numbered = list(_rows(read_text(file, path, SUFFIXES, LARGEST_PATH), place))
    columns = _without_headers(numbered, place)
    points = [_point(cells, columns, f"{place}, row {row}") for row, cells in numbered]
    if len(points) < 2:
        raise ScenarioError(
            f"{place} holds {len(points)} point(s), but a path needs at least 2. "
            "Give one point a row, as x,y in m."
        )
    _refuse_twins(points, [row for row, _ in numbered], place)
    return tuple(points)


def _separator(text: str) -> str:
    """What separates the cells of the first row that is not a comment: the strongest sign in it."""
    rows = (row for row in text.splitlines() if row.strip() and not row.startswith("#"))
    first = next(rows, "").strip()
    return next((sign for sign in ";\t, " if sign in first), ",")


def _rows(text: str, place: str) -> Iterator[tuple[int, list[str]]]:
    """Number and cells of each row that holds something, with a point as the decimal sign."""
    separator, begun = _separator(text), False
    reader = csv.reader(io.StringIO(text), delimiter=separator, skipinitialspace=True)
    try:
        for cells in reader:
            stripped = [cell.strip() for cell in cells]
            if separator == " ":
                stripped = [cell for cell in stripped if cell]
            if not begun:
                stripped = _uncommented(stripped)
            if any(stripped) and not stripped[0].startswith("#"):
                begun = True
                decimal = separator != ","
                yield reader.line_num, [c.replace(",", ".") if decimal else c for c in stripped]
    except csv.Error as problem:
        raise ScenarioError(f"{place}, row {reader.line_num}: {problem}. Save it as CSV.") from None


def _uncommented(cells: list[str]) -> list[str]:
    """A comment whose first two cells name axes, without its ``#``; other rows as they are."""
    names = [name for name in (cells[0].lstrip("# "), *cells[1:]) if name] if cells else []
    return names if len(names) > 1 and all(map(AXIS.fullmatch, names[:2])) else cells


def _number(cell: str) -> float | None:
    try:
        return float(cell)
    except ValueError:
        return None


def _is_header(cells: list[str]) -> bool:
    return all(cell and _number(cell) is None for cell in cells)


def _without_headers(numbered: list[tuple[int, list[str]]], place: str) -> Columns:
    """The columns by the headers, which are taken out: one, or a comment's and one."""
    orders = []
    while numbered and _is_header(numbered[0][1]):
        row, header = numbered.pop(0)
        orders.append(_columns_of(header, f"{place}, row {row}"))
        if orders[0] != orders[-1]:
            raise ScenarioError(
                f"{place}, row {row}: the header contradicts the one above it. Keep the one that "
                "is right."
            )
    return orders[0] if orders else Columns()


def _columns_of(header: list[str], place: str) -> Columns:
    """The columns that a header names."""
    matches = {i: match for i, cell in enumerate(header) if (match := NAME.fullmatch(cell))}
    by_axis = {axis: [i for i in matches if matches[i][1].lower() == axis] for axis in AXES}
    if any(len(places) != 1 for places in by_axis.values()):
        raise ScenarioError(
            f"{place}: the header says {', '.join(map(show, header))}, but one x and one y are "
            "expected. Name these columns x and y, in either order, perhaps with the unit, as in "
            f"x [m]; known: {', '.join(UNITS)}."
        )
    (x,), (y,) = by_axis.values()
    units = [UNITS[next(filter(None, matches[i].groups()[1:]), "m")] for i in (x, y)]
    return Columns(x, y, len(header), (units[0], units[1]), named=True)


def _check_width(cells: list[str], columns: Columns, place: str) -> None:
    count = len(cells)
    if count == columns.width:
        return
    if columns.named:
        raise ScenarioError(
            f"{place} has {count} column(s), and the header {columns.width}. Complete the row."
        )
    if count < columns.width:
        raise ScenarioError(
            f"{place} has {count} column(s), but a point needs two, x and y in m. Separate them by "
            "a comma, or by a semicolon where the comma is a decimal sign."
        )
    raise ScenarioError(
        f"{place} has {count} columns, and nothing says which are x and y. Put a header above "
        f"them, such as {'x,y,theta' if count == 3 else 'x,y,...'}, or leave the others out; "
        "where the comma is a decimal sign, separate the columns by semicolons."
    )


def _point(cells: list[str], columns: Columns, place: str) -> Point:
    _check_width(cells, columns, place)
    x, y = (_coordinate(cells[i], f"{place}, column {i + 1}") for i in (columns.x, columns.y))
    return x * columns.units[0], y * columns.units[1]


def _coordinate(cell: str, place: str) -> float:
    value = _number(cell)
    if value is None:
        raise ScenarioError(f"{place}: {show(cell)} is not a number. Give a coordinate in m.")
    if not math.isfinite(value):
        raise ScenarioError(f"{place}: {cell} is not a finite number. Give a coordinate in m.")
    return value


def _refuse_twins(points: list[Point], rows: list[int], place: str) -> None:
    for i in range(1, len(points)):
        if math.dist(points[i - 1], points[i]) < SAME:
            raise ScenarioError(
                f"{place}, rows {rows[i - 1]} and {rows[i]} are the same point {points[i]}: the "
                "path has no direction there. Remove one of them."
            )
