"""Figures of the comparison: violations, e1 after the switch, and ISE against T and tau_max."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TypeAlias

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, NullFormatter, NullLocator

from wmr_ctrl.campaign import FigureTable
from wmr_ctrl.campaign.comparison import AWAY, BASE, BASES, swept
from wmr_ctrl.campaign.table import REFUSED
from wmr_ctrl.report.drawing import (
    Drawing,
    Padding,
    dots,
    heading,
    law_handles,
    law_marks,
    legend_row,
    plain_ticks,
    row_of_axes,
    rows_of,
    seed_handle,
)
from wmr_ctrl.report.style import LIMIT, MUTED, look
from wmr_ctrl.results.windows import LATE


def comparison_figures(rows: FigureTable) -> tuple[Drawing, ...]:
    """Every figure of the comparison, in the section's order."""
    return (_violations(rows), _position_after(rows), period_drawing(rows), torque_drawing(rows))


def title_of(base: str) -> str:
    """How a base case is called above its axes."""
    return f"torque held for {base}"


def _violations(rows: FigureTable) -> Drawing:
    count = len(rows.scenarios()) * len(rows.laws)
    return Drawing(
        "ours_violations",
        "Plant steps beyond a limit, without and with the guard",
        "One mark per run. Filled: without the guard; hollow: with it. Guarded runs leave the "
        "limits only where they start outside. Runs that diverge end early and so count few "
        "steps; cases that the guard refuses have no hollow marks.",
        (9.6, 1.1 + 0.07 * count),
        partial(_draw_violations, rows=rows),
    )


def _draw_violations(figure: Figure, rows: FigureTable) -> None:
    padding, factors = Padding(left=2.75, right=0.15, bottom=0.44, top=0.74), rows.scenarios()
    panels = row_of_axes(figure, padding, [1.0] * len(rows.bases), 0.2)
    for place, (axes, base) in enumerate(zip(panels, rows.bases, strict=True)):
        rows_of(axes, factors if place == 0 else [""] * len(factors))
        _fill(axes, rows, base)
        axes.set_title(title_of(base), weight="normal", size=8)
        axes.set(xscale="symlog", xlabel="plant steps beyond a limit", xlim=(-0.6, 2e5))
        axes.set_xticks(
            [0, 1, 10, 100, 1000, 1e4, 1e5], ["0", "1", "10", "100", "10³", "10⁴", "10⁵"]
        )
        axes.axvspan(0.5, 2e5, color=LIMIT, alpha=0.07, lw=0)
    heading(figure, "Plant steps beyond a velocity limit")
    legend_row(figure, [*law_marks(rows.laws), *_kinds()])


def _fill(axes: Axes, rows: FigureTable, base: str) -> None:
    step = 0.84 / len(rows.laws)
    for row, factor in enumerate(rows.scenarios()):
        if factor not in rows.scenarios(base):
            axes.annotate("first base only", (0, row), xytext=(12, 0), textcoords="offset points",
                          va="center", size=6.5, color=MUTED)  # fmt: skip
        for place, law in enumerate(rows.laws):
            height = row - 0.42 + step * (place + 0.5)
            for guard in (False, True):
                runs = rows.of(factor, law, base=base, guard=guard)
                steps = [r["violations"] for r in runs if r.outcome != REFUSED]
                dots(axes, steps, height, law, step, filled=not guard)


def _position_after(rows: FigureTable) -> Drawing:
    return Drawing(
        "ours_position",
        f"Distance from the reference after the change of parameters, RMS over "
        f"{LATE[0]:g}–{LATE[1]:g} s",
        "The base cases; each mark is a seed, each bar a median.",
        (9.6, 0.95 + 0.36 * len(rows.laws)),
        partial(_draw_position, rows=rows),
    )


def _draw_position(figure: Figure, rows: FigureTable) -> None:
    padding = Padding(left=0.78, right=0.15, bottom=0.42, top=0.74)
    panels = row_of_axes(figure, padding, [1.0] * len(rows.bases), 0.55)
    for axes, base in zip(panels, rows.bases, strict=True):
        rows_of(axes, [look(law).label for law in rows.laws])
        for place, law in enumerate(rows.laws):
            for guard in (False, True):
                errors = (row[AWAY] for row in rows.of(BASE, law, base=base, guard=guard))
                millimetres = [None if error is None else 1e3 * error for error in errors]
                dots(axes, millimetres, place + (0.2 if guard else -0.2), law, filled=not guard)
        axes.set(xscale="log", xlabel="RMS distance [mm]", xlim=(0.1, 5000.0))
        plain_ticks(axes, (1,))
        axes.set_title(title_of(base), weight="normal", size=8)
    heading(figure, f"Distance after the change of parameters, {LATE[0]:g}–{LATE[1]:g} s")
    legend_row(figure, _kinds())


def _kinds() -> list[Line2D]:
    return [seed_handle("without the guard", filled=True), seed_handle("with it", filled=False)]


Points: TypeAlias = Sequence[tuple[float, str, str]]
"""Where a case stands on the axis, its base, its factor."""

UNLIMITED = 40.0
"""Where "no limit" stands on the axis of torque limits [N m]."""

_CROSS = (
    "Median over the seeds; red crosses: some run of the case broke a limit. What diverged has no "
    "point. Mind the scales."
)


def period_drawing(rows: FigureTable) -> Drawing:
    """ISE against the control period, without and with the guard."""
    return Drawing(
        "ours_ise_period",
        "ISE against the control period",
        f"The paper’s gains at every period. {_CROSS}",
        (9.6, 2.7),
        partial(_draw_period, rows=rows),
    )


def torque_drawing(rows: FigureTable) -> Drawing:
    """ISE against the torque limit, without and with the guard, per base."""
    return Drawing(
        "ours_ise_torque",
        "ISE against the torque limit",
        f"“none”: wheels without a limit. {_CROSS}",
        (9.6, 2.7),
        partial(_draw_torque, rows=rows),
    )


def periods() -> Points:
    """The control periods of the plan [ms]."""
    first = next(iter(BASES))
    own = [(1e3 * period, first, factor) for period, factor in swept("clock.control")]
    return sorted([*own, *((1e3 * period, base, BASE) for base, period in BASES.items())])


def limits(base: str) -> Points:
    """The torque limits of the plan [N m]; :data:`UNLIMITED` is none."""
    own = [(limit, base, factor) for limit, factor in swept("actuator.tau_max")]
    return sorted([*own, (UNLIMITED, base, BASE)])


def _draw_period(figure: Figure, rows: FigureTable) -> None:
    padding = Padding(left=0.60, right=0.15, bottom=0.42, top=0.74)
    panels = row_of_axes(figure, padding, (1.0, 1.0), 0.45)
    for axes, guard in zip(panels, (False, True), strict=True):
        _lines(axes, rows, periods(), guard)
        axes.set_title("with the guard" if guard else "without the guard", weight="normal", size=8)
        _ticks(axes, [point[0] for point in periods()], "control period T [ms]")
    _finish(figure, panels, rows, "ISE against the control period")


def _draw_torque(figure: Figure, rows: FigureTable) -> None:
    padding = Padding(left=0.60, right=0.15, bottom=0.42, top=0.74)
    places = [(base, guard) for base in rows.bases for guard in (False, True)]
    panels = row_of_axes(figure, padding, [1.0] * len(places), 0.42)
    for axes, (base, guard) in zip(panels, places, strict=True):
        _lines(axes, rows, limits(base), guard)
        axes.set_title(
            f"{base}, {'with' if guard else 'without'} the guard", weight="normal", size=8
        )
        _ticks(axes, [point[0] for point in limits(base)], "torque limit [N m]")
        _mark_refused(axes, rows, limits(base), guard)
    _finish(figure, panels, rows, "ISE against the torque limit, without and with the guard")


def _lines(axes: Axes, rows: FigureTable, points: Points, guard: bool) -> None:
    for law in rows.laws:
        seen = look(law)
        places = [(x, rows.median("ise_total", b, f, law, guard)) for x, b, f in points]
        there = [(x, y) for x, y in places if y is not None]
        if not there:
            continue
        axes.plot(*zip(*there, strict=True), color=seen.colour, ls=seen.dash, marker=seen.marker,
                  ms=3.6, mfc="white" if guard else seen.colour, zorder=3)  # fmt: skip
        bad = [(x, y) for (x, y), (_, b, f) in zip(places, points, strict=True)
               if y is not None
               and any(r.broke for r in rows.of(f, law, base=b, guard=guard))]  # fmt: skip
        if bad:
            axes.plot(*zip(*bad, strict=True), ls="", marker="x", color=LIMIT, ms=6, mew=1.2,
                      zorder=4)  # fmt: skip


def _ticks(axes: Axes, places: Sequence[float], label: str) -> None:
    names = ["none" if p == UNLIMITED else f"{p:g}" for p in places]
    axes.set(xscale="log", yscale="log", xlabel=label)
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_major_locator(FixedLocator(list(places)))
    axes.set_xticks(list(places), names)
    axes.set_xlim(0.85 * places[0], 1.18 * places[-1])


def _mark_refused(axes: Axes, rows: FigureTable, points: Points, guard: bool) -> None:
    """Say where the guard refuses every law."""
    for x, base, factor in points:
        runs = [row for law in rows.laws for row in rows.of(factor, law, base=base, guard=guard)]
        if runs and all(row.outcome == REFUSED for row in runs):
            axes.text(x, 0.5, "refused", rotation=90, ha="center", va="center", size=7,
                      color=MUTED, transform=axes.get_xaxis_transform())  # fmt: skip


def _finish(figure: Figure, panels: Sequence[Axes], rows: FigureTable, text: str) -> None:
    panels[0].set_ylabel("ISE [m² s + rad² s]")
    for axes in panels:
        low, high = axes.get_ylim()
        axes.set_ylim(min(low, 0.3), max(high, 30.0))
    heading(figure, text)
    legend_row(figure, law_handles(rows.laws))
