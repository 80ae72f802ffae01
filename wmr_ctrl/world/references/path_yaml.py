"""Waypoints from a YAML file as navigation stacks print a path: poses with a position in metres.

Accepted are a list of poses, or a mapping with the key ``poses`` (or ``path`` above it).  A pose is
a mapping with x and y, perhaps below ``position`` and that below ``pose``; headers, z and
orientations are passed over, since the path's direction follows from its points.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from wmr_ctrl.errors import MissingExtraError, ScenarioError
from wmr_ctrl.fields.files import read_text
from wmr_ctrl.fields.limits import MOST_NODES
from wmr_ctrl.fields.problems import show
from wmr_ctrl.world.references.csv_points import SAME, SUFFIXES, Point


def read_poses(file: Path, path: str = "reference.file") -> tuple[Point, ...]:
    """Return the points of a YAML path; poses at the place of the one before are left out.

    Raises ScenarioError, starting with the key ``path`` and naming the pose from 1, and
    MissingExtraError without PyYAML.
    """
    place = f"{path}: {file.name}"
    points: list[Point] = []
    document = _document(read_text(file, path, SUFFIXES), place)
    for number, pose in enumerate(_poses(document, place), start=1):
        point = _point(pose, f"{place}, pose {number}")
        if not points or math.dist(points[-1], point) >= SAME:
            points.append(point)
    if len(points) < 2:
        raise ScenarioError(
            f"{place} holds {len(points)} different position(s), but a path needs at least 2."
        )
    return tuple(points)


def _document(text: str, place: str) -> object:
    """The first document of a YAML text."""
    try:
        import yaml
    except ImportError:
        raise MissingExtraError(
            f"{place}: YAML needs PyYAML, which is not installed: pip install pyyaml. Or give the "
            "points as CSV."
        ) from None
    loader = yaml.SafeLoader(text)
    try:
        node = loader.get_node() if loader.check_node() else None
        if node is None:
            return None
        if _size(node, {}) > MOST_NODES:
            raise ScenarioError(
                f"{place} has more than {MOST_NODES} values, aliases written out. Save the path "
                "without anchors and aliases, or as CSV."
            )
        return loader.construct_document(node)
    except RecursionError:
        raise ScenarioError(f"{place} is not usable YAML: it is nested too deeply.") from None
    except (yaml.YAMLError, ValueError) as problem:
        if isinstance(problem, ScenarioError):
            raise
        detail = show(" ".join(str(problem).splitlines()[:1]))
        raise ScenarioError(f"{place} is not YAML ({detail}). Save it as YAML or CSV.") from None
    finally:
        loader.dispose()


def _size(node: Any, known: dict[int, float]) -> float:
    """Values in a node of YAML with every alias written out; infinite if it holds itself."""
    if id(node) not in known:
        known[id(node)] = math.inf
        inner = node.value if isinstance(node.value, list) else []
        parts = (part for item in inner for part in (item if isinstance(item, tuple) else (item,)))
        known[id(node)] = 1 + sum(_size(part, known) for part in parts)
    return known[id(node)]


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


def _point(pose: object, place: str) -> Point:
    inner: Any = pose
    for key in ("pose", "pose", "position"):  # a pose with covariance has one pose in another
        if isinstance(inner, Mapping) and key in inner:
            inner = inner[key]
    if not isinstance(inner, Mapping) or not {"x", "y"} <= set(inner):
        raise ScenarioError(f"{place} = {show(pose)} has no position with x and y in m.")
    x, y = (_coordinate(inner[name], f"{place}, {name}") for name in ("x", "y"))
    return x, y


def _coordinate(value: object, place: str) -> float:
    try:
        number = math.nan if isinstance(value, bool | str) else float(value)  # type: ignore[arg-type]
    except (TypeError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise ScenarioError(f"{place} = {show(value)} is not a finite number. Give it in m.")
    return number
