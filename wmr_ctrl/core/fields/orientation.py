"""Orientations at the interface: inside from +Y, as in the paper; outside as ``frames`` says.

``frames = "rep103"`` measures them from +X, as REP 103 of ROS does.  Positions are the same in
both.
"""

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from wmr_ctrl.core.errors import ScenarioError, choices, show
from wmr_ctrl.core.signals import MEASURED_POSE, POSE, REFERENCE

from .named_units import Stated, stated

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


T = TypeVar("T", float, "NDArray[np.float64]")
Q = TypeVar("Q", bound=Any)

PAPER = "paper"
FRAMES = {PAPER: 0.0, "rep103": math.pi / 2}
"""Excess of each convention's orientation over the paper's [rad]."""
ORIENTATIONS = (POSE[2].name, REFERENCE[2].name, MEASURED_POSE[2].name)
"""Columns of a run that are orientations."""
_SAID = {
    "0 along +Y, forward = (-sin theta, cos theta)": "0 along +X, forward = (cos theta, sin theta)",
    "0 along +Y": "0 along +X",
}


def checked_frames(frames: object) -> str:
    """Return ``frames`` if it names a convention; raises ScenarioError."""
    if not isinstance(frames, str) or frames not in FRAMES:
        near = choices(frames if isinstance(frames, str) else "", FRAMES)
        raise ScenarioError(
            f"frames = {show(frames)} is not known (where orientations are 0: paper: along +Y, "
            f"rep103: along +X); {near}."
        )
    return frames


def outward(theta: T, frames: str) -> T:
    """Convert orientations [rad] from the inner convention to ``frames``; numbers and arrays."""
    return theta + FRAMES[frames] if FRAMES[frames] else theta


def inward(theta: T, frames: str) -> T:
    """Convert orientations [rad] from ``frames`` to the inner convention: the inverse of `outward`.

    The conversion loses nothing: ``inward(outward(y)) == y`` to the bit for every ``y =
    inward(x)``, since x is then the double nearest to y + pi/2, or y is exact.
    """
    return theta - FRAMES[frames] if FRAMES[frames] else theta


def theta_of(quaternion: Sequence[Q], atan2: Callable[[Q, Q], Q]) -> Q:
    """Orientation [rad] in the inner convention, modulo 2 pi, of a ROS quaternion (x, y, z, w).

    It is the yaw of REP 103 less a quarter turn, for any tilt and length.  It accepts numbers,
    arrays and, with their ``atan2`` given, symbols.
    """
    x, y, z, w = quaternion
    return atan2(2 * (w * z + x * y), w * w + x * x - y * y - z * z) - FRAMES["rep103"]


def described(text: str, frames: str) -> str:
    """Meaning of a field or column in ``frames``, from a text that names the paper's convention."""
    if FRAMES[frames]:
        for ours, theirs in _SAID.items():
            text = text.replace(ours, theirs)
    return text


def field_outward(value: Any, place: int, frames: str) -> Any:
    """A field's value with element ``place`` (from 1; 0: no orientation) converted by `outward`."""
    return _moved(value, place, frames, outward)


def field_inward(value: Any, place: int, frames: str) -> Any:
    """Inverse of `field_outward`; values that are not numbers are left to the later check."""
    return _moved(value, place, frames, inward)


def _moved(value: Any, place: int, frames: str, move: Any) -> Any:
    if not place or not FRAMES[frames]:
        return value
    if isinstance(value, list | tuple):
        parts = list(value)
        if len(parts) >= place:
            parts[place - 1] = _moved(parts[place - 1], 1, frames, move)
        return type(value)(parts)
    if isinstance(value, str):
        value = stated(value)
    number = isinstance(value, int | float) and not isinstance(value, bool)
    moved = move(value, frames) if number else value
    return Stated.of(moved, value.text, value.unit) if isinstance(value, Stated) else moved
