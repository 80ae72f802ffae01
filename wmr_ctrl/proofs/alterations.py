"""Does an entry hang on the product?  Its functions are altered, one at a time.

An entry that stays PROVED whatever is done to the functions in its graph says nothing of them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from functools import cache, partial
from operator import mul

from wmr_ctrl.proofs.claim import CLAIMED, Claim
from wmr_ctrl.proofs.claims import all_claims, forget
from wmr_ctrl.proofs.finding import OPEN, PROVED, REFUTED
from wmr_ctrl.proofs.graph import ProvedGraph
from wmr_ctrl.proofs.methods.spec import Z3, Ball, Both, Method, Ring
from wmr_ctrl.proofs.product import CHANGES, Change, altered, functions_called
from wmr_ctrl.proofs.statement import Statement

ENDS = 2
"""Functions tried per entry: so many of those called first and of those called last."""


def functions_of(claim: Claim, first: Sequence[str] = ()) -> tuple[str, ...]:
    """Functions of the product that the claim's graph holds.

    Of those that are called, a function is held if its results, multiplied by a number, make
    another graph.  Many are tried at a time, by numbers of their own: where the graph stays, it
    holds none of them.  What cannot be built with its results altered is not held.  Those named in
    ``first`` are tried one at a time: where they are what it held before, that saves time alone.
    """
    before: list[ProvedGraph | None] = []
    forget()
    calls = functions_called(lambda: before.append(_graph(claim, {})))
    factors = {name: 1.125 + k / 64 for k, name in enumerate(calls)}
    groups = [[name] for name in calls if name in first]
    groups += [[name for name in calls if name not in first]]
    held = set[str]()
    if before[0] is not None:
        for group in groups:
            held |= _held(claim, {name: factors[name] for name in group}, before[0].digest)
    forget()
    return tuple(name for name in calls if name in held)


def _held(claim: Claim, factors: Mapping[str, float], digest: str) -> set[str]:
    graph = _graph(claim, factors) if factors else None
    if graph is not None and graph.digest == digest:
        return set()
    if len(factors) < 2:
        return set(factors) if graph is not None else set()
    rows = list(factors.items())
    halves = rows[: len(rows) // 2], rows[len(rows) // 2 :]
    return set().union(*(_held(claim, dict(half), digest) for half in halves))


def _graph(claim: Claim, factors: Mapping[str, float]) -> ProvedGraph | None:
    """The claim's graph with functions' results multiplied by numbers; None if not to be built."""
    forget()
    try:
        with ExitStack() as stack:
            for name, factor in factors.items():
                stack.enter_context(altered(name, partial(mul, factor)))
            return claim.statement(CLAIMED).graph if claim.statement else None
    except (ValueError, RuntimeError, TypeError, NotImplementedError):
        return None


def tried(claim: Claim, functions: tuple[str, ...]) -> dict[str, int]:
    """How many functions were altered; how often the claim was REFUTED then, and how often OPEN."""
    chosen = tuple(dict.fromkeys((*functions[:ENDS], *functions[-ENDS:])))
    verdicts = [after_alteration(claim, name) for name in chosen]
    return {"tried": len(chosen), "caught": verdicts.count(REFUTED), "open": verdicts.count(OPEN)}


def after_alteration(claim: Claim, name: str) -> str:
    """REFUTED if one of the alterations of the function is, else OPEN if one is, else PROVED."""
    assert claim.method is not None
    unsure: list[Statement] = []
    quick = short_budget(claim.method)
    for change in CHANGES.values():
        statement = altered_statement(claim, name, change)
        if statement is not None:
            if _verdict(quick, statement) == REFUTED:
                return REFUTED
            unsure.append(statement)
    return OPEN if any(fails(claim, statement) for statement in unsure) else PROVED


def is_noticed(claim: Claim, name: str, change: Change) -> bool:
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
