"""Does an entry hang on the product?  Its functions are altered, one at a time.

An entry that stays PROVED whatever is done to the functions in its graph says nothing of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

from wmr_ctrl.proofs.claim import CLAIMED, Claim
from wmr_ctrl.proofs.claims import all_claims, forget
from wmr_ctrl.proofs.finding import OPEN, PROVED, REFUTED
from wmr_ctrl.proofs.methods.spec import Z3, Ball, Both, Method, Ring
from wmr_ctrl.proofs.product import CHANGES, Change, altered, functions_called
from wmr_ctrl.proofs.statement import Statement

ENDS = 2
"""Functions tried per entry: so many of those called first and of those called last."""


def functions_of(claim: Claim) -> tuple[str, ...]:
    """Functions of the product that the claim's graph holds."""
    return functions_by_claim([claim])[claim.id]


def functions_by_claim(claims: Sequence[Claim]) -> dict[str, tuple[str, ...]]:
    """The same for claims that share parts of their graphs: each alteration is built once."""
    before = digests(claims)
    forget()
    calls = functions_called(lambda: digests(claims))
    held: dict[str, list[str]] = {claim.id: [] for claim in claims}
    for name in calls:
        forget()
        with altered(name, CHANGES["* 9/8"]):
            after = digests(claims)
        for key in held:
            if after[key] not in (before[key], None):
                held[key].append(name)
    forget()
    return {key: tuple(names) for key, names in held.items()}


def digests(claims: Sequence[Claim]) -> dict[str, str | None]:
    """Digest of each claim's graph; None where it cannot be built."""
    return {claim.id: _digest(claim) for claim in claims}


def _digest(claim: Claim) -> str | None:
    try:
        return claim.statement(CLAIMED).graph.digest if claim.statement else None
    except (ValueError, RuntimeError, TypeError, NotImplementedError):
        return None


def tried(claim: Claim, functions: tuple[str, ...]) -> dict[str, int]:
    """How many functions were altered, and how many of these alterations changed the verdict."""
    chosen = tuple(dict.fromkeys((*functions[:ENDS], *functions[-ENDS:])))
    return {"tried": len(chosen), "caught": sum(needs(claim, name) for name in chosen)}


def needs(claim: Claim, name: str) -> bool:
    """Whether some alteration of the function leaves the claim PROVED no longer."""
    assert claim.method is not None
    found = (altered_statement(claim, name, change) for change in CHANGES.values())
    statements = [statement for statement in found if statement is not None]
    quick = short_budget(claim.method)
    return any(_verdict(quick, statement) == REFUTED for statement in statements) or any(
        fails(claim, statement) for statement in statements
    )


def is_caught(claim: Claim, name: str, change: Change) -> bool:
    """Whether the claim is PROVED no longer with the function altered."""
    statement = altered_statement(claim, name, change)
    return statement is not None and fails(claim, statement)


def altered_statement(claim: Claim, name: str, change: Change) -> Statement | None:
    """The claim's statement with the function altered; None where it cannot be built like this."""
    assert claim.statement is not None
    forget()
    try:
        with altered(name, change):
            statement = claim.statement(CLAIMED)
            _ = statement.graph
    except (ValueError, RuntimeError, TypeError, NotImplementedError):
        return None
    finally:
        forget()
    return statement


def fails(claim: Claim, statement: Statement) -> bool:
    """Whether the claim's method does not prove an altered statement.

    That it does not within a short budget counts where it proves the claim as it is within one.
    """
    assert claim.method is not None
    verdict = _verdict(short_budget(claim.method), statement)
    if verdict == OPEN and not proves_quickly(claim.id):
        verdict = _verdict(claim.method, statement)
    return verdict != PROVED


@cache
def proves_quickly(key: str) -> bool:
    """Whether the method within a short budget proves the claim of this id."""
    claim = next(claim for claim in all_claims() if claim.id == key)
    assert claim.statement is not None
    assert claim.method is not None
    return _verdict(short_budget(claim.method), claim.statement(CLAIMED)) == PROVED


def _verdict(method: Method, statement: Statement) -> str:
    try:
        return method.decide(statement).verdict
    except KeyError:
        return PROVED  # the graph reads an input that the method was not told of: no news


def short_budget(method: Method) -> Method:
    """The method within a short budget: one case that fails is enough."""
    if isinstance(method, Both):
        return replace(method, first=short_budget(method.first), second=short_budget(method.second))
    if isinstance(method, Ball):
        return replace(method, budget=min(method.budget, 400))
    if isinstance(method, Z3):
        return replace(method, effort=5, seconds=4)
    return replace(method, quick=True) if isinstance(method, Ring) else method
