"""Rows of dots, one per seed: the common machinery of the figures that show a spread."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from wmr_ctrl.report.style import INK, look


def dots(
    axes: Axes,
    values: Iterable[float | None],
    y: float,
    law: str,
    high: float = 0.4,
    *,
    filled: bool = True,
) -> None:
    """A dot per value around height ``y``, spread within ``high`` so that none hides another.

    A bar marks the median.  Values that are None are left out.
    """
    x = np.array([value for value in values if value is not None])
    if not x.size:
        return
    seen = look(law)
    face = seen.colour if filled else "white"
    axes.plot(x, y + 0.65 * high * _offsets(x.size), ls="", marker=seen.marker, ms=3.6, mfc=face,
              mec=seen.colour, mew=0.7, alpha=0.8, zorder=3)  # fmt: skip
    axes.plot(2 * [np.median(x)], [y - high / 2, y + high / 2], color=INK, lw=1.3, zorder=4)


def _offsets(count: int) -> np.ndarray:
    """Heights in [-0.5, 0.5], spread evenly for any number of values (golden ratio)."""
    if count == 1:
        return np.zeros(1)
    return np.asarray(np.arange(count) * 0.6180339887 % 1.0) - 0.5


def seed_handle(label: str, *, filled: bool) -> Line2D:
    """A legend's entry for the marks of one kind, whatever the law."""
    return Line2D([], [], ls="", marker="o", ms=4, mec=INK, mew=0.8,
                  mfc=INK if filled else "white", label=label)  # fmt: skip


def plain_ticks(axes: Axes, steps: Sequence[float] = (1, 2, 5)) -> None:
    """Label a logarithmic horizontal axis with plain numbers at ``steps`` of each decade."""
    axes.xaxis.set_major_locator(LogLocator(subs=steps))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())


def rows_of(axes: Axes, labels: Sequence[str]) -> None:
    """One labelled row per entry, the first on top, with faint lines between them."""
    axes.set_yticks(range(len(labels)), labels)
    axes.set_ylim(len(labels) - 0.5, -0.5)
    axes.tick_params(axis="y", length=0)
    axes.grid(axis="y", visible=False)
    for edge in range(1, len(labels)):
        axes.axhline(edge - 0.5, color="#ececec", lw=0.8, zorder=0)
