"""Verdicts of entries when the product's functions are altered.

An entry that stays PROVED under every alteration of a function says nothing about that function.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from time import process_time

from wmr_ctrl.results.ledger import OPEN, PROVED, REFUTED

from .alterations import Change, built
from .claim import CLAIMED, Claim
from .claims import all_claims
from .methods.spec import Z3, Ball, Method, Ring
from .statement import Statement

CHANGES: Mapping[str, Change] = {
    "* 9/8": lambda x: 1.125 * x,
    "* -1": lambda x: -x,
    "* 8": lambda x: 8 * x,
    "+ 1": lambda x: x + 1,
    "/ 8": lambda x: 0.125 * x,
}
"""Alterations of a function's result."""
PATIENCE = 600.0
"""Seconds of the processor for one entry's alterations."""


def tried(
    claim: Claim, functions: Sequence[str], known: Mapping[str, str], patience: float = PATIENCE
) -> dict[str, str]:
    """Verdict of the claim with each of the functions altered, if it is not ``known``.

    Empty if it was not tried within ``seconds`` of processor time.
    """
    found, started = {name: known.get(name, "") for name in functions}, process_time()
    for name in functions:
        if not found[name] and process_time() - started < patience:
            found[name] = after_alteration(claim, name)
    return found


def after_alteration(claim: Claim, name: str) -> str:
    """Verdict of the claim when the function is altered.

    REFUTED if one of the alterations is refuted, first within a short budget.  Else OPEN if one is
    open even within a longer budget, although the claim itself is PROVED within the short one.
    Else PROVED if all are proved.  Empty if none of these is found.
    """
    assert claim.method is not None
    statements = [built(claim, {name: change}) for change in CHANGES.values()]
    left = [item for item in statements if item]
    for seconds in (2, 30):
        budget, asked, left = short_budget(claim.method, seconds), left, []
        for statement in asked:
            verdict = verdict_of(budget, statement)
            if verdict == REFUTED:
                return REFUTED
            left += [statement] * (verdict == OPEN)
    if left:
        return OPEN if proves_quickly(claim.id) else ""
    return PROVED if any(statements) else ""


@cache
def proves_quickly(key: str) -> bool:
    """True if the method proves the claim of this id within a short budget."""
    claim = next(claim for claim in all_claims() if claim.id == key)
    assert claim.statement is not None
    assert claim.method is not None
    return verdict_of(short_budget(claim.method), claim.statement(CLAIMED)) == PROVED


def verdict_of(method: Method, statement: Statement) -> str:
    """Verdict of a method; PROVED if the method lacks an input, since that says nothing."""
    try:
        return method.decide(statement).verdict
    except KeyError:
        return PROVED


def short_budget(method: Method, seconds: int = 2) -> Method:
    """The method within a short budget: one case that fails is enough."""
    if isinstance(method, Ball):
        return replace(method, budget=min(method.budget, 200 * seconds))
    if isinstance(method, Z3):
        return replace(method, effort=min(method.effort, 3 * seconds))
    return replace(method, quick=True) if isinstance(method, Ring) else method
