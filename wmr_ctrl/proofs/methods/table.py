"""POINT over a table: the statement at each of finitely many exact points."""

from __future__ import annotations

from wmr_ctrl.proofs.finding import OPEN, PROVED, REFUTED, Finding
from wmr_ctrl.proofs.methods.point import certainly, judge
from wmr_ctrl.proofs.methods.spec import Table
from wmr_ctrl.proofs.statement import Statement


def decide(statement: Statement, method: Table) -> Finding:
    """PROVED if it holds at every point, REFUTED by the first at which it certainly does not."""
    points = method.points()
    for point in points:
        if certainly(statement, point):
            continue
        given, goal = judge(statement, point)
        found = point if given and not goal else None
        return Finding(REFUTED if found else OPEN, {"points": len(points)}, found)
    return Finding(PROVED, {"points": len(points)}, points[0])
