"""Where the guard and our law fall short, in sentences whose numbers are the rows'."""

from __future__ import annotations

from wmr_ctrl.campaign.ours_run import REFUSED
from wmr_ctrl.report.ours.bounds import refusal_of
from wmr_ctrl.report.ours.findings import joined
from wmr_ctrl.report.ours.rows import BASE, Rows, broke, median
from wmr_ctrl.report.style import look
from wmr_ctrl.report.wording import shown

FAR, ADVERSARY = "far start", "adversary"
SPINS = 100.0
"""A guarded run with this many times the base case's ISE does not follow its reference."""

NOTICED = 1.1
"""Growth of e1 from which on it is told."""


def shortfalls(rows: Rows) -> tuple[tuple[str, str], ...]:
    """Heading and sentences of each; those without rows behind them are left out."""
    told = (
        (
            "SMC, whose adaptation does not know that its force is cut, winds up.",
            " ".join(_wind_up(rows, b) for b in rows.bases),
        ),
        ("Inside the limit is not on the path.", " ".join(_spin(rows, b) for b in rows.bases)),
        ("Too little torque is refused.", _refused(rows)),
        ("prox alone is no guarantee.", " ".join(_prox(rows, b) for b in rows.bases)),
        ("The guard has a price.", " ".join(_price(rows, b) for b in rows.bases)),
    )
    return tuple((head, text.strip()) for head, text in told if text.strip())


def _wind_up(rows: Rows, base: str) -> str:
    found = {law: rows.median("ise", base, FAR, law, True) for law in rows.laws}
    smc, others = found.pop("smc", None), [v for v in found.values() if v is not None]
    if smc is None or not others:
        return ""
    late = rows.median("e1_after", base, FAR, "smc", True)
    share = median(r.clipped[0] for r in rows.of(base, FAR, "smc", True) if r.clipped)
    return (
        f"From the far start, torque held for {base}: ISE {shown(smc)} m² s + rad² s, "
        f"where the other laws have {shown(min(others))} to {shown(max(others))}; "
        f"{shown(late)} m of e₁ are left at 70–80 s, and the thrust is clipped "
        f"{shown(None if share is None else 100 * share)} % of the time."
    )


def _spin(rows: Rows, base: str) -> str:
    lost: list[str] = []
    kept: list[str] = []
    for law in rows.laws:
        there, usual = (rows.median("ise", base, f, law, True) for f in (ADVERSARY, BASE))
        if there is None or usual is None:
            continue
        name = f"{look(law).label} (ISE {shown(there)})"
        (lost if there > SPINS * usual else kept).append(name)
    if not lost:
        return ""
    keep = f" On the path: {joined(kept)}." if kept else ""
    return (
        f"Under the adversary, torque held for {base}, these never break a limit with the guard, "
        f"but spin or run along it instead of following the reference: {joined(lost)}.{keep}"
    )


def _refused(rows: Rows) -> str:
    refused = [row for row in rows.all if row.outcome == REFUSED]
    if not refused:
        return ""
    cases = tuple(dict.fromkeys(row.case.factor for row in refused))
    alone = [r for r in rows.guarded(False) if r.case.factor in cases]
    words = refusal_of(refused[0].case.base, cases[0])
    return (
        f"All guarded runs with {joined(cases)} ({len(refused)}) were refused before they began: "
        f"“{words}” Without the guard the same cases run; {sum(map(broke, alone))} of {len(alone)} "
        "broke a limit."
    )


def _prox(rows: Rows, base: str) -> str:
    bad = []
    for factor in rows.factors(base):
        runs = rows.of(base, factor, "prox", False)
        if factor != "start outside" and any(map(broke, runs)):
            top = max((max(r.speed) for r in runs if r.speed), default=None)
            count = f"{sum(map(broke, runs))} of {len(runs)} runs"
            bad.append(f"{factor} ({count}, {shown(top)} times the limit)")
    if not bad:
        return ""
    return f"Torque held for {base}, without the guard, it breaks a limit in: {'; '.join(bad)}."


def _price(rows: Rows, base: str) -> str:
    far = _pairs(rows, base, FAR, "ise", 0.0)
    worse = _pairs(rows, base, BASE, "e1_after", NOTICED, 1e3)
    told = [f"ISE from the far start {joined(far)}"] if far else []
    told += [f"mean |e₁| at 70–80 s of the base case [mm], where larger, {joined(worse)}"] * bool(
        worse
    )
    if not told:
        return ""
    return f"With the guard (without it), torque held for {base}: {'; '.join(told)}."


def _pairs(
    rows: Rows, base: str, factor: str, name: str, least: float, scale: float = 1.0
) -> list[str]:
    """A figure with (without) the guard of each law in which it grows at least ``least`` times."""
    cells = []
    for law in rows.laws:
        free, kept = (rows.median(name, base, factor, law, guard) for guard in (False, True))
        if free is not None and kept is not None and kept >= least * free:
            cells.append(f"{look(law).label} {shown(scale * kept)} ({shown(scale * free)})")
    return cells
