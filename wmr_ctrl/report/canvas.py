"""Axes placed by inches, and the marks that every time trace shares."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.lines import Line2D

from wmr_ctrl.report.style import INK, LIMIT, MUTED, look

Place: TypeAlias = Figure | SubFigure
"""Where a panel is drawn: a figure of its own, or a part of a sheet."""


@dataclass(frozen=True, slots=True)
class Margins:
    """Space around the axes of a panel [inch]."""

    left: float = 0.56
    right: float = 0.10
    bottom: float = 0.40
    top: float = 0.48


def size_of(place: Place) -> tuple[float, float]:
    """Width and height of a place [inch]."""
    dpi = place.figure.dpi if isinstance(place, SubFigure) else place.dpi
    return place.bbox.width / dpi, place.bbox.height / dpi


def one_axes(place: Place, margins: Margins) -> Axes:
    """A single pair of axes that fills the place inside the margins."""
    return row_of_axes(place, margins, (1.0,), 0.0)[0]


def row_of_axes(
    place: Place, margins: Margins, widths: Sequence[float], gap: float
) -> tuple[Axes, ...]:
    """Axes side by side, as wide as ``widths`` relate, ``gap`` inches between them."""
    width, height = size_of(place)
    inner = width - margins.left - margins.right - gap * (len(widths) - 1)
    high = (height - margins.bottom - margins.top) / height
    left, axes = margins.left, []
    for share in widths:
        wide = inner * share / sum(widths)
        axes.append(place.add_axes((left / width, margins.bottom / height, wide / width, high)))
        left += wide + gap
    return tuple(axes)


def heading(place: Place, text: str) -> None:
    """A panel's title at its upper left corner."""
    width, height = size_of(place)
    place.text(0.06 / width, 1 - 0.06 / height, text, ha="left", va="top", weight="bold",
               size=8.5, color=INK)  # fmt: skip


def law_handles(laws: Iterable[str]) -> list[Line2D]:
    """One line per law, as legends want them."""
    return [
        Line2D([], [], color=look(law).colour, ls=look(law).dash, lw=1.4, label=look(law).label)
        for law in laws
    ]


def switch_handle(time: float) -> Line2D:
    """The legend's entry for :func:`mark_switch`."""
    return Line2D([], [], color=MUTED, lw=0.9, ls=(0, (2, 2)), label=f"new parameters, {time:g} s")


def legend_row(place: Place, handles: Sequence[Line2D], below: float = 0.24) -> None:
    """A legend in one row, its upper edge ``below`` inches under the place's; never over data."""
    width, height = size_of(place)
    place.legend(handles=handles, ncols=len(handles), loc="upper left",
                 bbox_to_anchor=(0.06 / width, 1 - below / height))  # fmt: skip


def include(axes: Axes, levels: Iterable[float]) -> None:
    """Widen the vertical view, if need be, so that it shows ``levels``."""
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, *levels), max(high, *levels))


def shade_limits(axes: Axes, limit: float, *, both: bool = True) -> None:
    """Shade what lies beyond +-``limit`` and draw its edges; the view stays as it is."""
    low, high = axes.get_ylim()
    edges = [(limit, max(high, limit))] + ([(min(low, -limit), -limit)] if both else [])
    for start, end in edges:
        axes.axhspan(start, end, color=LIMIT, alpha=0.10, lw=0, zorder=0.5)
    for level in (limit, -limit) if both else (limit,):
        axes.axhline(level, color=LIMIT, lw=0.9, zorder=1.5)
    axes.set_ylim(low, high)


def mark_switch(axes: Axes, time: float | None) -> None:
    """A thin vertical line where the robot's parameters change, if they do."""
    if time is not None:
        axes.axvline(time, color=MUTED, lw=0.8, ls=(0, (2, 2)), zorder=1.2)
