"""What a log told of a robot, as a picture and as one page of HTML."""

from __future__ import annotations

import os
import tempfile
from collections import Counter
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure, SubFigure

from wmr_ctrl.report.drawing import (
    Drawing,
    Padding,
    heading,
    include,
    line_handle,
    one_axes,
    rows_of,
    save_figure,
    target_of,
    thin,
)
from wmr_ctrl.report.style import (
    INK,
    LIMIT,
    MUTED,
    PAPER,
    house_style,
    page_environment,
    picture,
    shown,
    with_unit,
)
from wmr_ctrl.report.tables import TextTable
from wmr_ctrl.results import atomic_text

if TYPE_CHECKING:
    from wmr_ctrl.identification import Identification
    from wmr_ctrl.identification.estimate import Traces

SUFFIXES = (".png", ".svg", ".pdf")
BLUE = "#1f77c9"
GRID_POINTS = 13
SPREAD = 3.5
"""Half of the likelihood's grid, in standard errors by the Fisher information."""
LEVELS = {3.0: "95 %", 4.61: "99 %"}
"""Falls of the log-likelihood that bound regions of two numbers at these confidences."""
_MARGINS = Padding(left=0.62, right=0.18, bottom=0.42, top=0.5)
_AXES = (("v", "m/s", "thrust", "N"), ("omega", "rad/s", "moment", "N m"))


def write_identification(
    result: Identification,
    page: str | os.PathLike[str] | None = None,
    plot: str | os.PathLike[str] | None = None,
) -> None:
    """Write one page of HTML that needs nothing but itself, or the picture in it, or both.

    Speeds with what was foretold, residuals with dbar, intervals, likelihood over delay and lag.
    Each file whole or not at all.  Raises ResultFileError for another suffix or where a file cannot
    be written.
    """
    known = f"an identification is drawn as {', '.join(SUFFIXES)}"
    target = None if plot is None else target_of(plot, SUFFIXES, known)
    with house_style(), tempfile.TemporaryDirectory() as folder:
        figure = drawing_of(result).figure()
        if target is not None:
            save_figure(figure, target)
        if page is not None:
            drawn = Path(folder, "fit.svg")
            save_figure(figure, drawn)
            text = _page(result, picture(drawn))
            with atomic_text(target_of(page, (".html",), "the page is .html")) as file:
                file.write(text)


def drawing_of(result: Identification) -> Drawing:
    """The picture."""
    return Drawing("fit", (8.3, 9.4), partial(_draw, result=result))


def _page(result: Identification, image: str) -> str:
    environment = page_environment()
    environment.filters["shown"] = shown
    return environment.get_template("identified.html.j2").render(
        result=result,
        scenario=result.scenario,
        parameters=_parameters(result),
        bounds=_bounds(result),
        verdicts=Counter(item.verdict for item in result.parameters.values()),
        visited=np.abs(result.white.last.mean[:, 2:4]).max(axis=0).tolist(),
        seconds=float(np.ptp(result.white.problem.log.t)),
        coloured=result.fit.free.sum() > result.white.free.sum(),
        picture=lambda name: image,
    )


def _parameters(result: Identification) -> TextTable:
    rows = []
    for name, (words, unit) in result.described().items():
        item = result.parameters[name]
        interval = f"{shown(item.low, 4)} to {shown(item.high, 4)}"
        when = f"{item.seconds[0]:.3g} to {item.seconds[1]:.3g} s"
        label = f"{name}: {with_unit(words, unit)}"
        rows.append((label, shown(item.value, 4), interval, item.verdict, when))
    head = ("", "value", "95 % interval", "does the log determine it?", "half of it came from")
    return TextTable(head, tuple(rows))


def _bounds(result: Identification) -> TextTable:
    bounds = result.bounds
    per_axis = {"M_min [kg, kg m²]": bounds.M_min, "M_max [kg, kg m²]": bounds.M_max,
                "dbar [N, N m]": bounds.dbar, "nbar [m/s, rad/s]": bounds.nbar}  # fmt: skip
    ranges = {"delay [s]": bounds.delay, "lag [s]": bounds.lag}
    rows = [
        (f"guard.{name}", *(shown(part, 4) for part in pair))
        for name, pair in (per_axis | ranges).items()
    ]
    return TextTable(("", "of v, or least", "of omega, or most"), tuple(rows))


def _draw(figure: Figure, result: Identification) -> None:
    traces = result.traces()
    grid = figure.add_gridspec(4, 2, height_ratios=(1, 1, 0.9, 1.25), hspace=0.0, wspace=0.0)
    for axis in (0, 1):
        _speeds(figure.add_subfigure(grid[axis, :]), traces, axis)
        _residuals(figure.add_subfigure(grid[2, axis]), traces, result.bounds.dbar, axis)
    _intervals(figure.add_subfigure(grid[3, 0]), result)
    if {"delay", "lag"} <= set(result.parameters):
        _likelihood(figure.add_subfigure(grid[3, 1]), result)


def _speeds(part: SubFigure, traces: Traces, axis: int) -> None:
    """Measured and foretold speed; the held-out part is shaded."""
    name, unit, _, _ = _AXES[axis]
    handles = [
        line_handle("as measured", INK, 0.9),
        line_handle("foretold from a second before at most", BLUE),
    ]
    heading(part, f"{name} [{unit}]; shaded: held out of the fit that foretells", handles)
    axes = one_axes(part, _MARGINS)
    axes.plot(*thin(traces.t, traces.measured[:, axis]), color=INK, lw=0.9)
    axes.plot(*thin(traces.t, traces.foretold[:, axis]), color=BLUE, lw=1.1, alpha=0.85)
    axes.axvspan(traces.held_out_from, traces.t[-1], color=MUTED, alpha=0.12, lw=0)
    axes.set(xlabel="t [s]", xlim=(traces.t[0], traces.t[-1]))


def _residuals(part: SubFigure, traces: Traces, dbar: tuple[float, float], axis: int) -> None:
    _, _, name, unit = _AXES[axis]
    handles = [line_handle("q z", BLUE), line_handle("dbar", LIMIT)]
    heading(part, f"Residual as a {name} [{unit}]", handles)
    axes = one_axes(part, _MARGINS)
    axes.plot(*thin(traces.t, traces.force[:, axis]), color=BLUE, lw=0.6)
    for level in (-dbar[axis], dbar[axis]):
        axes.axhline(level, color=LIMIT, lw=1.0)
    include(axes, (-1.15 * dbar[axis], 1.15 * dbar[axis]))
    axes.set(xlabel="t [s]", xlim=(traces.t[0], traces.t[-1]))


def _intervals(part: SubFigure, result: Identification) -> None:
    """Half-widths over what the verdicts compare them with, on a logarithmic scale."""
    items = result.parameters
    heading(part, "Half-width of the interval [%]", below=0.22)
    axes = one_axes(part, Padding(left=0.62, right=0.18, bottom=0.42, top=0.34))
    shares = [max(100 * item.share, 0.05) for item in items.values()]
    axes.set_xscale("log")
    for row, (share, item) in enumerate(zip(shares, items.values(), strict=True)):
        colour = {"told": BLUE, "roughly": "#e69f00"}.get(item.verdict, LIMIT)
        axes.plot([0.05, share], [row, row], color=colour, lw=3)
        axes.annotate(item.verdict, (share, row), xytext=(4, 0), va="center",
                      textcoords="offset points", size=6.8, color=INK,
                      bbox={"fc": PAPER, "ec": "none", "pad": 0.6})  # fmt: skip
    for edge in (10.0, 30.0):
        axes.axvline(edge, color=MUTED, lw=0.8, ls=(0, (2, 2)))
    axes.set_xlim(0.05, 8 * max(*shares, 30.0))
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    rows_of(axes, list(items))


def _likelihood(part: SubFigure, result: Identification) -> None:
    """Regions of delay and lag by the fall of the likelihood, with the intervals."""
    heading(part, "Delay and lag [ms]: likelihood, and the intervals as a cross", below=0.22)
    axes = one_axes(part, Padding(left=0.62, right=0.18, bottom=0.42, top=0.34))
    delay, lag = result.parameters["delay"], result.parameters["lag"]
    errors = result.standard_errors()
    x, y = (
        np.linspace(
            max(item.value - SPREAD * errors[name], least),
            item.value + SPREAD * errors[name],
            GRID_POINTS,
        )
        for name, item, least in (("delay", delay, 0.0), ("lag", lag, 5e-4))
    )
    fall = -result.likelihood(x.tolist(), y.tolist())
    lines = axes.contour(
        1e3 * x, 1e3 * y, fall.T, levels=list(LEVELS), colors=[BLUE], linewidths=(1.3, 0.8)
    )
    axes.clabel(lines, fmt=LEVELS, fontsize=6.5)
    axes.plot(
        1e3 * np.array([delay.low, delay.high]), 1e3 * np.full(2, lag.value), color=INK, lw=0.9
    )
    axes.plot(1e3 * np.full(2, delay.value), 1e3 * np.array([lag.low, lag.high]), color=INK, lw=0.9)
    axes.plot(1e3 * delay.value, 1e3 * lag.value, "o", color=INK, ms=3.5)
    axes.set(xlabel="delay [ms]", ylabel="lag [ms]")
