"""REFUTE: try exact points."""

from __future__ import annotations

from collections.abc import Iterable

from wmr_ctrl.proofs.finding import OPEN, REFUTED, Finding
from wmr_ctrl.proofs.methods.point import judge
from wmr_ctrl.proofs.methods.spec import Point, Refute
from wmr_ctrl.proofs.statement import Statement


def decide(statement: Statement, method: Refute) -> Finding:
    """REFUTED by the first point that keeps every hypothesis and breaks a goal."""
    found = first_violation(statement, method.points)
    if found is None:
        return Finding(OPEN, {"points tried": len(method.points)})
    return Finding(REFUTED, {"points tried": len(method.points)}, found)


def first_violation(statement: Statement, points: Iterable[Point]) -> Point | None:
    """The first exact counterexample among ``points``."""
    for point in points:
        given, goal = judge(statement, point)
        if given and not goal:
            return point
    return None
