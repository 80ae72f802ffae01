"""Check one claim: its statement, its mutation, and whether its hypotheses can be satisfied."""

import json
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from hashlib import sha256
from importlib.util import find_spec
from time import process_time
from typing import Any

from wmr_ctrl.results.ledger import LEMMA, NOT_CHECKED, OPEN, PROVED, REFUTED, Entry

from .alterations import functions_of
from .claim import CLAIMED, MUTATED, Claim
from .methods import spec
from .methods.spec import Z3, Finding, Method, Ring
from .statement import Statement

ENGINES, ENGINES_ALTERED = "engines", "engines of the altered claim"
"""Keys of an entry's evidence: engines of z3 that closed the questions of its statements."""


def missing(method: Method | None) -> tuple[str, ...]:
    """Packages that the method needs but that are not installed."""
    return tuple(name for name in method.NEEDS if find_spec(name) is None) if method else ()


def check(claim: Claim, known: Entry | None = None) -> Entry:
    """The claim's entry; NOT_CHECKED if a package is missing.

    The verdict and the product's functions are always derived anew; an earlier entry, ``known``,
    says what to try first.  Three results are taken from it if graphs, method and versions are
    equal: confirmations by other solvers; that cancelled operations are defined; effects of
    altering each function.
    """
    if claim.statement is None or claim.method is None:
        return _entry(claim, claim.verdict)
    absent = missing(claim.method)
    if absent:
        return _entry(claim, NOT_CHECKED, method=f"needs {', '.join(absent)}")
    started, before = process_time(), known.evidence if known else {}
    claimed, altered = (claim.statement(way) for way in (CLAIMED, MUTATED))
    finding = _quickest(claim.method, before, ENGINES).decide(claimed)
    told, mutated = dict(finding.evidence), None
    if finding.verdict == PROVED:
        other = _quick(_quickest(claim.method, before, ENGINES_ALTERED)).decide(altered)
        mutated = other.verdict == REFUTED
        if ENGINES in other.evidence:
            told[ENGINES_ALTERED] = other.evidence[ENGINES]
    seconds = round(process_time() - started, 2)
    entered, now = _hash(claimed, altered, claim.method), spec.versions(claim.method)
    same = known if known and known.is_about(entered, now) else None
    functions = functions_of(claim, tuple(known.altered) if known else ())
    then = same.altered if same else {}
    verdict, reason = _guarded(finding, mutated, functions)
    asked = now | (spec.versions(Z3()) if find_spec("z3") else {})
    cancelled = same.cancelled if same else None
    if cancelled and not (known and known.is_about(entered, asked)):
        cancelled = None
    if cancelled is None and verdict in (PROVED, LEMMA):
        verdict, reason, cancelled = _defined(claim, verdict)
    counted = [pair for pair in (("case", "cases"), ("box", "boxes")) if pair[1] in told]
    counts = [f"{told[many]} {one if told[many] == 1 else many}" for one, many in counted]
    made = _entry(
        claim,
        verdict,
        method=", ".join([spec.named(claim.method), *counts]),
        trusted=spec.trusted(claim.method),
        mutation_refuted=mutated,
        counterexample=_text(finding.point) if verdict == REFUTED else None,
        satisfied_at=_text(finding.point) if verdict in (PROVED, LEMMA) else None,
        seconds=seconds,
        graph_hash=entered,
        versions=asked if cancelled else now,
        altered={name: then.get(name, "") for name in functions},
        confirmed_by=same.confirmed_by if same else (),
        cancelled=cancelled,
        evidence=told | reason,
    )
    if find_spec("z3") is None or verdict not in (PROVED, LEMMA, REFUTED):
        return made
    from .certificates import with_certificate

    return with_certificate(claim, made)


def graph_hash(claim: Claim) -> str:
    """Hash of claim, alterations, graph and method at present; see `Entry`."""
    if claim.statement is None:
        return ""
    assert claim.method is not None
    return _hash(claim.statement(CLAIMED), claim.statement(MUTATED), claim.method)


def _hash(claimed: Statement, altered: Statement, method: Method) -> str:
    text = json.dumps([claimed.digest, altered.digest, spec.described(method)])
    return sha256(text.encode()).hexdigest()


def _quickest(method: Method, evidence: Mapping[str, Any], key: str) -> Method:
    """The method, with engines that answered before asked first, which only saves time."""
    first = tuple(evidence.get(key, ()))
    return replace(method, first=first) if first and isinstance(method, Z3) else method


def _quick(method: Method) -> Method:
    """Method for the altered claim: one failing case is enough."""
    return replace(method, quick=True) if isinstance(method, Ring) else method


def _guarded(
    finding: Finding, mutated: bool | None, functions: tuple[str, ...]
) -> tuple[str, dict[str, str]]:
    """PROVED only with functions of the product, a refuted mutation and satisfiable hypotheses."""
    if finding.verdict != PROVED:
        return finding.verdict, {}
    if not mutated:
        return OPEN, {"held back": "the altered claim was not refuted"}
    if finding.point is None:
        return OPEN, {"held back": "no point was found that satisfies the hypotheses"}
    return (PROVED if functions else LEMMA), {}


def _defined(claim: Claim, verdict: str) -> tuple[str, dict[str, str], int | None]:
    """The verdict, unless cancelled operations may be undefined; the number of cancelled ones."""
    if find_spec("z3") is None:
        return NOT_CHECKED, {"held back": "what CasADi cancels is asked of z3"}, None
    from .cancelled import undefined

    number, left = undefined(claim)
    if left:
        return OPEN, {"held back": f"what CasADi cancels may be undefined: {left}"}, None
    return verdict, {}, number


def _text(point: Mapping[str, Any] | None) -> dict[str, str] | None:
    """A point as exact texts: ``p/q``, or ``1 pi``."""
    if point is None:
        return None
    return {name: v if isinstance(v, str) else str(Fraction(v)) for name, v in point.items()}


def _entry(claim: Claim, verdict: str, **found: Any) -> Entry:
    return Entry(id=claim.id, verdict=verdict, **claim.words(), **found)
