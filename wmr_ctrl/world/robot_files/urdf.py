"""URDF: mass, inertia, wheels and track of a robot in its zero position.

Source: the URDF specification.  Positions are those of all joints at 0, in the frame of the root
link, x ahead, y to the left, z up.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from scipy.spatial.transform import Rotation

from wmr_ctrl.core.errors import ScenarioError, show

from .found import Found, Rank, rounded
from .xml_text import numbers

if TYPE_CHECKING:
    from lxml.etree import _Element as Element

SIDEWAYS = 0.95
"""Least size of the y of a wheel's axis, a unit vector."""
MIRRORED = 5e-3
"""Largest distance [m] between a wheel's place and the mirror image of its partner's."""
ALIKE = 0.02
"""Share by which radii or tracks of wheels that drive together may differ."""
TURNING = ("revolute", "continuous")
INERTIAS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
Pose: TypeAlias = tuple[np.ndarray, np.ndarray]
"""Rotation (3, 3) and position (3,) [m]."""


@dataclass(frozen=True)
class Wheel:
    """Wheel joint: name, place (3,) [m], radius [m] or 0 for a mesh."""

    name: str
    place: np.ndarray
    radius: float


def read(root: Element, file: str, named: Sequence[str] = ()) -> Iterator[Found]:
    """Mass, inertia about the vertical through the axle's middle, radius and track.

    ``named``: the joints that a controller drives; without them, pairs of wheels are found by
    position.  Raises ScenarioError if there is no pair, or a number is impossible.
    """
    links, joints = _named(root, "link", file), _named(root, "joint", file)
    poses = _poses(links, joints, file)
    wheels, others = _driven(_wheels(links, joints, poses, file, named), file, bool(named))
    source = f"{file}: {', '.join(wheel.name for wheel in wheels)}{others}"
    middle = np.mean([wheel.place for wheel in wheels], axis=0)
    masses, inertia = [], 0.0
    for name, link in links.items():
        mass, centre, about_centre = _body(link, poses[name], f"{file}: link {name}")
        masses += [mass] if mass else []
        inertia += about_centre + mass * float(np.sum((centre - middle)[:2] ** 2))
    empty = f", {len(links) - len(masses)} without mass" * (len(masses) < len(links))
    weighed = f"{file}: {len(masses)} links{empty}"
    track = 2 * float(np.mean([abs(wheel.place[1]) for wheel in wheels]))
    radii = [wheel.radius for wheel in wheels if wheel.radius] or [0.0]
    for key, value, where in (
        ("robot.m", sum(masses), f"{weighed}, their sum"),
        ("robot.I", inertia, f"{weighed}, about the axle's middle"),
        ("separation", track, source),
        ("robot.r", float(np.mean(radii)), source),
    ):
        if value > 0:
            yield Found(key, rounded(value), where, Rank.DESCRIPTION)


def _named(root: Element, kind: str, file: str) -> dict[str, Element]:
    """Links or joints by name."""
    items = list(root.iterchildren(kind))
    result = {item.get("name", ""): item for item in items}
    if "" in result or len(result) < len(items):
        raise ScenarioError(f"{file}: a {kind} has no name, or two have the same. Name each once.")
    return result


def _origin(item: Element, place: str) -> Pose:
    """Pose of an element's origin: roll, pitch and yaw about fixed axes."""
    turn = Rotation.from_euler("xyz", numbers(item, "origin", "rpy", place, 3))
    return turn.as_matrix(), np.array(numbers(item, "origin", "xyz", place, 3))


def _joined(outer: Pose, inner: Pose) -> Pose:
    return outer[0] @ inner[0], outer[1] + outer[0] @ inner[1]


def _poses(links: dict[str, Element], joints: dict[str, Element], file: str) -> dict[str, Pose]:
    """Pose of each link in the root's frame."""
    above: dict[str, tuple[str, Pose]] = {}
    for name, joint in joints.items():
        ends = [joint.find(end) for end in ("parent", "child")]
        parent, child = ("" if end is None else end.get("link", "") for end in ends)
        if parent not in links or child not in links or child in above:
            raise ScenarioError(
                f"{file}: joint {show(name)} must join two links of this file, and no other joint "
                "may lead to the second one."
            )
        above[child] = parent, _origin(joint, f"{file}: joint {name}")
    poses = {name: (np.eye(3), np.zeros(3)) for name in links if name not in above}
    if len(poses) != 1:
        raise ScenarioError(f"{file}: {len(poses)} links have no joint above them, not just one.")
    waiting = dict(above)
    while ready := [child for child, (parent, _) in waiting.items() if parent in poses]:
        for child in ready:
            parent, own = waiting.pop(child)
            poses[child] = _joined(poses[parent], own)
    if waiting:
        raise ScenarioError(f"{file}: link {show(min(waiting))} hangs in a circle of joints.")
    return poses


def _body(link: Element, pose: Pose, where: str) -> tuple[float, np.ndarray, float]:
    """Mass [kg], centre (3,) [m] and moment of inertia about the vertical through it [kg m2]."""
    inertial = link.find("inertial")
    if inertial is None:
        return 0.0, pose[1], 0.0
    (mass,) = numbers(inertial, "mass", "value", where, 1)
    turn, centre = _joined(pose, _origin(inertial, where))
    xx, xy, xz, yy, yz, zz = (numbers(inertial, "inertia", i, where, 1)[0] for i in INERTIAS)
    if min(mass, xx, yy, zz) < 0:
        raise ScenarioError(f"{where}: mass and moments of inertia must not be below 0.")
    own = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return mass, centre, float(turn[2] @ own @ turn[2]) if mass else 0.0


def _wheels(
    links: dict[str, Element],
    joints: dict[str, Element],
    poses: dict[str, Pose],
    file: str,
    named: Sequence[str],
) -> list[Wheel]:
    """Continuous joints with a lateral axis, or the named ones.

    A wheel that is steered, or belongs to a caster, is not a drive wheel.
    """
    wheels, steered = [], _steered(joints)
    for name, joint in joints.items():
        child = joint.find("child").get("link", "")
        free = joint.get("type") == "continuous" and child not in steered
        if name in named if named else free:
            axis = np.array(numbers(joint, "axis", "xyz", f"{file}: joint {name}", 3))
            along, size = poses[child][0] @ axis, float(np.linalg.norm(axis))
            if size and abs(along[1]) >= SIDEWAYS * size:
                radius = _radius(links[child], f"{file}: link {child}")
                wheels.append(Wheel(name, poses[child][1], radius))
    return wheels


def _steered(joints: dict[str, Element]) -> set[str]:
    """Links below a joint that turns."""
    ends = [(j.find("parent").get("link"), j.find("child").get("link"), j) for j in joints.values()]
    turned: set[str] = {child for _, child, joint in ends if joint.get("type") in TURNING}
    below: set[str] = set()
    while more := {c for parent, c, _ in ends if parent in turned | below} - below:
        below |= more
    return below


def _radius(link: Element, place: str) -> float:
    """Radius [m] of a cylinder or sphere, preferably of the collision shape; 0 if there is none."""
    for kind in ("collision", "visual"):
        for part in link.iterchildren(kind):
            for shape in ("cylinder", "sphere"):
                (radius,) = numbers(part, f"geometry/{shape}", "radius", place, 1)
                if radius > 0:
                    return radius
    return 0.0


def _driven(wheels: list[Wheel], file: str, named: bool) -> tuple[list[Wheel], str]:
    """The driven wheels: the largest mirrored pair and similar ones; a note on the others.

    Wheels that a controller names are all driven, if they are on both sides.
    """
    if named and len({np.sign(wheel.place[1]) for wheel in wheels}) == 2:
        return wheels, ""
    paired = [
        wheel
        for wheel in wheels
        if wheel.place[1]
        and any(np.abs(w.place * (1, -1, 1) - wheel.place).max() <= MIRRORED for w in wheels)
    ]
    if not paired:
        raise ScenarioError(
            f"{file} has no pair of wheels: two continuous joints with axes along y, left and "
            "right of the root link's x axis at the same x and z. Joints that might be wheels: "
            f"{', '.join(wheel.name for wheel in wheels) or 'none'}. Give the controller's file as "
            "well, which names them, or complete the URDF."
        )
    largest = max(map(_size, paired))
    kept = [w for w in paired if all(map(_close, _size(w), largest))]
    others = ", ".join(wheel.name for wheel in wheels if wheel not in kept)
    return kept, f" (not {others})" if others else ""


def _size(wheel: Wheel) -> tuple[float, float]:
    """Radius and distance from the middle [m]: sort key with driven wheels before casters."""
    return wheel.radius, float(abs(wheel.place[1]))


def _close(one: float, other: float) -> bool:
    return math.isclose(one, other, rel_tol=ALIKE)
