"""Two methods, one verdict: what they do not agree on stays open."""

from __future__ import annotations

from wmr_ctrl.proofs.finding import OPEN, REFUTED, Finding
from wmr_ctrl.proofs.methods.spec import Both
from wmr_ctrl.proofs.statement import Statement


def decide(statement: Statement, method: Both) -> Finding:
    """Their common verdict, with the evidence of both.

    A counterexample of either refutes, unless the method asks that both find one.
    """
    first, second = method.first.decide(statement), method.second.decide(statement)
    evidence = {**first.evidence, **second.evidence}
    if first.verdict == second.verdict:
        return Finding(first.verdict, evidence, first.point)
    for finding in (first, second):
        if finding.verdict == REFUTED and not method.all_refute:
            return Finding(REFUTED, evidence, finding.point)
    return Finding(OPEN, evidence)
