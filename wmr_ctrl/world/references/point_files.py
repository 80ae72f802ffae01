"""Waypoints from a file: a table with one point per row, or a path in YAML as navigation stacks
print it.

For tables see `core.fields.tables`; without a header, the columns are x and y in m.  YAML: a list
of poses, or a mapping with such a list under a key of `LISTS`, or poses by name, or one pose per
document.  A pose is a mapping with x and y in m, possibly under ``position`` and that under
``pose``, or a list of x, y and more.  In GeoJSON, which is YAML, it is a point, or each point of a
line.  Headers, z and orientations are ignored, since the path's direction follows from its points.
"""

import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

from wmr_ctrl.core.errors import ScenarioError, show
from wmr_ctrl.core.fields.files import read_text
from wmr_ctrl.core.fields.tables import TableReader
from wmr_ctrl.core.fields.yaml_text import yaml_documents

Point = tuple[float, float]
KEY = "reference.file"
YAML = (".yaml", ".yml", ".json", ".geojson")
SUFFIXES = (".csv", ".tsv", ".txt", *YAML)
"""Suffixes of a path's file."""
LARGEST_PATH = 10_000_000
"""Bytes; a planner's path has some fifty a point."""
LISTS = ("path", "poses", "waypoints", "goals", "features")
"""Keys below which navigation stacks and GeoJSON have the points of a path."""
INNER = ("pose", "pose", "geometry", "position", "coordinates")
"""Keys below which a pose has its position: one with covariance has a pose in another."""
AXES = {"x": "m", "y": "m"}
_ALIKE = re.compile(r"(?:.*(?:position|point)[./])?([xy])(?:_ref)?", re.IGNORECASE)
SAME = 1e-9
"""Points nearer to each other than this, m, are the same."""


def read_points(file: Path) -> tuple[Point, ...]:
    """Return the points of a file [m] without points that repeat the one before.

    Raises ScenarioError, starting with the key and naming line or pose from 1.
    """
    place = f"{KEY}: {file.name}"
    text = read_text(file, KEY, SUFFIXES, LARGEST_PATH)
    numbered = _of_yaml(text, place) if file.suffix.lower() in YAML else _of_table(text, place)
    points: list[Point] = []
    for where, point in numbered:
        x, y = (_coordinate(value, where) for value in point)
        if not points or math.dist(points[-1], (x, y)) >= SAME:
            points.append((x, y))
    if len(points) < 2:
        raise ScenarioError(
            f"{place} holds {len(points)} different point(s), but a path needs at least 2."
        )
    return tuple(points)


def _coordinate(value: object, where: str) -> float:
    number = value if isinstance(value, int | float) and not isinstance(value, bool) else math.nan
    try:
        if math.isfinite(number):
            return float(number)
    except OverflowError:
        pass
    raise ScenarioError(f"{where}: {show(value)} is not a finite number. Give a coordinate in m.")


def _of_table(text: str, place: str) -> Iterator[tuple[str, tuple[object, ...]]]:
    remedy = "Name two of them x and y in a header, each perhaps with its unit, as in x [mm]."
    table = TableReader(
        place, AXES, tuple(AXES), unnamed=tuple(AXES), alike=_ALIKE, remedy=remedy
    ).read(text.splitlines())
    if table.cut:
        raise ScenarioError(f"{place}, line {table.cut} is cut off. Complete or remove it.")
    for line, *point in zip(table.lines, *(table.columns[name] for name in AXES), strict=True):
        yield f"{place}, line {line}", tuple(point)


def _of_yaml(text: str, place: str) -> Iterator[tuple[str, tuple[object, ...]]]:
    documents = yaml_documents(text, place)
    lists = [found for document in documents if (found := _poses(document)) is not None]
    if len(lists) > 1:
        raise ScenarioError(f"{place} holds {len(lists)} paths. Keep one of them.")
    for number, pose in enumerate(lists[0] if lists else documents, start=1):
        where = f"{place}, pose {number}"
        inner = pose
        for key in INNER:
            if isinstance(inner, Mapping) and key in inner:
                inner = inner[key]
        if isinstance(inner, Mapping) and {"x", "y"} <= {*inner}:
            yield where, (inner["x"], inner["y"])
        elif isinstance(inner, list) and len(inner) > 1 and isinstance(inner[0], list):
            yield from ((where, tuple(point[:2])) for point in inner)
        elif isinstance(inner, list) and len(inner) > 1:
            yield where, tuple(inner[:2])
        else:
            raise ScenarioError(f"{where} = {show(pose)} has no position with x and y in m.")


def _poses(document: object) -> list[object] | None:
    """Poses of a path; None if the document is not a path."""
    inner = document
    while isinstance(inner, Mapping):
        below = [inner[key] for key in (*LISTS, "ros__parameters") if key in inner]
        if not below and len(inner) == 1 and isinstance(next(iter(inner.values())), Mapping):
            below = [*inner.values()]  # parameters of a node by its name
        if not below:
            points = [*inner.values()]
            named = len(points) > 1 and all(isinstance(item, list) for item in points)
            return points if named and inner is not document else None
        inner = below[0]
    if not isinstance(inner, list):
        return None
    numbers = all(isinstance(item, int | float) for item in inner)
    if inner and numbers and len(inner) % 3 == 0:  # x, y and heading in turn, as parameters have it
        return [inner[k : k + 3] for k in range(0, len(inner), 3)]
    return inner
