"""What the comparison shows, in sentences whose numbers are the rows'."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from wmr_ctrl.campaign.ours_run import Comparison
from wmr_ctrl.report.ours.bounds import start_ratio
from wmr_ctrl.report.ours.rows import BASE, OUTSIDE, Rows, broke, median
from wmr_ctrl.report.style import look
from wmr_ctrl.report.wording import ABSENT, shown
from wmr_ctrl.results import Outcome

ALWAYS = 0.25
"""Share of samples in clip from which on it is the guard, not the law, that steers."""


def findings(rows: Rows) -> tuple[str, ...]:
    """What the guard and the law do; sentences without rows behind them are left out."""
    told = (
        _kept(rows),
        _bounds_left(rows),
        _outside(rows),
        *(_after(rows, base) for base in rows.bases),
        *(_steers(rows, base) for base in rows.bases),
    )
    return tuple(sentence for sentence in told if sentence)


def _kept(rows: Rows) -> str:
    with_, without = (
        [r for r in rows.guarded(guard) if r.case.factor != OUTSIDE] for guard in (True, False)
    )
    if not with_ or not without:
        return ""
    return (
        f"Of {len(with_)} guarded runs that start inside the limits, {sum(map(broke, with_))} "
        f"broke one; of {len(without)} runs without the guard, {sum(map(broke, without))} did. "
        f"Largest |v|/limit: {shown(_fastest(with_), 4)} with the guard, "
        f"{shown(_fastest(without), 4)} without it."
    )


def _bounds_left(rows: Rows) -> str:
    count = sum(1 for row in rows.guarded() if row.outcome == Outcome.BOUNDS_LEFT)
    return (
        f"Guarded runs whose motion contradicts the bounds that the guard was given (outcome "
        f"bounds-left): {count}. They are counted apart from violations."
    )


def _outside(rows: Rows) -> str:
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


def _after(rows: Rows, base: str) -> str:
    cells = [
        f"{look(law).label} {_mm(rows.median('e1_after', base, BASE, law, True))} "
        f"({_mm(rows.median('e1_after', base, BASE, law, False))})"
        for law in rows.laws
        if rows.of(base, BASE, law, True)
    ]
    if not cells:
        return ""
    return (
        f"Torque held for {base}, base case: mean |e₁| after the change of parameters with the "
        f"guard (without it): {joined(cells)}."
    )


def _steers(rows: Rows, base: str) -> str:
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


def _fastest(found: Iterable[Comparison]) -> float | None:
    return max((max(row.speed) for row in found if row.speed), default=None)


def _mm(value: float | None) -> str:
    return ABSENT if value is None else f"{shown(1e3 * value, 2)} mm"


def _percent(value: float | None) -> str:
    return ABSENT if value is None else f"{shown(100 * value, 2)} %"
