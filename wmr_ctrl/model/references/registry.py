"""Which module describes which kind of reference."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import ModuleType
from typing import Any, Protocol, cast

import casadi as ca

from wmr_ctrl.model.references import (
    circle,
    lemniscate,
    line,
    rounded_square,
    stop_and_go,
    waypoints,
)
from wmr_ctrl.model.references.kinds import Parameters
from wmr_ctrl.scenario.reference import (
    Circle,
    Lemniscate,
    Line,
    Reference,
    RoundedSquare,
    StopAndGo,
    Waypoints,
)

MODULES: dict[type[Reference], ModuleType] = {
    Circle: circle,
    Line: line,
    Lemniscate: lemniscate,
    RoundedSquare: rounded_square,
    StopAndGo: stop_and_go,
    Waypoints: waypoints,
}


class Trajectory(Protocol):
    """What the module of a kind offers.

    ``parameters(reference)`` gives the signals of its parameters with their numbers, and
    ``trajectory(t, p)`` the reference (7, 1) as an expression of time [s] and of the parameters'
    symbols, by name.
    """

    parameters: Callable[[Any], Parameters]
    trajectory: Callable[[ca.SX, Mapping[str, ca.SX]], ca.SX]


def trajectory_of(reference: Reference) -> Trajectory:
    """Return the module that describes the reference's kind."""
    return cast(Trajectory, MODULES[type(reference)])
