"""Numbers of the section past the paper; its words are in templates/ours.html.j2."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias, TypeVar

import numpy as np

from wmr_ctrl.control.guard.bounds import mass_range, net, pair_of
from wmr_ctrl.control.guard.price import speed_price, usable_speed
from wmr_ctrl.control.setup import settle
from wmr_ctrl.results import FIGURES, Outcome
from wmr_ctrl.results.table import REFUSED, RunTable, median
from wmr_ctrl.simulation.campaign import comparison
from wmr_ctrl.world.phases import largest_friction
from wmr_ctrl.world.scenario import load_scenario

from .style import ABSENT, look, shown
from .tables import TextTable, table_by_law

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

    rows: RunTable

    def by_base(self, of: Callable[[str], T]) -> list[tuple[str, T]]:
        """The numbers of each base that has any."""
        return [(base, numbers) for base in self.rows.different("base") if (numbers := of(base))]

    def started(self, outside: bool) -> Numbers | None:
        """Runs, broken ones, largest |v|/limit and most steps outside, with and without the guard.

        ``outside``: of runs that start beyond the limits, or of all others.
        """
        chosen = self.rows.at((self.rows["case"] == comparison.OUTSIDE) == outside)
        pair = {"held": _made(chosen, True), "free": _made(chosen, False)}
        if not all(runs.rows for runs in pair.values()):
            return None
        return {
            name: {
                "runs": runs.rows,
                "broken": runs.broken.rows,
                "fastest": _fastest(runs),
                "steps": int(runs["violations"].max()),
            }
            for name, runs in pair.items()
        }

    @property
    def start_ratio(self) -> float:
        """Largest |v|/limit at the start outside the limits."""
        changes = comparison.overrides_of(next(iter(comparison.BASES)), comparison.OUTSIDE)
        scenario = load_scenario(comparison.SCENARIO, changes)
        pairs = zip(scenario.initial.velocity, scenario.limits.v_u1, strict=True)
        return max(abs(v) / limit for v, limit in pairs)

    @property
    def bounds_left(self) -> int:
        """Guarded runs whose motion contradicts the guard's bounds."""
        return int((_made(self.rows, True)["outcome"] == Outcome.BOUNDS_LEFT).sum())

    def after(self, base: str) -> Cells:
        """Distance after the change of parameters in the base case."""
        return self._cells(base, comparison.BASE, comparison.AWAY)

    def steered(self, base: str) -> list[tuple[str, float]]:
        """Laws behind which the guard acts always, and the share of samples in which it does."""
        runs = {look(law).label: self._runs(base, comparison.BASE, law) for law in self.rows.laws}
        shares = (
            (label, median(np.fmax(rows["guard_share1"], rows["guard_share2"]).tolist()))
            for label, rows in runs.items()
        )
        return [(label, share) for label, share in shares if share and share > ALWAYS]

    def wound_up(self, base: str) -> Numbers | None:
        """SMC from the far start, and the least and most ISE of the other laws."""

        def far(figure: str, law: str) -> float | None:
            return self._runs(base, comparison.FAR_START, law).median(figure)

        ise = {law: far("ise_total", law) for law in self.rows.laws}
        smc, others = ise.pop("smc", None), [value for value in ise.values() if value is not None]
        if smc is None or not others:
            return None
        own = {"ise": smc, "left": far(comparison.E1, "smc"), "share": far("guard_share1", "smc")}
        return {**own, "least": min(others), "most": max(others)}

    def spinning(self, base: str) -> Numbers | None:
        """Laws that the adversary makes spin, and those that stay on the path, with their ISE."""
        lost, steady = list[tuple[str, float]](), list[tuple[str, float]]()
        for law in self.rows.laws:
            both = (self._runs(base, case, law) for case in (comparison.PUSHED, comparison.BASE))
            there, usual = (runs.median("ise_total") for runs in both)
            if there is not None and usual is not None:
                (lost if there > SPINS * usual else steady).append((look(law).label, there))
        return {"lost": lost, "steady": steady} if lost else None

    @property
    def refused(self) -> Numbers | None:
        """Runs that the guard refused, and the same cases without it."""
        refused = self.rows.where(outcome=REFUSED)
        if not refused.rows:
            return None
        cases, free = refused.different("case"), _made(self.rows, False)
        alone = free.at(np.isin(free["case"], cases))
        return {
            "cases": cases,
            "runs": refused.rows,
            "words": refused["refusal"][0],
            "alone": alone.rows,
            "broken": alone.broken.rows,
        }

    def broken_by_prox(self, base: str) -> list[Numbers]:
        """Cases in which prox breaks a limit without the guard."""
        cases = [case for case in self._cases(base) if case != comparison.OUTSIDE]
        runs_of = {case: self._runs(base, case, "prox", guard=False) for case in cases}
        return [
            {"factor": f, "broken": runs.broken.rows, "runs": runs.rows, "fastest": _fastest(runs)}
            for f, runs in runs_of.items()
            if runs.broken.rows
        ]

    def price(self, base: str) -> dict[str, Cells]:
        """ISE from the far start, and distances of the base case that the guard makes larger."""
        far = _grown(self._cells(base, comparison.FAR_START, "ise_total"), 0.0)
        worse = _grown(self._cells(base, comparison.BASE, comparison.AWAY), NOTICED)
        return {"far": far, "worse": worse} if far or worse else {}

    def _cells(self, base: str, factor: str, figure: str) -> Cells:
        """A figure of each law that was run so."""
        cells = []
        for law in self.rows.laws:
            held, free = (self._runs(base, factor, law, guard=guard) for guard in (True, False))
            if held.rows:
                cells.append((look(law).label, held.median(figure), free.median(figure)))
        return cells

    def _runs(
        self, base: str, factor: str, law: str | None = None, *, guard: bool = True
    ) -> RunTable:
        return self.rows.where(base=base, case=factor, law=law, guard=guard)

    def _cases(self, base: str) -> tuple[str, ...]:
        return self.rows.where(base=base).different("case")

    # -- tables -------------------------------------------------------------------------------

    def broken_table(self, base: str) -> TextTable:
        """Runs that broke a limit, and the median of plant steps beyond it, without | with it."""
        return self._table(base, partial(self._pair, base, _broken_cell))

    def median_table(self, base: str, figure: str) -> TextTable:
        """Median of a figure, lengths in mm, without | with the guard.

        A figure of the time before the change is shown only for cases with that change.
        """
        factor = 1e3 if FIGURES[figure].unit == "m" else 1.0

        def value(case: str, law: str) -> float | None:
            return self._runs(base, case, law).median(figure)

        def cell(runs: RunTable) -> str:
            middle = runs.median(figure)
            return _refused(runs) or shown(None if middle is None else factor * middle)

        before = figure == comparison.E1_BEFORE
        cases = {
            case: case
            for case in self._cases(base)
            if not (before and "changes" in comparison.overrides_of(base, case))
        }
        return table_by_law(cases, self.rows.laws, partial(self._pair, base, cell), value)

    def clip_table(self, base: str) -> TextTable:
        """Median share of samples in which the guard changed thrust and moment [%]."""
        return self._table(base, lambda case, law: _clip(self._runs(base, case, law)))

    def _table(self, base: str, cell: Callable[[str, str], str]) -> TextTable:
        cases = {case: case for case in self._cases(base)}
        return table_by_law(cases, self.rows.laws, cell)

    def _pair(self, base: str, cell: Callable[[RunTable], str], case: str, law: str) -> str:
        both = (self._runs(base, case, law, guard=guard) for guard in (False, True))
        return " | ".join(map(cell, both))

    @property
    def usable_speeds(self) -> list[tuple[str, str, tuple[float, ...], str]]:
        """Two cases of each base that was run: `_usable`, and the samples changed [%]."""
        return [
            (factor, base, _usable(base, factor), _clip(self._runs(base, factor)))
            for factor in (comparison.BASE, comparison.PUSHED)
            for base in self.rows.different("base")
            if factor in self._cases(base)
        ]


def _grown(cells: Cells, least: float) -> Cells:
    """Those in which the guard makes the figure at least so many times as large."""
    return [
        (label, held, free)
        for label, held, free in cells
        if held is not None and free is not None and held >= least * free
    ]


def _made(rows: RunTable, guard: bool) -> RunTable:
    """Runs with the guard, or without it, that were not refused."""
    return rows.at((rows["guard"] == guard) & (rows["outcome"] != REFUSED))


def _fastest(runs: RunTable) -> float | None:
    fastest = np.fmax(runs["limit_ratio1"], runs["limit_ratio2"])
    return None if np.isnan(fastest).all() else float(np.nanmax(fastest))


def _broken_cell(runs: RunTable) -> str:
    if not runs.rows or _refused(runs):
        return _refused(runs) or ABSENT
    if not runs.broken.rows:
        return f"0/{runs.rows}"
    ended = np.isin(runs["outcome"], (Outcome.DIVERGED, Outcome.NON_FINITE)).any()
    steps = runs.broken.median("violations") or 0.0
    return f"{runs.broken.rows}/{runs.rows}: {'diverged' if ended else f'{steps:.0f}'}"


def _clip(runs: RunTable) -> str:
    """Median share of samples in which the guard changed thrust and moment [%]."""
    first, second = (runs.median(f"guard_share{axis}") for axis in (1, 2))
    if first is None or second is None:
        return _refused(runs) or ABSENT
    return f"{shown(100 * first, 2)}, {shown(100 * second, 2)}"


def _refused(runs: RunTable) -> str:
    return REFUSED if runs.rows and (runs["outcome"] == REFUSED).all() else ""


def _usable(base: str, factor: str) -> tuple[float, ...]:
    """Bounds of a case, and the speeds that they leave.

    M_min [kg], dbar and the largest friction of the paper's robot [N]; by axis the usable speed and
    that asked of it [m/s, rad/s]; the period from which on the usable speed is negative [ms].
    """
    changes = {**comparison.overrides_of(base, factor), "guard.enabled": True}
    scenario = load_scenario(comparison.SCENARIO, changes)
    guard = settle(scenario, None).guard
    friction = largest_friction(load_scenario(comparison.SCENARIO))
    usable = usable_speed(scenario, guard, (friction, 0.0))
    asked = speed_price(scenario, guard).asked
    mass, dbar = mass_range(guard, 0)[0], pair_of(guard.dbar)[0]
    room = scenario.limits.v_u1[0] - pair_of(guard.nbar)[0]
    standstill = 1e3 * mass * room / (friction + net(guard, 0))
    return mass, dbar, friction, usable[0], asked[0], usable[1], asked[1], standstill
