"""ISE against the control period and against the torque limit, a line per law."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TypeAlias

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullFormatter, NullLocator

from wmr_ctrl.campaign.ours import BASES, FACTORS
from wmr_ctrl.campaign.ours_run import REFUSED
from wmr_ctrl.report.canvas import Margins, heading, law_handles, legend_row, row_of_axes
from wmr_ctrl.report.drawing import Drawing
from wmr_ctrl.report.ours.rows import BASE, Rows, broke
from wmr_ctrl.report.style import LIMIT, MUTED, look

Points: TypeAlias = Sequence[tuple[float, str, str]]
"""Where a case stands on the axis, its base, its factor."""

UNLIMITED = 40.0
"""Where "no limit" stands on the axis of torque limits [N m]."""

_CROSS = (
    "Median over the seeds; red crosses: some run of the case broke a limit. What diverged has no "
    "point. Mind the scales."
)


def period_drawing(rows: Rows) -> Drawing:
    """ISE against the control period, without and with the guard."""
    return Drawing(
        "ours_ise_period",
        "ISE against the control period",
        f"The paper’s gains at every period. {_CROSS}",
        (9.6, 2.7),
        partial(_draw_period, rows=rows),
    )


def torque_drawing(rows: Rows) -> Drawing:
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
    own = [(1e3 * c["clock.control"], first, f) for f, c in FACTORS.items() if "clock.control" in c]
    return sorted([*own, *((1e3 * period, base, BASE) for base, period in BASES.items())])


def limits(base: str) -> Points:
    """The torque limits of the plan [N m]; :data:`UNLIMITED` is none."""
    own = [(c["actuator.tau_max"], base, f) for f, c in FACTORS.items() if "actuator.tau_max" in c]
    return sorted([*own, (UNLIMITED, base, BASE)])


def _draw_period(figure: Figure, rows: Rows) -> None:
    margins = Margins(left=0.60, right=0.15, bottom=0.42, top=0.74)
    panels = row_of_axes(figure, margins, (1.0, 1.0), 0.45)
    for axes, guard in zip(panels, (False, True), strict=True):
        _lines(axes, rows, periods(), guard)
        axes.set_title("with the guard" if guard else "without the guard", weight="normal", size=8)
        _ticks(axes, [point[0] for point in periods()], "control period T [ms]")
    _finish(figure, panels, rows, "ISE against the control period")


def _draw_torque(figure: Figure, rows: Rows) -> None:
    margins = Margins(left=0.60, right=0.15, bottom=0.42, top=0.74)
    shown = [(base, guard) for base in rows.bases for guard in (False, True)]
    panels = row_of_axes(figure, margins, [1.0] * len(shown), 0.42)
    for axes, (base, guard) in zip(panels, shown, strict=True):
        _lines(axes, rows, limits(base), guard)
        axes.set_title(
            f"{base}, {'with' if guard else 'without'} the guard", weight="normal", size=8
        )
        _ticks(axes, [point[0] for point in limits(base)], "torque limit [N m]")
        _mark_refused(axes, rows, limits(base), guard)
    _finish(figure, panels, rows, "ISE against the torque limit, without and with the guard")


def _lines(axes: Axes, rows: Rows, points: Points, guard: bool) -> None:
    for law in rows.laws:
        seen = look(law)
        places = [(x, rows.median("ise", b, f, law, guard)) for x, b, f in points]
        there = [(x, y) for x, y in places if y is not None]
        if not there:
            continue
        axes.plot(*zip(*there, strict=True), color=seen.colour, ls=seen.dash, marker=seen.marker,
                  ms=3.6, mfc="white" if guard else seen.colour, zorder=3)  # fmt: skip
        bad = [(x, y) for (x, y), (_, b, f) in zip(places, points, strict=True)
               if y is not None and any(map(broke, rows.of(b, f, law, guard)))]  # fmt: skip
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


def _mark_refused(axes: Axes, rows: Rows, points: Points, guard: bool) -> None:
    """Say where the guard refuses every law."""
    for x, base, factor in points:
        found = [row for law in rows.laws for row in rows.of(base, factor, law, guard)]
        if found and all(row.outcome == REFUSED for row in found):
            axes.text(x, 0.5, "refused", rotation=90, ha="center", va="center", size=7,
                      color=MUTED, transform=axes.get_xaxis_transform())  # fmt: skip


def _finish(figure: Figure, panels: Sequence[Axes], rows: Rows, text: str) -> None:
    panels[0].set_ylabel("ISE [m² s + rad² s]")
    for axes in panels:
        low, high = axes.get_ylim()
        axes.set_ylim(min(low, 0.3), max(high, 30.0))
    heading(figure, text)
    legend_row(figure, law_handles(rows.laws))
