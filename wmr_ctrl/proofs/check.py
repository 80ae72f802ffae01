"""One claim to one entry: the statement, its mutation, and whether its hypotheses can be met."""

import json
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from hashlib import sha256
from importlib.util import find_spec
from time import process_time
from typing import Any

from wmr_ctrl.proofs.alterations import functions_of
from wmr_ctrl.proofs.claim import CLAIMED, MUTATED, Claim
from wmr_ctrl.proofs.ledger import LEMMA, NOT_CHECKED, OPEN, PROVED, REFUTED, Entry
from wmr_ctrl.proofs.methods.spec import (
    Z3,
    Both,
    Finding,
    Method,
    Ring,
    described,
    named,
    needs,
    trusted,
    versions,
)


def missing(method: Method | None) -> tuple[str, ...]:
    """Packages that the method needs and that are not installed."""
    return tuple(name for name in needs(method) if find_spec(name) is None) if method else ()


def check(claim: Claim, known: Entry | None = None) -> Entry:
    """The claim's entry; NOT_CHECKED where a package is missing.

    The verdict is found and the product's functions are searched anew in any case; an earlier
    entry, ``known``, says what to try first.  Two things are taken from it: other solvers' word,
    where graphs, method and versions are the same; what altering functions did, where the
    functions are, too.
    """
    if claim.statement is None or claim.method is None:
        return _entry(claim, claim.verdict)
    absent = missing(claim.method)
    if absent:
        return _entry(claim, NOT_CHECKED, method=f"needs {', '.join(absent)}")
    started, method = process_time(), claim.method
    if known is not None and isinstance(method, Z3):  # what closed it before first: saves time
        method = replace(method, first=tuple(known.evidence.get("engines", ())))
    finding, mutated = method.decide(claim.statement(CLAIMED)), None
    if finding.verdict == PROVED:
        mutated = _quick(method).decide(claim.statement(MUTATED)).verdict == REFUTED
    seconds = round(process_time() - started, 2)
    entered, now = graph_hash(claim), versions(claim.method)
    decided = {name: known.versions.get(name) for name in now} if known else {}
    same = known if known and (known.graph_hash, decided) == (entered, now) else None
    functions = functions_of(claim, tuple(known.altered) if known else ())
    then = same.altered if same and set(same.altered) == set(functions) else {}
    verdict, reason = _guarded(finding, mutated, functions)
    told = finding.evidence
    counts = [
        f"{told[many]} {one if told[many] == 1 else many}"
        for one, many in (("case", "cases"), ("box", "boxes"))
        if many in told
    ]
    return _entry(
        claim,
        verdict,
        method=", ".join([named(claim.method), *counts]),
        trusted=trusted(claim.method),
        mutation_refuted=mutated,
        counterexample=_text(finding.point) if verdict == REFUTED else None,
        satisfied_at=_text(finding.point) if verdict in (PROVED, LEMMA) else None,
        seconds=seconds,
        graph_hash=entered,
        versions=now,
        altered={name: then.get(name, "") for name in functions},
        confirmed_by=same.confirmed_by if same else (),
        evidence={**told, **reason},
    )


def graph_hash(claim: Claim) -> str:
    """Hash of what is claimed and altered on which graph now, and by which method; see `Entry`."""
    if claim.statement is None:
        return ""
    both = [claim.statement(way).digest for way in (CLAIMED, MUTATED)]
    return sha256(json.dumps([*both, described(claim.method)]).encode()).hexdigest()


def _quick(method: Method) -> Method:
    """Method for the altered claim: the first case that fails is enough; of two methods each must
    refute.
    """
    if isinstance(method, Both):
        return Both(_quick(method.first), _quick(method.second), all_refute=True)
    return replace(method, quick=True) if isinstance(method, Ring) else method


def _guarded(
    finding: Finding, mutated: bool | None, functions: tuple[str, ...]
) -> tuple[str, dict[str, str]]:
    """PROVED only of functions of the product, with a refuted mutation and possible hypotheses."""
    if finding.verdict != PROVED:
        return finding.verdict, {}
    if not mutated:
        return OPEN, {"held back": "the altered claim was not refuted"}
    if finding.point is None:
        return OPEN, {"held back": "no point was found that satisfies the hypotheses"}
    return (PROVED if functions else LEMMA), {}


def _text(point: Mapping[str, Any] | None) -> dict[str, str] | None:
    """A point as exact text: ``p/q``, or ``1 pi``."""
    if point is None:
        return None
    return {name: v if isinstance(v, str) else str(Fraction(v)) for name, v in point.items()}


def _entry(claim: Claim, verdict: str, **found: Any) -> Entry:
    return Entry(id=claim.id, verdict=verdict, **claim.words(), **found)
