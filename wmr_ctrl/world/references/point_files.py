"""Waypoints from a file: CSV, one point a row, or YAML, as navigation stacks print a path.

CSV: perhaps a header that names x and y and their unit.  Cells are separated by commas, semicolons,
tabs or blanks; where it is not commas, a comma is a decimal sign.  Of more than two columns a
header must say which are x and y.

YAML: a list of poses, or a mapping with the key ``poses`` (or ``path`` above it).  A pose is a
mapping with x and y in m, perhaps below ``position`` and that below ``pose``; headers, z and
orientations are passed over, since the path's direction follows from its points.
"""

import csv
import io
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from wmr_ctrl.core.errors import ScenarioError, show
from wmr_ctrl.core.fields.files import read_text
from wmr_ctrl.core.fields.yaml_text import yaml_document

Point = tuple[float, float]
KEY = "reference.file"
SUFFIXES = (".csv", ".tsv", ".txt", ".yaml", ".yml")
"""Suffixes of a path's file: the last two are `path_yaml`'s."""
LARGEST_PATH = 10_000_000
"""Bytes; a planner's path has some fifty a point."""
AXES = ("x", "y")
UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "km": 1e3}
"""Units that a header may state, in m."""
_UNIT = "|".join(UNITS)
NAME = re.compile(rf"([xyXY])\s*(?:\[\s*({_UNIT})\s*\]|\(\s*({_UNIT})\s*\)|_({_UNIT}))?")
"""Pattern of a column's name: x or y, perhaps with a unit in brackets or parentheses, or after an
underscore.
"""
AXIS = re.compile(r"[xy](?![a-z]).*", re.IGNORECASE | re.DOTALL)
"""Text that begins as the name of an axis does, whatever unit or frame follows."""
SAME = 1e-9
"""Points nearer to each other than this, m, are the same."""


@dataclass(frozen=True)
class Columns:
    """Columns of x and y, from 0, the width of a row, and the unit of each [m]."""

    x: int = 0
    y: int = 1
    width: int = 2
    units: tuple[float, float] = (1.0, 1.0)
    named: bool = False


def read_points(file: Path) -> tuple[Point, ...]:
    """Return the points of a CSV file [m]; blank rows and those that start with ``#`` are skipped.

    A header says which column is x and which is y, and perhaps their unit; without one, x comes
    first and both are in m.  It may stand in a comment, as NumPy's `savetxt` writes it.
    Raises ScenarioError, starting with the key and naming row and column from 1.
    """
    place = f"{KEY}: {file.name}"
    numbered = list(_rows(read_text(file, KEY, SUFFIXES, LARGEST_PATH), place))
    columns = _without_headers(numbered, place)
    points = [_point(cells, columns, f"{place}, row {row}") for row, cells in numbered]
    if len(points) < 2:
        raise ScenarioError(
            f"{place} holds {len(points)} point(s), but a path needs at least 2. "
            "Give one point a row, as x,y in m."
        )
    for i in range(1, len(points)):
        if math.dist(points[i - 1], points[i]) < SAME:
            raise ScenarioError(
                f"{place}, rows {numbered[i - 1][0]} and {numbered[i][0]} are the same point "
                f"{points[i]}: the path has no direction there. Remove one of them."
            )
    return tuple(points)


def _rows(text: str, place: str) -> Iterator[tuple[int, list[str]]]:
    """Number and cells of each row that holds something, with a point as the decimal sign.

    Cells are separated by the strongest sign in the first row that is not a comment.
    """
    rows = (row for row in text.splitlines() if row.strip() and not row.startswith("#"))
    first, begun = next(rows, "").strip(), False
    separator = next((sign for sign in ";\t, " if sign in first), ",")
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


def _without_headers(numbered: list[tuple[int, list[str]]], place: str) -> Columns:
    """The columns by the headers, which are taken out: one, or a comment's and one."""
    orders = []
    while numbered and all(cell and _number(cell) is None for cell in numbered[0][1]):
        row, header = numbered.pop(0)
        orders.append(_columns_of(header, f"{place}, row {row}"))
        if orders[0] != orders[-1]:
            raise ScenarioError(
                f"{place}, row {row}: the header contradicts the one above it. Keep the one that "
                "is right."
            )
    return orders[0] if orders else Columns()


def _columns_of(header: list[str], place: str) -> Columns:
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
    point = []
    for i, unit in zip((columns.x, columns.y), columns.units, strict=True):
        value = _number(cells[i])
        if value is None or not math.isfinite(value):
            said = f"{show(cells[i])} is not a" if value is None else f"{cells[i]} is not a finite"
            raise ScenarioError(f"{place}, column {i + 1}: {said} number. Give a coordinate in m.")
        point.append(value * unit)
    return point[0], point[1]


def read_poses(file: Path) -> tuple[Point, ...]:
    """Return the points of a YAML path; poses at the place of the one before are left out.

    Raises ScenarioError, starting with the key and naming the pose from 1.
    """
    place = f"{KEY}: {file.name}"
    points: list[Point] = []
    document = yaml_document(read_text(file, KEY, SUFFIXES), place)
    for number, pose in enumerate(_poses(document, place), start=1):
        point = _pose_point(pose, f"{place}, pose {number}")
        if not points or math.dist(points[-1], point) >= SAME:
            points.append(point)
    if len(points) < 2:
        raise ScenarioError(
            f"{place} holds {len(points)} different position(s), but a path needs at least 2."
        )
    return tuple(points)


def _poses(document: object, place: str) -> Iterator[object]:
    inner = document
    for key in ("path", "poses"):
        if isinstance(inner, Mapping) and key in inner:
            inner = inner[key]
    if not isinstance(inner, list):
        raise ScenarioError(
            f"{place} has no list of poses. Give `poses:` with a position {{x: ..., y: ...}} each."
        )
    return iter(inner)


def _pose_point(pose: object, place: str) -> Point:
    inner: Any = pose
    for key in ("pose", "pose", "position"):  # a pose with covariance has one pose in another
        if isinstance(inner, Mapping) and key in inner:
            inner = inner[key]
    if not isinstance(inner, Mapping) or not {"x", "y"} <= set(inner):
        raise ScenarioError(f"{place} = {show(pose)} has no position with x and y in m.")
    point = []
    for name in ("x", "y"):
        value = inner[name]
        try:
            point.append(math.nan if isinstance(value, bool | str) else float(value))
        except (TypeError, OverflowError):
            point.append(math.nan)
        if not math.isfinite(point[-1]):
            raise ScenarioError(
                f"{place}, {name} = {show(value)} is not a finite number. Give it in m."
            )
    return point[0], point[1]
