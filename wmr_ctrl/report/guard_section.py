"""Numbers of the section past the paper; its words are in templates/ours.html.j2."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias, TypeVar

from wmr_ctrl.campaign import FigureTable, RunRow
from wmr_ctrl.campaign.comparison import (
    AWAY,
    BASE,
    BASES,
    E1,
    E1_BEFORE,
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
from wmr_ctrl.report.style import ABSENT, look, shown
from wmr_ctrl.report.tables import TextTable, table_by_law
from wmr_ctrl.results import Outcome
from wmr_ctrl.results.figures import FIGURES
from wmr_ctrl.scenario import load_scenario
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


@dataclass(frozen=True)
class GuardSection:
    """The comparison's rows, and by sentence its numbers: None or empty where no row has them."""

    rows: FigureTable

    def by_base(self, of: Callable[[str], T]) -> list[tuple[str, T]]:
        """The numbers of each base that has any."""
        return [(base, numbers) for base in self.rows.bases if (numbers := of(base))]

    def started(self, outside: bool) -> Numbers | None:
        """Runs, broken ones, largest |v|/limit and most steps outside, with and without the guard.

        ``outside``: of runs that start beyond the limits, or of all others.
        """
        pair = {
            name: [r for r in self.rows.guarded(guard) if (r.case.name == OUTSIDE) is outside]
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

    @property
    def start_ratio(self) -> float:
        """Largest |v|/limit at the start outside the limits."""
        scenario = load_scenario(SCENARIO, overrides_of(next(iter(BASES)), OUTSIDE))
        pairs = zip(scenario.initial.velocity, scenario.limits.v_u1, strict=True)
        return max(abs(v) / limit for v, limit in pairs)

    @property
    def bounds_left(self) -> int:
        """Guarded runs whose motion contradicts the guard's bounds."""
        return sum(row.outcome == Outcome.BOUNDS_LEFT for row in self.rows.guarded())

    def after(self, base: str) -> Cells:
        """Distance after the change of parameters in the base case."""
        return self._cells(base, BASE, AWAY)

    def steered(self, base: str) -> list[tuple[str, float]]:
        """Laws behind which the guard acts always, and the share of samples in which it does."""
        shares = (
            (look(law).label, median(map(_clipped, self._guarded(base, BASE, law))))
            for law in self.rows.laws
        )
        return [(label, share) for label, share in shares if share and share > ALWAYS]

    def wound_up(self, base: str) -> Numbers | None:
        """SMC from the far start, and the least and most ISE of the other laws."""

        def far(figure: str, law: str) -> float | None:
            return self.rows.median(figure, base, FAR_START, law, True)

        ise = {law: far("ise_total", law) for law in self.rows.laws}
        smc, others = ise.pop("smc", None), [value for value in ise.values() if value is not None]
        if smc is None or not others:
            return None
        own = {"ise": smc, "left": far(E1, "smc"), "share": far("guard_share1", "smc")}
        return {**own, "least": min(others), "most": max(others)}

    def spinning(self, base: str) -> Numbers | None:
        """Laws that the adversary makes spin, and those that stay on the path, with their ISE."""
        lost, steady = list[tuple[str, float]](), list[tuple[str, float]]()
        for law in self.rows.laws:
            there, usual = (
                self.rows.median("ise_total", base, factor, law, True) for factor in (PUSHED, BASE)
            )
            if there is not None and usual is not None:
                (lost if there > SPINS * usual else steady).append((look(law).label, there))
        return {"lost": lost, "steady": steady} if lost else None

    @property
    def refused(self) -> Numbers | None:
        """Runs that the guard refused, and the same cases without it."""
        refused = [row for row in self.rows if row.outcome == REFUSED]
        if not refused:
            return None
        cases = tuple(dict.fromkeys(row.case.name for row in refused))
        alone = [row for row in self.rows.guarded(False) if row.case.name in cases]
        return {
            "cases": cases,
            "runs": len(refused),
            "words": refused[0].refusal,
            "alone": len(alone),
            "broken": _broken(alone),
        }

    def broken_by_prox(self, base: str) -> list[Numbers]:
        """Cases in which prox breaks a limit without the guard."""
        cases = {
            factor: self.rows.of(factor, "prox", base=base, guard=False)
            for factor in self.rows.scenarios(base)
            if factor != OUTSIDE
        }
        return [
            {"factor": f, "broken": _broken(runs), "runs": len(runs), "fastest": _fastest(runs)}
            for f, runs in cases.items()
            if _broken(runs)
        ]

    def price(self, base: str) -> dict[str, Cells]:
        """ISE from the far start, and distances of the base case that the guard makes larger."""
        far = _grown(self._cells(base, FAR_START, "ise_total"), 0.0)
        worse = _grown(self._cells(base, BASE, AWAY), NOTICED)
        return {"far": far, "worse": worse} if far or worse else {}

    def _cells(self, base: str, factor: str, figure: str) -> Cells:
        """A figure of each law that was run so."""
        median_of = self.rows.median
        return [
            (
                look(law).label,
                median_of(figure, base, factor, law, True),
                median_of(figure, base, factor, law, False),
            )
            for law in self.rows.laws
            if self._guarded(base, factor, law)
        ]

    def _guarded(self, base: str, factor: str, law: str) -> tuple[RunRow, ...]:
        return self.rows.of(factor, law, base=base, guard=True)

    # -- tables -------------------------------------------------------------------------------

    def broken_table(self, base: str) -> TextTable:
        """Runs that broke a limit, and the median of plant steps beyond it, without | with it."""
        return self._table(base, partial(self._pair, base, _broken_cell))

    def median_table(self, base: str, figure: str) -> TextTable:
        """Median of a figure, lengths in mm, without | with the guard.

        A figure of the time before the change is told only of cases with that change.
        """
        factor = 1e3 if FIGURES[figure].unit == "m" else 1.0

        def value(case: str, law: str) -> float | None:
            return self.rows.median(figure, base, case, law, True)

        def cell(runs: Sequence[RunRow]) -> str:
            middle = median(row[figure] for row in runs)
            return _refused(runs) or shown(None if middle is None else factor * middle)

        cases = [
            case
            for case in self.rows.scenarios(base)
            if figure != E1_BEFORE or "changes" not in overrides_of(base, case)
        ]
        pair = partial(self._pair, base, cell)
        return table_by_law({case: case for case in cases}, self.rows.laws, pair, value)

    def clip_table(self, base: str) -> TextTable:
        """Median share of samples in which the guard changed thrust and moment [%]."""
        return self._table(base, lambda case, law: _clip(self._guarded(base, case, law)))

    def _table(self, base: str, cell: Callable[[str, str], str]) -> TextTable:
        cases = {case: case for case in self.rows.scenarios(base)}
        return table_by_law(cases, self.rows.laws, cell)

    def _pair(self, base: str, cell: Callable[[Sequence[RunRow]], str], case: str, law: str) -> str:
        both = (self.rows.of(case, law, base=base, guard=guard) for guard in (False, True))
        return " | ".join(map(cell, both))

    @property
    def price_table(self) -> TextTable | None:
        """Usable speeds under the bounds of two cases of each base; None where none was run."""
        head = ("bounds of", "M_min [kg]", "d̄ [N]", "friction f [N]", "v_use [m/s]",
                "reference v₁d [m/s]", "ω_use [rad/s]", "reference |ωd| [rad/s]",
                "T with v_use = 0 [ms]", "samples changed: thrust, moment [%]")  # fmt: skip
        body = tuple(
            (
                f"{factor}, {base}",
                *map(shown, _prices(base, factor)),
                _clip([r for law in self.rows.laws for r in self._guarded(base, factor, law)]),
            )
            for factor in (BASE, PUSHED)
            for base in self.rows.bases
            if factor in self.rows.scenarios(base)
        )
        return TextTable(head, body) if body else None


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


def _broken_cell(runs: Sequence[RunRow]) -> str:
    if not runs or _refused(runs):
        return _refused(runs) or ABSENT
    broken = [row for row in runs if row.broke]
    if not broken:
        return f"0/{len(runs)}"
    ended = any(row.outcome in (Outcome.DIVERGED, Outcome.NON_FINITE) for row in runs)
    steps = median(row["violations"] for row in broken) or 0.0
    return f"{len(broken)}/{len(runs)}: {'diverged' if ended else f'{steps:.0f}'}"


def _clip(runs: Sequence[RunRow]) -> str:
    """Median share of samples in which the guard changed thrust and moment [%]."""
    first, second = (median(row[f"guard_share{axis}"] for row in runs) for axis in (1, 2))
    if first is None or second is None:
        return _refused(runs) or ABSENT
    return f"{shown(100 * first, 2)}, {shown(100 * second, 2)}"


def _refused(runs: Sequence[RunRow]) -> str:
    return REFUSED if runs and all(row.outcome == REFUSED for row in runs) else ""


def _prices(base: str, factor: str) -> tuple[float, ...]:
    """Bounds of a case, and the speeds that they leave.

    M_min [kg], dbar and the largest friction of the paper's robot [N]; by axis the usable speed and
    that asked of it [m/s, rad/s]; the period from which on the usable speed is negative [ms].
    """
    scenario = load_scenario(SCENARIO, {**overrides_of(base, factor), "guard.enabled": True})
    guard = settle(scenario, None).guard
    friction = largest_friction(load_scenario(SCENARIO))
    usable, asked = (
        usable_speed(scenario, guard, (friction, 0.0)),
        speed_price(scenario, guard).asked,
    )
    mass, dbar = (guard.M_min or (0.0, 0.0))[0], (guard.dbar or (0.0, 0.0))[0]
    room = scenario.limits.v_u1[0] - (guard.nbar or (0.0, 0.0))[0]
    standstill = 1e3 * mass * room / (friction + net(guard, 0))
    return mass, dbar, friction, usable[0], asked[0], usable[1], asked[1], standstill
