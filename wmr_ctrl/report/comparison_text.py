"""The section past the paper: what the comparison shows and where guard and law fall short.

All numbers in its sentences are the rows'.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from wmr_ctrl.campaign.comparison import (
    BASE,
    BASES,
    FAR_START,
    OUTSIDE,
    PUSHED,
    REFUSED,
    SCENARIO,
    ComparedFigure,
    ComparedRun,
    GuardComparison,
    e1_after_of,
    ise_of,
    median,
    overrides_of,
    position_rms_of,
)
from wmr_ctrl.report.drawing import Drawing
from wmr_ctrl.report.guard_price_table import price_table
from wmr_ctrl.report.style import ABSENT, look, shown
from wmr_ctrl.report.tables import TextTable, comparison_tables
from wmr_ctrl.results import Outcome
from wmr_ctrl.scenario import load_scenario

ALWAYS = 0.25
"""Share of samples in clip from which on it is the guard, not the law, that steers."""


def findings(rows: GuardComparison) -> tuple[str, ...]:
    """What the guard and the law do; sentences without rows behind them are left out."""
    sentences = (
        _limits_kept(rows),
        _bounds_left(rows),
        _outside(rows),
        *(_after(rows, base) for base in rows.bases),
        *(_steers(rows, base) for base in rows.bases),
    )
    return tuple(sentence for sentence in sentences if sentence)


def _limits_kept(rows: GuardComparison) -> str:
    with_, without = (
        [r for r in rows.guarded(guard) if r.case.factor != OUTSIDE] for guard in (True, False)
    )
    if not with_ or not without:
        return ""
    return (
        f"Of {len(with_)} guarded runs that start inside the limits, {_broken(with_)} "
        f"broke one; of {len(without)} runs without the guard, {_broken(without)} did. "
        f"Largest |v|/limit: {shown(_fastest(with_), 4)} with the guard, "
        f"{shown(_fastest(without), 4)} without it."
    )


def _bounds_left(rows: GuardComparison) -> str:
    count = sum(1 for row in rows.guarded() if row.outcome == Outcome.BOUNDS_LEFT)
    return (
        f"Guarded runs whose motion contradicts the bounds that the guard was given (outcome "
        f"bounds-left): {count}. They are counted apart from violations."
    )


def _outside(rows: GuardComparison) -> str:
    with_, without = (
        [r for r in rows.guarded(guard) if r.case.factor == OUTSIDE] for guard in (True, False)
    )
    if not with_ or not without:
        return ""
    most, never = max(r.violations for r in with_), max(r.violations for r in without)
    return (
        f"From a start outside the limits (|v|/limit {shown(start_ratio(OUTSIDE), 4)}) guarded "
        f"runs spent at most {most} plant steps outside; largest |v|/limit "
        f"{shown(_fastest(with_), 4)}. Without the guard it was up to {never} steps and "
        f"{shown(_fastest(without), 4)}."
    )


def _after(rows: GuardComparison, base: str) -> str:
    cells = [
        f"{look(law).label} {_mm(rows.median(position_rms_of, base, BASE, law, True))} "
        f"({_mm(rows.median(position_rms_of, base, BASE, law, False))})"
        for law in rows.laws
        if rows.of(base, BASE, law, True)
    ]
    if not cells:
        return ""
    return (
        f"Torque held for {base}, base case: RMS distance from the reference after the change of "
        f"parameters with the guard (without it): {joined(cells)}."
    )


def _steers(rows: GuardComparison, base: str) -> str:
    shares = {
        law: median(max(r.clipped) for r in rows.of(base, BASE, law, True) if r.clipped)
        for law in rows.laws
    }
    much = [f"{look(law).label} {_percent(x)}" for law, x in shares.items() if (x or 0) > ALWAYS]
    if not much:
        return ""
    return (
        f"Torque held for {base}, base case, share of samples in which the guard changes the "
        f"force: {joined(much)}. There it is the guard that keeps the robot steady; these gains "
        "are not made for this period."
    )


def joined(parts: Sequence[str]) -> str:
    """Words as a list in a sentence."""
    return " and ".join((", ".join(parts[:-1]), parts[-1])) if len(parts) > 1 else "".join(parts)


def _broken(runs: Iterable[ComparedRun]) -> int:
    return sum(1 for row in runs if row.broke)


def _fastest(runs: Iterable[ComparedRun]) -> float | None:
    return max((max(row.speed) for row in runs if row.speed), default=None)


def _mm(value: float | None) -> str:
    return ABSENT if value is None else f"{shown(1e3 * value, 2)} mm"


def _percent(value: float | None) -> str:
    return ABSENT if value is None else f"{shown(100 * value, 2)} %"


SPINS = 100.0
"""A guarded run with this many times the base case's ISE does not follow its reference."""

NOTICED = 1.1
"""Growth of e1 from which on it is mentioned."""


def shortfalls(rows: GuardComparison) -> tuple[tuple[str, str], ...]:
    """Heading and sentences of each; those without rows behind them are left out."""
    points = (
        (
            "SMC, whose adaptation does not know that its force is cut, winds up.",
            " ".join(_wind_up(rows, b) for b in rows.bases),
        ),
        ("Inside the limit is not on the path.", " ".join(_spin(rows, b) for b in rows.bases)),
        ("Too little torque is refused.", _refused(rows)),
        ("prox alone is no guarantee.", " ".join(_prox(rows, b) for b in rows.bases)),
        ("The guard has a price.", " ".join(_price(rows, b) for b in rows.bases)),
    )
    return tuple((head, text.strip()) for head, text in points if text.strip())


def _wind_up(rows: GuardComparison, base: str) -> str:
    ise = {law: rows.median(ise_of, base, FAR_START, law, True) for law in rows.laws}
    smc, others = ise.pop("smc", None), [v for v in ise.values() if v is not None]
    if smc is None or not others:
        return ""
    late = rows.median(e1_after_of, base, FAR_START, "smc", True)
    share = median(r.clipped[0] for r in rows.of(base, FAR_START, "smc", True) if r.clipped)
    return (
        f"From the far start, torque held for {base}: ISE {shown(smc)} m² s + rad² s, "
        f"where the other laws have {shown(min(others))} to {shown(max(others))}; "
        f"{shown(late)} m of e₁ are left at 70–80 s, and the thrust is clipped "
        f"{shown(None if share is None else 100 * share)} % of the time."
    )


def _spin(rows: GuardComparison, base: str) -> str:
    lost: list[str] = []
    steady: list[str] = []
    for law in rows.laws:
        there, usual = (rows.median(ise_of, base, f, law, True) for f in (PUSHED, BASE))
        if there is None or usual is None:
            continue
        name = f"{look(law).label} (ISE {shown(there)})"
        (lost if there > SPINS * usual else steady).append(name)
    if not lost:
        return ""
    rest = f" On the path: {joined(steady)}." if steady else ""
    return (
        f"Under the adversary, torque held for {base}, these never break a limit with the guard, "
        f"but spin or run along it instead of following the reference: {joined(lost)}.{rest}"
    )


def _refused(rows: GuardComparison) -> str:
    refused = [row for row in rows.rows if row.outcome == REFUSED]
    if not refused:
        return ""
    cases = tuple(dict.fromkeys(row.case.factor for row in refused))
    alone = [r for r in rows.guarded(False) if r.case.factor in cases]
    words = refused[0].refusal
    return (
        f"All guarded runs with {joined(cases)} ({len(refused)}) were refused before they began: "
        f"“{words}” Without the guard the same cases run; {_broken(alone)} of {len(alone)} "
        "broke a limit."
    )


def _prox(rows: GuardComparison, base: str) -> str:
    bad = []
    for factor in rows.factors(base):
        runs = rows.of(base, factor, "prox", False)
        if factor != OUTSIDE and _broken(runs):
            top = max((max(r.speed) for r in runs if r.speed), default=None)
            count = f"{_broken(runs)} of {len(runs)} runs"
            bad.append(f"{factor} ({count}, {shown(top)} times the limit)")
    if not bad:
        return ""
    return f"Torque held for {base}, without the guard, it breaks a limit in: {'; '.join(bad)}."


def _price(rows: GuardComparison, base: str) -> str:
    far = _pairs(rows, base, FAR_START, ise_of, 0.0)
    worse = _pairs(rows, base, BASE, position_rms_of, NOTICED, 1e3)
    parts = [f"ISE from the far start {joined(far)}"] if far else []
    if worse:
        parts.append(
            f"RMS distance at 70–80 s of the base case [mm], where larger, {joined(worse)}"
        )
    if not parts:
        return ""
    return f"With the guard (without it), torque held for {base}: {'; '.join(parts)}."


def _pairs(
    rows: GuardComparison,
    base: str,
    factor: str,
    figure: ComparedFigure,
    least: float,
    scale: float = 1.0,
) -> list[str]:
    """A figure with (without) the guard of each law in which it grows at least ``least`` times."""
    cells = []
    for law in rows.laws:
        free, held = (rows.median(figure, base, factor, law, guard) for guard in (False, True))
        if free is not None and held is not None and held >= least * free:
            cells.append(f"{look(law).label} {shown(scale * held)} ({shown(scale * free)})")
    return cells


def start_ratio(factor: str) -> float:
    """Largest |v|/limit at the start of a case."""
    scenario = load_scenario(SCENARIO, overrides_of(next(iter(BASES)), factor))
    pairs = zip(scenario.initial.velocity, scenario.limits.v_u1, strict=True)
    return max(abs(v) / limit for v, limit in pairs)


@dataclass(frozen=True, slots=True)
class GuardSection:
    """All that the section's template shows; ``tables`` by base, no ``price`` without its rows."""

    runs: int
    seeds: str
    findings: tuple[str, ...]
    shortfalls: tuple[tuple[str, str], ...]
    price: TextTable | None
    tables: Mapping[str, tuple[TextTable, ...]]
    drawings: Sequence[Drawing]


def guard_section(rows: GuardComparison, drawings: Sequence[Drawing]) -> GuardSection:
    """Counts, sentences, tables and figures."""
    priced = tuple(
        (base, factor)
        for factor in (BASE, PUSHED)
        for base in rows.bases
        if factor in rows.factors(base)
    )
    return GuardSection(
        runs=len(rows.rows),
        seeds=", ".join(map(str, rows.seeds)),
        findings=findings(rows),
        shortfalls=shortfalls(rows),
        price=price_table(rows, priced) if priced else None,
        tables={base: comparison_tables(rows, base) for base in rows.bases},
        drawings=drawings,
    )
