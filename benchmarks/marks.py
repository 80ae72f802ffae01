"""Marks of laws, seeds and rows in the figures of the paper's runs and of the comparison."""

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from wmr_ctrl.report.drawing import line_handle
from wmr_ctrl.report.style import INK, LIMIT, RULE_LINE, look
from wmr_ctrl.results import Floats


def dot_handle(
    label: str, colour: str = INK, face: str = INK, marker: str = "o", size: float = 4.0
) -> Line2D:
    """A legend's entry for marks of a colour, filled with the colour ``face``."""
    return Line2D([], [], ls="", marker=marker, ms=size, mec=colour, mfc=face, label=label)


def law_handles(laws: Iterable[str]) -> list[Line2D]:
    """One legend line per law."""
    return [line_handle(one.label, one.colour, dash=one.dash) for one in map(look, laws)]


def law_marks(laws: Iterable[str]) -> list[Line2D]:
    """One legend mark per law, for plots of dots."""
    return [dot_handle(one.label, one.colour, one.colour, one.marker) for one in map(look, laws)]


def shade_beyond(axes: Axes, limit: float) -> None:
    """A vertical line at ``limit``, and shade right of it; the view stays as it is."""
    axes.axvline(limit, color=LIMIT, lw=1.0)
    axes.axvspan(limit, axes.get_xlim()[1], color=LIMIT, alpha=0.08, lw=0)


def dots(
    axes: Axes, values: Floats, y: float, law: str, high: float = 0.4, *, filled: bool = True
) -> None:
    """A dot per value around height ``y``, spread within ``high`` so that none hides another.

    A bar marks the median.  NaN are left out.
    """
    x = values[~np.isnan(values)]
    if not x.size:
        return
    seen = look(law)
    face = seen.colour if filled else "white"
    # The golden ratio spreads any number of values evenly.
    aside = np.arange(x.size) * 0.6180339887 % 1.0 - 0.5 if x.size > 1 else 0.0
    axes.plot(x, y + 0.65 * high * aside, ls="", marker=seen.marker, ms=3.6, mfc=face,
              mec=seen.colour, mew=0.7, alpha=0.8, zorder=3)  # fmt: skip
    axes.plot(2 * [np.median(x)], [y - high / 2, y + high / 2], color=INK, lw=1.3, zorder=4)


def rows_of(axes: Axes, labels: Sequence[str]) -> None:
    """One labelled row per entry, the first on top, with faint lines between them."""
    axes.set_yticks(range(len(labels)), labels)
    axes.set_ylim(len(labels) - 0.5, -0.5)
    axes.tick_params(axis="y", length=0)
    axes.grid(axis="y", visible=False)
    for edge in range(1, len(labels)):
        axes.axhline(edge - 0.5, color=RULE_LINE, lw=0.8, zorder=0)


def law_rows(axes: Axes, laws: Iterable[str]) -> None:
    """One row per law."""
    rows_of(axes, [look(law).label for law in laws])
