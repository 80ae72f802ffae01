"""The numbers of the section past the paper; its words are in templates/ours.html.j2."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias, TypeVar

from wmr_ctrl.campaign import FigureTable, RunRow
from wmr_ctrl.campaign.comparison import (
    AWAY,
    BASE,
    BASES,
    E1,
    FAR_START,
    OUTSIDE,
    PUSHED,
    SCENARIO,
    overrides_of,
)
from wmr_ctrl.campaign.table import REFUSED, median
from wmr_ctrl.control.setup import settle
from wmr_ctrl.guard.bounds import net
from wmr_ctrl.guard.price import speed_price, usable_speed
from wmr_ctrl.report.drawing import Drawing
from wmr_ctrl.report.style import look, shown
from wmr_ctrl.report.tables import TextTable, clip_shares, comparison_tables
from wmr_ctrl.results import Outcome
from wmr_ctrl.scenario import Scenario, load_scenario
from wmr_ctrl.world.phases import largest_friction

ALWAYS = 0.25
"""Share of samples in clip from which on it is the guard, not the law, that steers."""
SPINS = 100.0
"""A guarded run with this many times the base case's ISE does not follow its reference."""
NOTICED = 1.1
"""Growth of the distance from which on it is mentioned."""

T = TypeVar("T")
Numbers: TypeAlias = dict[str, object]
Cells: TypeAlias = list[tuple[str, float | None, float | None]]
"""A law's label, and a figure with and without the guard."""


@dataclass(frozen=True, slots=True)
class GuardSection:
    """All that the section's template shows; ``tables`` by base, no ``price`` without its rows.

    ``findings`` and ``shortfalls``: numbers by sentence; None or nothing where no row has them.
    """

    runs: int
    seeds: Sequence[int]
    findings: Numbers
    shortfalls: Numbers
    price: TextTable | None
    tables: Mapping[str, tuple[TextTable, ...]]
    drawings: Sequence[Drawing]


def guard_section(rows: FigureTable, drawings: Sequence[Drawing]) -> GuardSection:
    """Numbers of the sentences, tables and figures."""
    priced = tuple(
        (base, factor)
        for factor in (BASE, PUSHED)
        for base in rows.bases
        if factor in rows.scenarios(base)
    )
    return GuardSection(
        runs=len(rows),
        seeds=rows.seeds,
        findings=findings(rows),
        shortfalls=shortfalls(rows),
        price=price_table(rows, priced) if priced else None,
        tables={base: comparison_tables(rows, base) for base in rows.bases},
        drawings=drawings,
    )


def findings(rows: FigureTable) -> Numbers:
    """What the guard and the law do."""
    outside = _both(rows, lambda row: row.case.name == OUTSIDE)
    return {
        "inside": _both(rows, lambda row: row.case.name != OUTSIDE),
        "bounds_left": sum(row.outcome == Outcome.BOUNDS_LEFT for row in rows.guarded()),
        "outside": outside and {**outside, "start": start_ratio(OUTSIDE)},
        "after": _by_base(rows, lambda base: _cells(rows, base, BASE, AWAY)),
        "steers": _by_base(rows, lambda base: _steered(rows, base)),
    }


def shortfalls(rows: FigureTable) -> Numbers:
    """Where guard and law fall short."""
    return {
        "wind_up": _by_base(rows, lambda base: _wound_up(rows, base)),
        "spins": _by_base(rows, lambda base: _spinning(rows, base)),
        "refused": _refused(rows),
        "prox": _by_base(rows, lambda base: _broken_by_prox(rows, base)),
        "price": _by_base(rows, lambda base: _price(rows, base)),
    }


def _by_base(rows: FigureTable, of: Callable[[str], T]) -> list[tuple[str, T]]:
    """What there is of each base."""
    return [(base, numbers) for base in rows.bases if (numbers := of(base))]


def _both(rows: FigureTable, chosen: Callable[[RunRow], bool]) -> Numbers | None:
    """Runs, broken ones, largest |v|/limit and most steps outside, with and without the guard."""
    pair = {
        name: [row for row in rows.guarded(guard) if chosen(row)]
        for name, guard in (("held", True), ("free", False))
    }
    if not all(pair.values()):
        return None
    return {
        name: {
            "runs": len(runs),
            "broken": _broken(runs),
            "fastest": _fastest(runs),
            "steps": max(int(row["violations"] or 0) for row in runs),
        }
        for name, runs in pair.items()
    }


def _steered(rows: FigureTable, base: str) -> list[tuple[str, float]]:
    shares = (
        (
            look(law).label,
            median(map(_clipped, rows.of(BASE, law, base=base, guard=True))),
        )
        for law in rows.laws
    )
    return [(label, share) for label, share in shares if share and share > ALWAYS]


def _wound_up(rows: FigureTable, base: str) -> Numbers | None:
    ise = {law: rows.median("ise_total", base, FAR_START, law, True) for law in rows.laws}
    smc, others = ise.pop("smc", None), [value for value in ise.values() if value is not None]
    if smc is None or not others:
        return None
    share = rows.median("guard_share1", base, FAR_START, "smc", True)
    return {
        "ise": smc,
        "least": min(others),
        "most": max(others),
        "left": rows.median(E1, base, FAR_START, "smc", True),
        "share": share,
    }


def _spinning(rows: FigureTable, base: str) -> Numbers | None:
    lost: list[tuple[str, float]] = []
    steady: list[tuple[str, float]] = []
    for law in rows.laws:
        there, usual = (rows.median("ise_total", base, f, law, True) for f in (PUSHED, BASE))
        if there is not None and usual is not None:
            (lost if there > SPINS * usual else steady).append((look(law).label, there))
    return {"lost": lost, "steady": steady} if lost else None


def _refused(rows: FigureTable) -> Numbers | None:
    refused = [row for row in rows if row.outcome == REFUSED]
    if not refused:
        return None
    cases = tuple(dict.fromkeys(row.case.name for row in refused))
    alone = [r for r in rows.guarded(False) if r.case.name in cases]
    return {
        "cases": cases,
        "runs": len(refused),
        "words": refused[0].refusal,
        "alone": len(alone),
        "broken": _broken(alone),
    }


def _broken_by_prox(rows: FigureTable, base: str) -> list[Numbers]:
    cases = (
        (f, rows.of(f, "prox", base=base, guard=False))
        for f in rows.scenarios(base)
        if f != OUTSIDE
    )
    return [
        {"factor": f, "broken": _broken(runs), "runs": len(runs), "fastest": _fastest(runs)}
        for f, runs in cases
        if _broken(runs)
    ]


def _price(rows: FigureTable, base: str) -> dict[str, Cells]:
    far = _grown(_cells(rows, base, FAR_START, "ise_total"), 0.0)
    worse = _grown(_cells(rows, base, BASE, AWAY), NOTICED)
    return {"far": far, "worse": worse} if far or worse else {}


def _cells(rows: FigureTable, base: str, factor: str, figure: str) -> Cells:
    """A figure of each law that was run so."""
    return [
        (
            look(law).label,
            rows.median(figure, base, factor, law, True),
            rows.median(figure, base, factor, law, False),
        )
        for law in rows.laws
        if rows.of(factor, law, base=base, guard=True)
    ]


def _grown(cells: Cells, least: float) -> Cells:
    """Those in which the guard makes the figure at least so many times as large."""
    return [
        (label, held, free)
        for label, held, free in cells
        if held is not None and free is not None and held >= least * free
    ]


def _broken(runs: Iterable[RunRow]) -> int:
    return sum(1 for row in runs if row.broke)


def _clipped(row: RunRow) -> float | None:
    """The larger share of samples of both axes in which the guard acted."""
    shares = [share for axis in (1, 2) if (share := row[f"guard_share{axis}"]) is not None]
    return max(shares, default=None)


def _fastest(runs: Iterable[RunRow]) -> float | None:
    fastest = (row[f"limit_ratio{axis}"] for row in runs for axis in (1, 2))
    return max((ratio for ratio in fastest if ratio is not None), default=None)


def start_ratio(factor: str) -> float:
    """Largest |v|/limit at the start of a case."""
    scenario = load_scenario(SCENARIO, overrides_of(next(iter(BASES)), factor))
    pairs = zip(scenario.initial.velocity, scenario.limits.v_u1, strict=True)
    return max(abs(v) / limit for v, limit in pairs)


@dataclass(frozen=True, slots=True)
class GuardPrice:
    """What the guard leaves in a case: friction and dbar [N], M_min [kg], T [s].

    ``usable`` speed and turn rate beside those ``asked`` of it [m/s, rad/s]; ``standstill`` is the
    period from which on the usable speed is negative [s].
    """

    friction: float
    dbar: float
    mass: float
    period: float
    usable: tuple[float, float]
    asked: tuple[float, float]
    standstill: float


def price_of(base: str, factor: str) -> GuardPrice:
    """Usable speeds of a case against the largest friction of the paper's robot."""
    scenario = _scenario(base, factor)
    guard = settle(scenario, None).guard
    friction = largest_friction(load_scenario(SCENARIO))
    usable, asked = (
        usable_speed(scenario, guard, (friction, 0.0)),
        speed_price(scenario, guard).asked,
    )
    mass, dbar = (guard.M_min or (0.0, 0.0))[0], (guard.dbar or (0.0, 0.0))[0]
    room = scenario.limits.v_u1[0] - (guard.nbar or (0.0, 0.0))[0]
    standstill = mass * room / (friction + net(guard, 0))
    return GuardPrice(friction, dbar, mass, scenario.clock.control, usable, asked, standstill)


def price_table(rows: FigureTable, cases: tuple[tuple[str, str], ...]) -> TextTable:
    """The usable speeds under the bounds of each case, and how often the guard acted there."""
    body = tuple(
        (f"{factor}, {base}", *_priced(price_of(base, factor)), _changed(rows, base, factor))
        for base, factor in cases
    )
    head = ("bounds of", "M_min [kg]", "d̄ [N]", "friction f [N]", "v_use [m/s]",
            "reference v₁d [m/s]", "ω_use [rad/s]", "reference |ωd| [rad/s]",
            "T with v_use = 0 [ms]", "samples changed: thrust, moment [%]")  # fmt: skip
    return TextTable(
        "Largest steady speed and turn rate that the guard admits, beside the reference's own "
        "largest; and the share of samples in which it changed the force, median over laws and "
        "seeds",
        head, body,
    )  # fmt: skip


def _priced(price: GuardPrice) -> tuple[str, ...]:
    pairs = (pair[axis] for axis in (0, 1) for pair in (price.usable, price.asked))
    known = (price.mass, price.dbar, price.friction, *pairs, 1e3 * price.standstill)
    return tuple(map(shown, known))


def _changed(rows: FigureTable, base: str, factor: str) -> str:
    return clip_shares(
        [r for law in rows.laws for r in rows.of(factor, law, base=base, guard=True)]
    )


def _scenario(base: str, factor: str) -> Scenario:
    return load_scenario(SCENARIO, {**overrides_of(base, factor), "guard.enabled": True})
