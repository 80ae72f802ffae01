"""POINT over a table: the statement at each of finitely many exact points."""

from __future__ import annotations

from fractions import Fraction

from flint import arb

from wmr_ctrl.proofs.finding import OPEN, PROVED, REFUTED, Finding
from wmr_ctrl.proofs.methods.point import certainly, judge
from wmr_ctrl.proofs.methods.spec import Point, Table
from wmr_ctrl.proofs.statement import Statement


def decide(statement: Statement, method: Table) -> Finding:
    """PROVED if it holds at every point, REFUTED by the first at which it certainly does not."""
    points = method.points()
    for point in points:
        if certainly(statement, _as_balls(point)) or certainly(statement, _exact(point)):
            continue
        given, goal = judge(statement, _exact(point))
        found = _exact(point) if given and not goal else None
        return Finding(REFUTED if found else OPEN, {"points": len(points)}, found)
    return Finding(PROVED, {"points": len(points)}, _exact(points[0]))


def _as_balls(point: Point) -> Point:
    """Coordinates that are doubles as exact balls, which is faster; the rest as they are."""
    return {name: arb(v) if isinstance(v, float) else v for name, v in point.items()}


def _exact(point: Point) -> Point:
    return {name: Fraction(v) if isinstance(v, float) else v for name, v in point.items()}
