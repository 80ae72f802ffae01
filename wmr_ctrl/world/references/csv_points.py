"""Waypoints from a CSV file: one point a row, x and y in m, perhaps a header that names them."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterator
from pathlib import Path

from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.fields.files import read_text
from wmr_ctrl.fields.problems import show

Point = tuple[float, float]
LARGEST_PATH = 10_000_000
"""Bytes; a planner's path has some fifty a point."""
AXES = ("x", "y")
NAME = re.compile(r"([xyXY])\s*(?:\[\s*m\s*\]|\(\s*m\s*\))?")
"""Of a column: x or y, perhaps with m in brackets or parentheses."""
AXIS = re.compile(r"[xy](?![a-z]).*", re.IGNORECASE | re.DOTALL)
"""What begins as the name of an axis does, whatever unit or frame follows."""
SAME = 1e-9
"""Points nearer to each other than this, m, are the same."""


def read_points(file: Path, path: str = "reference.file") -> tuple[Point, ...]:
    """Return the points of a CSV file; blank rows and rows that start with ``#`` are skipped.

    A header says which column is x and which is y; without one, x comes first.  It may stand in a
    comment, as NumPy's `savetxt` writes it.
    Raises ScenarioError, starting with the key ``path`` and naming row and column from 1.
    """
    numbered = list(_rows(read_text(file, path, LARGEST_PATH), f"{path}: {file.name}"))
    order = _without_headers(numbered, f"{path}: {file.name}")
    points = [_point(cells, order, f"{path}: {file.name}, row {row}") for row, cells in numbered]
    if len(points) < 2:
        raise ScenarioError(
            f"{path}: {file.name} holds {len(points)} point(s), but a path needs at least 2. "
            "Give one point a row, as x,y in m."
        )
    _refuse_twins(points, [row for row, _ in numbered], f"{path}: {file.name}")
    return tuple(points)


def _rows(text: str, place: str) -> Iterator[tuple[int, list[str]]]:
    reader, begun = csv.reader(io.StringIO(text), skipinitialspace=True), False
    try:
        for cells in reader:
            stripped = [cell.strip() for cell in cells]
            if not begun:
                stripped = _uncommented(stripped)
            if any(stripped) and not stripped[0].startswith("#"):
                begun = True
                yield reader.line_num, stripped
    except csv.Error as problem:
        raise ScenarioError(f"{place}, row {reader.line_num}: {problem}. Save it as CSV.") from None


def _uncommented(cells: list[str]) -> list[str]:
    """A comment of two cells that name axes, without its ``#``; other rows as they are."""
    names = [cells[0].lstrip("# "), *cells[1:]] if cells else []
    return names if len(names) == 2 and all(map(AXIS.fullmatch, names)) else cells


def _number(cell: str) -> float | None:
    try:
        return float(cell)
    except ValueError:
        return None


def _is_header(cells: list[str]) -> bool:
    return all(cell and _number(cell) is None for cell in cells)


def _without_headers(numbered: list[tuple[int, list[str]]], place: str) -> tuple[int, int]:
    """Columns of x and y by the headers, which are taken out: one, or a comment's and one."""
    orders = []
    while numbered and _is_header(numbered[0][1]):
        row, header = numbered.pop(0)
        _check_width(header, f"{place}, row {row}")
        orders.append(_order_of(header, f"{place}, row {row}"))
        if orders[0] != orders[-1]:
            raise ScenarioError(
                f"{place}, row {row}: the header contradicts the one above it. Keep the one that "
                "is right."
            )
    return orders[0] if orders else (0, 1)


def _order_of(header: list[str], place: str) -> tuple[int, int]:
    """Columns of x and y, from 0, in a header of two names."""
    matches = [NAME.fullmatch(cell) for cell in header]
    names = [match[1].lower() if match else "" for match in matches]
    if sorted(names) != list(AXES):
        raise ScenarioError(
            f"{place}: the header says {' and '.join(map(show, header))}, but x and y in m are "
            "expected. Name the columns x and y, in either order, perhaps with the unit as in "
            "x [m], and give the coordinates in m."
        )
    return names.index("x"), names.index("y")


def _check_width(cells: list[str], place: str) -> None:
    if len(cells) != 2:
        raise ScenarioError(
            f"{place} has {len(cells)} column(s), but a point needs two, x and y in m. Separate "
            "them by a comma, with a point as the decimal sign."
        )


def _point(cells: list[str], order: tuple[int, int], place: str) -> Point:
    _check_width(cells, place)
    x, y = (_coordinate(cells[i], f"{place}, column {i + 1}") for i in order)
    return x, y


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
