"""From a campaign's numbers to verdicts, by one rule for every claim."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from wmr_ctrl.campaign import FigureTable
from wmr_ctrl.report.claims.claim import (
    Divisor,
    Judged,
    Measured,
    PaperClaim,
    Quoted,
    TestSpec,
    Verdict,
    load_claims,
)

PAPER_TIMES: Mapping[str, float] = {"pid": 0.4056, "smc": 2.0662, "mb": 0.3875, "nn": 1.4294}
"""Seconds that 10,000 evaluations of each law took the paper's authors."""

EVALUATIONS = 10_000
CONTROL = 0.01
"""Control period of Section V [s], as it is read into the paper."""

_TIMES = {"paper_time", "our_time"}


@dataclass(frozen=True)
class Evidence:
    """What claims are judged by: the table, and our seconds per 10,000 evaluations by law."""

    table: FigureTable
    times: Mapping[str, float] = field(default_factory=dict)

    def values(self, spec: TestSpec) -> dict[int, float | None]:
        """The number that a test asks for, by seed: of several cases the worst.

        Times have no seeds and stand under 0.
        """
        if spec.figure in _TIMES:
            return {0: self._share(spec)}
        cases = [self._case(spec, one, law) for one in spec.scenarios for law in spec.laws]
        seeds = set.intersection(*(set(case) for case in cases))
        return {seed: _worst(spec, [case[seed] for case in cases]) for seed in sorted(seeds)}

    def has(self, spec: TestSpec) -> bool:
        """Whether a test can be made; only our times may be missing."""
        return spec.figure != "our_time" or bool(self.times)

    def _share(self, spec: TestSpec) -> float:
        """Time of one evaluation of the slowest law, as a share of the control period."""
        times = PAPER_TIMES if spec.figure == "paper_time" else self.times
        slowest = max(times[law] for law in spec.laws or times)
        return slowest / EVALUATIONS / CONTROL

    def _case(self, spec: TestSpec, scenario: str, law: str) -> dict[int, float | None]:
        values = self.table.values(spec.figure, scenario, law)
        if spec.over is None:
            return values
        other = self._other(spec, spec.over, scenario, law)
        return {s: _ratio(values[s], other[s]) for s in values if s in other}

    def _other(
        self, spec: TestSpec, over: Divisor, scenario: str, law: str
    ) -> dict[int, float | None]:
        return self.table.values(
            over.figure or spec.figure, over.scenario or scenario, over.law or law
        )


def _ratio(value: float | None, other: float | None) -> float | None:
    return value / other if value is not None and other else None


def _worst(spec: TestSpec, values: list[float | None]) -> float | None:
    """The value that is farthest from keeping the bound; None if one is missing."""
    known = [value for value in values if value is not None]
    if len(known) < len(values):
        return None
    return min(known) if spec.at_least is not None else max(known)


RULE = (
    "A test passes if its bound is kept in every seed. A claim HOLDS if all of its tests pass, "
    "HOLDS IN PART if some do, and DOES NOT HOLD if none does. A claim that something never "
    "happens is NOT VIOLATED where it was not seen to happen: runs can show no more. SMC stands in "
    "for the law of the paper’s reference [32], which the paper does not give, so its tests say "
    "nothing about the paper: a claim about SMC alone gets a verdict on the STAND-IN, and one "
    "about SMC among others HOLDS IN PART at best."
)
"""The rule, for readers."""


def judge_all(evidence: Evidence, claims: Iterable[PaperClaim] | None = None) -> tuple[Judged, ...]:
    """Judge ``claims``, by default those of the paper."""
    return tuple(judge(claim, evidence) for claim in (claims or load_claims()))


def judge(claim: PaperClaim, evidence: Evidence) -> Judged:
    """Put a claim to its tests.

    The explanation is left out where the verdict is not the one that it was written for.
    """
    tests = tuple(Measured(t, evidence.values(t)) for t in claim.tests if evidence.has(t))
    verdict = verdict_of(tests, claim.never)
    text = _explained(claim, tests) if verdict == claim.expected else ""
    return Judged(claim, tests, verdict, text)


def verdict_of(tests: Sequence[Measured], never: bool = False) -> Verdict:
    """The verdict that follows from the tests that decide; without any, nothing holds."""
    deciding = [test for test in tests if test.passed is not None]
    if not deciding:
        return Verdict.FAILS
    own = [test.passed is True for test in deciding if not test.spec.stand_in]
    if not own:
        return _of_stand_in([test.passed is True for test in deciding])
    if never:
        return Verdict.UNBROKEN if all(own) else Verdict.FAILS
    if all(own) and len(own) == len(deciding):
        return Verdict.HOLDS
    return Verdict.IN_PART if any(own) else Verdict.FAILS


def _of_stand_in(passed: Sequence[bool]) -> Verdict:
    if all(passed):
        return Verdict.STAND_IN
    return Verdict.STAND_IN_PART if any(passed) else Verdict.STAND_IN_FAILS


def _explained(claim: PaperClaim, tests: Sequence[Measured]) -> str:
    return claim.explanation.format(**{test.spec.key: Quoted(test) for test in tests})
