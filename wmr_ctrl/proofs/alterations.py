"""Does an entry hang on the product?  Its functions are altered, one at a time.

An entry that stays PROVED whatever is done to the functions in its graph says nothing of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from wmr_ctrl.proofs.claim import Claim
from wmr_ctrl.proofs.claims import forget
from wmr_ctrl.proofs.finding import PROVED
from wmr_ctrl.proofs.methods.spec import Z3, Ball, Both, Method, Ring
from wmr_ctrl.proofs.product import CHANGES, Change, altered, functions_called

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
        return claim.statement(1.0).graph.digest if claim.statement else None
    except (ValueError, RuntimeError, TypeError, NotImplementedError):
        return None


def tried(claim: Claim, functions: tuple[str, ...]) -> dict[str, int]:
    """How many functions were altered, and how many of these alterations changed the verdict."""
    chosen = tuple(dict.fromkeys((*functions[:ENDS], *functions[-ENDS:])))
    caught = sum(any(is_caught(claim, name, change) for change in CHANGES.values())
                 for name in chosen)  # fmt: skip
    return {"tried": len(chosen), "caught": caught}


def is_caught(claim: Claim, name: str, change: Change) -> bool:
    """Whether the claim is PROVED no longer with the function altered."""
    assert claim.statement is not None
    assert claim.method is not None
    forget()
    try:
        with altered(name, change):
            statement = claim.statement(1.0)
            _ = statement.graph
    except (ValueError, RuntimeError, TypeError, NotImplementedError):
        return False  # it cannot be built like this: that tells nothing
    finally:
        forget()
    try:
        return hasty(claim.method).decide(statement).verdict != PROVED
    except KeyError:
        return False  # the altered graph reads an input that the method was not told of


def hasty(method: Method) -> Method:
    """The method with little patience: one case that fails is enough."""
    if isinstance(method, Both):
        return replace(method, first=hasty(method.first), second=hasty(method.second))
    if isinstance(method, Ball):
        return replace(method, budget=min(method.budget, 400))
    if isinstance(method, Z3):
        return replace(method, effort=5)
    return replace(method, quick=True) if isinstance(method, Ring) else method
