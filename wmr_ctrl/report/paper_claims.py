"""The paper's claims: their tests, and verdicts by one rule for every claim."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum

from wmr_ctrl.core.data import data, with_tuples
from wmr_ctrl.core.paper import EVALUATIONS, PAPER_TIMES
from wmr_ctrl.results.table import RunTable, Spread, ratios, spread

from .style import ABSENT, shown


class Verdict(StrEnum):
    """Verdict on a claim; the value is the phrase in files and pages.

    The last three are about a law that replaces one of the paper's.
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
CONTROL = 0.01
"""Control period of Section V [s], as it is read into the paper."""
_TIMES = {"paper_time", "our_time"}
RULE = (
    "A test passes if its bound is kept in every seed. A claim HOLDS if all of its tests pass, "
    "HOLDS IN PART if some do, and DOES NOT HOLD if none does. A claim that something never "
    "happens is NOT VIOLATED where it was not seen to happen: runs can show no more. SMC stands in "
    "for the law of the paper’s reference [32], which the paper does not give, so its tests say "
    "nothing about the paper: a claim about SMC alone gets a verdict on the STAND-IN, and one "
    "about SMC among others HOLDS IN PART at best."
)
"""The rule, for readers."""


@dataclass(frozen=True)
class TestSpec:
    """One number of the runs, and the bound that it must keep in every seed.

    The worst of all pairs of ``scenarios`` and ``laws`` is used. Without ``at_least`` and
    ``at_most`` the number is only reported. ``over``: ``figure``, ``scenario`` or ``law`` of the
    divisor, if it differs from the test's own. ``unit`` is for readers.
    """

    __test__ = False  # not a test of pytest's

    key: str
    text: str
    figure: str
    scenarios: tuple[str, ...] = ("paper-simulation",)
    laws: tuple[str, ...] = ()
    over: Mapping[str, str] | None = None
    at_least: float | None = None
    at_most: float | None = None
    unit: str = ""

    @property
    def decides(self) -> bool:
        """True if the test has a bound."""
        return self.at_least is not None or self.at_most is not None

    @property
    def stand_in(self) -> bool:
        """True if the number belongs to the law that replaces reference [32]."""
        return STAND_IN_LAW in (*self.laws, (self.over or {}).get("law"))

    @property
    def bound(self) -> str:
        """The bound as text for readers, empty if there is none."""
        for sign, bound in (("≥", self.at_least), ("≤", self.at_most)):
            if bound is not None:
                text = f"{self.scale * bound:g}" if bound >= 1e-3 else shown(self.scale * bound, 1)
                return f"{sign} {text}"
        return ""

    @property
    def scale(self) -> float:
        """Factor from SI to the readers' unit: lengths are in mm."""
        return 1e3 if self.unit == "m" else 1.0

    @property
    def label(self) -> str:
        """Name of the measured quantity, with the readers' unit."""
        unit = f" [{'mm' if self.unit == 'm' else self.unit}]" if self.unit else ""
        return f"{self.text}{' (stand-in)' if self.stand_in else ''}{unit}"

    def written(self, value: float | None) -> str:
        """A number in the readers' unit."""
        return shown(None if value is None else self.scale * value)

    def keeps(self, value: float | None) -> bool:
        """True if a value keeps the bound; a missing one never does."""
        if value is None:
            return False
        low, high = self.at_least, self.at_most
        return (low is None or value >= low) and (high is None or value <= high)


@dataclass(frozen=True)
class PaperClaim:
    """A claim of the paper with its tests; every text is one or two plain sentences.

    ``explanation`` may quote tests by ``{key}`` (`Quoted`) and is written for the verdict
    ``expected``. ``never``: the claim is that something never happens, which runs can refute but
    not prove.
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


@dataclass(frozen=True)
class Measured:
    """A test with its value in each seed."""

    spec: TestSpec
    values: Mapping[int, float | None]

    @property
    def passed(self) -> bool | None:
        """True if the bound is kept in every seed; None for a test without a bound."""
        if not self.spec.decides:
            return None
        return bool(self.values) and self.keeping == len(self.values)

    @property
    def keeping(self) -> int:
        """Number of seeds that keep the bound."""
        return sum(map(self.spec.keeps, self.values.values()))

    @property
    def spread(self) -> Spread:
        """The spread of the values over the seeds."""
        return spread(self.values.values())


@dataclass(frozen=True)
class Quoted:
    """A test quoted in a sentence: its median, or another reading of the runs, by its format.

    ``%``: the median in per cent; ``mm``: the median in mm; ``range``: least to greatest in mm;
    ``broken``: in how many seeds a share of the limit is above 1.
    """

    test: Measured

    def __format__(self, spec: str) -> str:
        values = [value for value in self.test.values.values() if value is not None]
        if spec == "broken":
            return f"{sum(value > 1 for value in values)} of {len(values)} seeds"
        if not values:
            return ABSENT
        if spec == "range":
            return f"{shown(1000 * min(values), 2)} to {shown(1000 * max(values), 2)} mm"
        factor, digits, unit = {"%": (100, 2, " %"), "mm": (1000, 2, " mm"), "": (1, 3, "")}[spec]
        return f"{shown(factor * (self.test.spread.median or 0.0), digits)}{unit}"


@dataclass(frozen=True)
class Judged:
    """A claim, its tests with their values, and the resulting verdict."""

    claim: PaperClaim
    tests: tuple[Measured, ...]
    verdict: Verdict
    explanation: str = field(default="")

    @property
    def as_expected(self) -> bool:
        """True if the verdict is the committed one."""
        return self.verdict == self.claim.expected


def load_claims() -> tuple[PaperClaim, ...]:
    """All claims in the report's order, each with its committed verdict.

    Raises KeyError if a claim has no committed verdict, ValueError if a verdict has no claim.
    """
    entries, verdicts = (
        data(__package__, "claims.toml")["claim"],
        data(__package__, "verdicts.toml"),
    )
    orphans = set(verdicts) - {entry["id"] for entry in entries}
    if orphans:
        raise ValueError(f"verdicts.toml names claims that do not exist: {sorted(orphans)}")
    return tuple(
        PaperClaim(
            **{name: value for name, value in entry.items() if name != "test"},
            tests=tuple(TestSpec(**with_tuples(test)) for test in entry["test"]),
            expected=Verdict(verdicts[entry["id"]]),
        )
        for entry in entries
    )


@dataclass(frozen=True)
class Evidence:
    """The table that claims are judged by, and our seconds per 10,000 evaluations by law."""

    table: RunTable
    times: Mapping[str, float] = field(default_factory=dict)

    def values(self, spec: TestSpec) -> dict[int, float | None]:
        """The number of a test, by seed: the worst of several cases.

        Times have no seeds and are under key 0.
        """
        if spec.figure in _TIMES:  # of the slowest law, as a share of the control period
            times = PAPER_TIMES if spec.figure == "paper_time" else self.times
            return {0: max(times[law] for law in spec.laws or times) / EVALUATIONS / CONTROL}
        cases = [self._case(spec, one, law) for one in spec.scenarios for law in spec.laws]
        seeds = set.intersection(*(set(case) for case in cases))
        return {seed: _worst(spec, [case[seed] for case in cases]) for seed in sorted(seeds)}

    def has(self, spec: TestSpec) -> bool:
        """True if a test can be made; only our times may be missing."""
        return spec.figure != "our_time" or bool(self.times)

    def _case(self, spec: TestSpec, scenario: str, law: str) -> dict[int, float | None]:
        values, over = self.table.case(scenario, law).by_seed(spec.figure), spec.over
        if over is None:
            return values
        runs = self.table.case(over.get("scenario", scenario), over.get("law", law))
        return ratios(values, runs.by_seed(over.get("figure", spec.figure)))


def _worst(spec: TestSpec, values: list[float | None]) -> float | None:
    """The value that is farthest from keeping the bound; None if one is missing."""
    known = [value for value in values if value is not None]
    if len(known) < len(values):
        return None
    return min(known) if spec.at_least is not None else max(known)


def judge_all(evidence: Evidence) -> tuple[Judged, ...]:
    """Judge the paper's claims."""
    return tuple(judge(claim, evidence) for claim in load_claims())


def judge(claim: PaperClaim, evidence: Evidence) -> Judged:
    """Judge a claim by its tests.

    The explanation is omitted if the verdict is not the one that it was written for.
    """
    tests = tuple(Measured(t, evidence.values(t)) for t in claim.tests if evidence.has(t))
    verdict = verdict_of(tests, claim.never)
    quoted = {test.spec.key: Quoted(test) for test in tests}
    text = claim.explanation.format(**quoted) if verdict == claim.expected else ""
    return Judged(claim, tests, verdict, text)


def verdict_of(tests: Sequence[Measured], never: bool = False) -> Verdict:
    """Verdict from the deciding tests; without any, the claim fails."""
    deciding = [test for test in tests if test.passed is not None]
    if not deciding:
        return Verdict.FAILS
    own = [test.passed is True for test in deciding if not test.spec.stand_in]
    if not own:
        passed = [test.passed for test in deciding]
        if all(passed):
            return Verdict.STAND_IN
        return Verdict.STAND_IN_PART if any(passed) else Verdict.STAND_IN_FAILS
    if never:
        return Verdict.UNBROKEN if all(own) else Verdict.FAILS
    if all(own) and len(own) == len(deciding):
        return Verdict.HOLDS
    return Verdict.IN_PART if any(own) else Verdict.FAILS


def load_readings() -> list[dict[str, object]]:
    """Our readings of the paper's open points.

    Entries have ``topic``, ``said``, ``reading``, ``why`` and the scenario's ``keys``.
    """
    return list(data(__package__, "readings.toml")["reading"])
