"""From tests to verdicts, by one rule for every claim."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from wmr_ctrl.report.claims.claim import Claim, Judged, Measured, Verdict
from wmr_ctrl.report.claims.load import load_claims
from wmr_ctrl.report.claims.sources import Evidence
from wmr_ctrl.report.wording import told

RULE = (
    "A test passes if its bound is kept in every seed. A claim HOLDS if all of its tests pass, "
    "HOLDS IN PART if some do, and DOES NOT HOLD if none does."
)
"""The rule, for readers."""


def judge_all(evidence: Evidence, claims: Iterable[Claim] | None = None) -> tuple[Judged, ...]:
    """Judge ``claims``, by default those of the paper."""
    return tuple(judge(claim, evidence) for claim in (claims or load_claims()))


def judge(claim: Claim, evidence: Evidence) -> Judged:
    """Put a claim to its tests.

    The explanation is left out where the verdict is not the one that it was written for.
    """
    tests = tuple(Measured(t, evidence.values(t)) for t in claim.tests if evidence.has(t))
    verdict = verdict_of(tests)
    text = _explained(claim, tests) if verdict == claim.expected else ""
    return Judged(claim, tests, verdict, text)


def verdict_of(tests: Sequence[Measured]) -> Verdict:
    """The verdict that follows from the tests that decide."""
    passed = [test.passed for test in tests if test.passed is not None]
    if all(passed):
        return Verdict.HOLDS
    return Verdict.IN_PART if any(passed) else Verdict.FAILS


def _explained(claim: Claim, tests: Sequence[Measured]) -> str:
    medians = {test.spec.key: told(test.found.median) for test in tests}
    return claim.explanation.format(**medians)
