"""Figures of the comparison: violations, distance after the change, ISE against T and tau_max."""

from collections.abc import Mapping, Sequence
from functools import partial
from itertools import product
from typing import TypeAlias

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, NullFormatter, NullLocator

from wmr_ctrl.report import drawing
from wmr_ctrl.report.style import LIMIT, MUTED, look
from wmr_ctrl.results import REFUSED, RunTable
from wmr_ctrl.results.windows import LATE, seconds

from . import marks
from .guard_runs import AWAY, BASE, BASES, swept


def comparison_figures(rows: RunTable) -> tuple[drawing.Drawing, ...]:
    """Every figure of the comparison, in the section's order."""
    high = 1.1 + 0.07 * len(rows.different("case")) * len(rows.laws)
    by_law = 0.95 + 0.36 * len(rows.laws)
    return (
        drawing.Drawing("ours_violations", (9.6, high), partial(_draw_violations, rows=rows)),
        drawing.Drawing("ours_position", (9.6, by_law), partial(_draw_position, rows=rows)),
        drawing.Drawing("ours_ise_period", (9.6, 2.7), partial(_draw_period, rows=rows)),
        drawing.Drawing("ours_ise_torque", (9.6, 2.7), partial(_draw_torque, rows=rows)),
    )


def _kinds() -> list[Line2D]:
    return [marks.dot_handle("without the guard"), marks.dot_handle("with it", face="white")]


def _name(axes: Axes, title: str) -> None:
    axes.set_title(title, weight="normal", size=8)


def _draw_violations(figure: Figure, rows: RunTable) -> None:
    padding = drawing.Padding(left=2.75, right=0.15, bottom=0.44, top=0.74)
    factors, bases = rows.different("case"), rows.different("base")
    step = 0.84 / len(rows.laws)
    panels = drawing.row_of_axes(figure, padding, [1.0] * len(bases), 0.2)
    for place, (axes, base) in enumerate(zip(panels, bases, strict=True)):
        marks.rows_of(axes, factors if place == 0 else [""] * len(factors))
        for row, factor in enumerate(factors):
            if factor not in rows.where(base=base).different("case"):
                axes.annotate("first base only", (0, row), xytext=(12, 0), va="center", size=6.5,
                              textcoords="offset points", color=MUTED)  # fmt: skip
            for law, guard in product(rows.laws, (False, True)):
                height = row - 0.42 + step * (rows.laws.index(law) + 0.5)
                runs = rows.where(case=factor, law=law, base=base, guard=guard)
                marks.dots(axes, runs["violations"], height, law, step, filled=not guard)
        _name(axes, f"torque held for {base}")
        axes.set(xscale="symlog", xlabel="plant steps beyond a limit", xlim=(-0.6, 2e5))
        ticks = {0: "0", 1: "1", 10: "10", 100: "100", 1e3: "10³", 1e4: "10⁴", 1e5: "10⁵"}
        axes.set_xticks([*ticks], [*ticks.values()])
        axes.axvspan(0.5, 2e5, color=LIMIT, alpha=0.07, lw=0)
    handles = [*marks.law_marks(rows.laws), *_kinds()]
    drawing.heading(figure, "Plant steps beyond a velocity limit", handles)


def _draw_position(figure: Figure, rows: RunTable) -> None:
    padding = drawing.Padding(left=0.78, right=0.15, bottom=0.42, top=0.74)
    bases = rows.different("base")
    panels = drawing.row_of_axes(figure, padding, [1.0] * len(bases), 0.55)
    for axes, base in zip(panels, bases, strict=True):
        marks.law_rows(axes, rows.laws)
        for place, law in enumerate(rows.laws):
            for guard, height in ((False, place - 0.2), (True, place + 0.2)):
                runs = rows.where(case=BASE, law=law, base=base, guard=guard)
                marks.dots(axes, 1e3 * runs[AWAY], height, law, filled=not guard)
        axes.set(xscale="log", xlabel="RMS distance [mm]", xlim=(0.1, 5000.0))
        drawing.plain_ticks(axes, (1,))
        _name(axes, f"torque held for {base}")
    drawing.heading(figure, f"Distance after the change of parameters, {seconds(*LATE)}", _kinds())


# -- ISE against a number of the scenario -----------------------------------------------------

Points: TypeAlias = Sequence[tuple[float, str, str]]
"""Position of a case on the axis, its base, its factor."""
Places: TypeAlias = Mapping[str, tuple[Points, bool]]
_GUARDS = {"without the guard": False, "with the guard": True}
UNLIMITED = 40.0
"""Position of "no limit" on the axis of torque limits [N m]."""


def periods() -> Points:
    """The control periods of the plan [ms]."""
    first = next(iter(BASES))
    own = [(1e3 * period, first, factor) for period, factor in swept("clock.control")]
    return sorted([*own, *((1e3 * period, base, BASE) for base, period in BASES.items())])


def limits(base: str) -> Points:
    """The torque limits of the plan [N m]; :data:`UNLIMITED` is none."""
    own = [(limit, base, factor) for limit, factor in swept("actuator.tau_max")]
    return sorted([*own, (UNLIMITED, base, BASE)])


def _draw_period(figure: Figure, rows: RunTable) -> None:
    places = {name: (periods(), guard) for name, guard in _GUARDS.items()}
    _draw_lines(figure, rows, places, 0.45, "control period T [ms]")
    drawing.heading(figure, "ISE against the control period", marks.law_handles(rows.laws))


def _draw_torque(figure: Figure, rows: RunTable) -> None:
    places = {
        f"{base}, {name}": (limits(base), guard)
        for base in rows.different("base")
        for name, guard in _GUARDS.items()
    }
    _draw_lines(figure, rows, places, 0.42, "torque limit [N m]")
    title = "ISE against the torque limit, without and with the guard"
    drawing.heading(figure, title, marks.law_handles(rows.laws))


def _draw_lines(figure: Figure, rows: RunTable, places: Places, gap: float, label: str) -> None:
    """Axes by their title: points of the axis, and whether the guard is on."""
    padding = drawing.Padding(left=0.60, right=0.15, bottom=0.42, top=0.74)
    panels = drawing.row_of_axes(figure, padding, [1.0] * len(places), gap)
    for axes, (name, (points, guard)) in zip(panels, places.items(), strict=True):
        for law in rows.laws:
            _line(axes, rows, points, law, guard)
        _name(axes, name)
        _ticks(axes, [x for x, _, _ in points], label)
        for x, base, factor in points:  # where the guard refuses every law
            runs = rows.where(case=factor, base=base, guard=guard)
            if runs.rows and (runs["outcome"] == REFUSED).all():
                axes.text(x, 0.5, "refused", rotation=90, ha="center", va="center", size=7,
                          color=MUTED, transform=axes.get_xaxis_transform())  # fmt: skip
        low, high = axes.get_ylim()
        axes.set_ylim(min(low, 0.3), max(high, 30.0))
    panels[0].set_ylabel("ISE [m² s + rad² s]")


def _line(axes: Axes, rows: RunTable, points: Points, law: str, guard: bool) -> None:
    """A law's medians; a cross where some run broke a limit."""
    seen, there, bad = look(law), [], []
    for x, base, factor in points:
        runs = rows.where(case=factor, law=law, base=base, guard=guard)
        y = runs.median("ise_total")
        if y is not None:
            there.append((x, y))
            if runs.broken.rows:
                bad.append((x, y))
    if there:
        axes.plot(*zip(*there, strict=True), color=seen.colour, ls=seen.dash, marker=seen.marker,
                  ms=3.6, mfc="white" if guard else seen.colour, zorder=3)  # fmt: skip
    if bad:
        axes.plot(*zip(*bad, strict=True), ls="", marker="x", color=LIMIT, ms=6, mew=1.2, zorder=4)


def _ticks(axes: Axes, places: Sequence[float], label: str) -> None:
    names = ["none" if p == UNLIMITED else f"{p:g}" for p in places]
    axes.set(xscale="log", yscale="log", xlabel=label)
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_major_locator(FixedLocator(list(places)))
    axes.set_xticks(list(places), names)
    axes.set_xlim(0.85 * places[0], 1.18 * places[-1])
