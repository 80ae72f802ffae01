"""What a claim, its tests and its verdict are; and the paper's claims, from the files beside."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from importlib.resources import files
from typing import Any

from wmr_ctrl.campaign import Spread, spread
from wmr_ctrl.report.style import ABSENT, shown, spoken


class Verdict(StrEnum):
    """What became of a claim; the value is the phrase that files and pages show.

    The last three are about a law that only stands in for the paper's.
    """

    HOLDS = "HOLDS"
    UNBROKEN = "NOT VIOLATED"
    IN_PART = "HOLDS IN PART"
    FAILS = "DOES NOT HOLD"
    STAND_IN = "STAND-IN AGREES"
    STAND_IN_PART = "STAND-IN AGREES IN PART"
    STAND_IN_FAILS = "STAND-IN DISAGREES"


STAND_IN_LAW = "smc"
"""The paper's reference [32] is not in its text: whatever this law does says nothing about it."""


@dataclass(frozen=True, slots=True)
class Divisor:
    """What a test divides by; a name that is empty is the test's own."""

    figure: str = ""
    scenario: str = ""
    law: str = ""


@dataclass(frozen=True, slots=True)
class TestSpec:
    """How one number is taken from the runs, and the bound that it must keep in every seed.

    The worst of all pairs of ``scenarios`` and ``laws`` counts.  Without ``at_least`` and
    ``at_most`` the number is reported and decides nothing.  ``unit`` is for readers.
    """

    __test__ = False  # not a test of pytest's

    key: str
    text: str
    figure: str
    scenarios: tuple[str, ...] = ("paper-simulation",)
    laws: tuple[str, ...] = ()
    over: Divisor | None = None
    at_least: float | None = None
    at_most: float | None = None
    unit: str = ""

    @property
    def decides(self) -> bool:
        """Whether the test has a bound."""
        return self.at_least is not None or self.at_most is not None

    @property
    def stand_in(self) -> bool:
        """Whether the number is one of the law that stands in for reference [32]."""
        return STAND_IN_LAW in self.laws or (
            self.over is not None and self.over.law == STAND_IN_LAW
        )

    @property
    def bound(self) -> str:
        """The bound as readers write it, empty if there is none."""
        if self.at_least is not None:
            return f"≥ {_short(self.at_least)}"
        return f"≤ {_short(self.at_most)}" if self.at_most is not None else ""

    def keeps(self, value: float | None) -> bool:
        """Whether a value keeps the bound; a missing one never does."""
        if value is None:
            return False
        low, high = self.at_least, self.at_most
        return (low is None or value >= low) and (high is None or value <= high)


def _short(bound: float) -> str:
    return f"{bound:g}" if bound >= 1e-3 else shown(bound, 1)


@dataclass(frozen=True, slots=True)
class PaperClaim:
    """A claim of the paper and how it is judged; every text is a plain sentence or two.

    ``explanation`` may quote tests by ``{key}`` (`Quoted`) and is written for the verdict
    ``expected``.
    ``never``: the claim is that something never happens, which runs can refute but not show.
    """

    id: str
    section: str
    title: str
    quote: str
    threshold: str
    explanation: str
    tests: tuple[TestSpec, ...]
    expected: Verdict
    never: bool = False


@dataclass(frozen=True, slots=True)
class Measured:
    """A test with its value in each seed."""

    spec: TestSpec
    values: Mapping[int, float | None]

    @property
    def passed(self) -> bool | None:
        """Whether the bound is kept in every seed; None for a test without a bound."""
        if not self.spec.decides:
            return None
        return bool(self.values) and all(map(self.spec.keeps, self.values.values()))

    @property
    def keeping(self) -> int:
        """Number of seeds that keep the bound."""
        return sum(map(self.spec.keeps, self.values.values()))

    @property
    def spread(self) -> Spread:
        """The spread of the values over the seeds."""
        return spread(self.values.values())


@dataclass(frozen=True, slots=True)
class Quoted:
    """A test in a sentence: its median, or by the format what the runs at hand say.

    ``broken``: in how many seeds a share of the limit is above 1; ``range``: least to greatest, of
    metres in mm; else as `wmr_ctrl.report.style.SpokenNumber`.
    """

    test: Measured

    def __format__(self, spec: str) -> str:
        values = [value for value in self.test.values.values() if value is not None]
        if spec == "broken":
            return f"{sum(value > 1 for value in values)} of {len(values)} seeds"
        if spec != "range":
            return format(spoken(self.test.spread.median), spec)
        if not values:
            return ABSENT
        return f"{shown(1000 * min(values), 2)} to {shown(1000 * max(values), 2)} mm"


@dataclass(frozen=True, slots=True)
class Judged:
    """A claim, its tests with their values, and the verdict that follows from them."""

    claim: PaperClaim
    tests: tuple[Measured, ...]
    verdict: Verdict
    explanation: str = field(default="")

    @property
    def as_expected(self) -> bool:
        """Whether the verdict is the committed one."""
        return self.verdict == self.claim.expected


def load_claims() -> tuple[PaperClaim, ...]:
    """All claims in the report's order, each with its committed verdict.

    Raises KeyError where a claim has no committed verdict, ValueError where a verdict has no claim.
    """
    entries = _data("claims.toml")["claim"]
    verdicts = _data("verdicts.toml")
    orphans = set(verdicts) - {entry["id"] for entry in entries}
    if orphans:
        raise ValueError(f"verdicts.toml names claims that do not exist: {sorted(orphans)}")
    return tuple(_claim(entry, Verdict(verdicts[entry["id"]])) for entry in entries)


def _claim(entry: dict[str, Any], expected: Verdict) -> PaperClaim:
    texts = {name: value for name, value in entry.items() if name != "test"}
    return PaperClaim(**texts, tests=tuple(map(_test, entry["test"])), expected=expected)


def _test(entry: dict[str, Any]) -> TestSpec:
    values: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in entry.items()}
    if "over" in values:
        values["over"] = Divisor(**values["over"])
    return TestSpec(**values)


def _data(name: str) -> dict[str, Any]:
    text = files("wmr_ctrl.report.claims").joinpath(name).read_text(encoding="utf-8")
    return tomllib.loads(text)
