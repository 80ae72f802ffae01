"""Where a test's numbers come from: the campaign's table, or the times per evaluation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from wmr_ctrl.campaign import Table
from wmr_ctrl.report.claims.claim import Other, TestSpec

PAPER_TIMES: Mapping[str, float] = {"pid": 0.4056, "smc": 2.0662, "mb": 0.3875, "nn": 1.4294}
"""Seconds that 10,000 evaluations of each law took the paper's authors."""

EVALUATIONS = 10_000
CONTROL = 0.01
"""Control period of Section V [s], as it is read into the paper."""

_TIMES = {"paper_time", "our_time"}


@dataclass(frozen=True)
class Evidence:
    """What claims are judged by: the table, and our seconds per 10,000 evaluations by law."""

    table: Table
    times: Mapping[str, float] = field(default_factory=dict)

    def values(self, spec: TestSpec) -> dict[int, float | None]:
        """The number that a test asks for, by seed: of several cases the worst.

        Times have no seeds and stand under 0.
        """
        if spec.figure in _TIMES:
            return {0: self._share(spec.figure)}
        cases = [self._case(spec, one, law) for one in spec.scenarios for law in spec.laws]
        seeds = set.intersection(*(set(case) for case in cases))
        return {seed: _worst(spec, [case[seed] for case in cases]) for seed in sorted(seeds)}

    def has(self, spec: TestSpec) -> bool:
        """Whether a test can be made; only our times may be missing."""
        return spec.figure != "our_time" or bool(self.times)

    def _share(self, figure: str) -> float:
        """Time of one evaluation of the slowest law, as a share of the control period."""
        times = PAPER_TIMES if figure == "paper_time" else self.times
        return max(times.values()) / EVALUATIONS / CONTROL

    def _case(self, spec: TestSpec, scenario: str, law: str) -> dict[int, float | None]:
        values = self.table.values(spec.figure, scenario, law)
        if spec.over is None:
            return values
        other = self._other(spec, spec.over, scenario, law)
        return {s: _ratio(values[s], other[s]) for s in values if s in other}

    def _other(
        self, spec: TestSpec, over: Other, scenario: str, law: str
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
