"""Identification results: a picture, and one page of HTML."""

from __future__ import annotations

from collections import Counter
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure, SubFigure

from wmr_ctrl.core.fields.files import AnyPath

from . import drawing
from .style import INK, LIMIT, MUTED

if TYPE_CHECKING:
    from wmr_ctrl.identification import BaseIdentification
    from wmr_ctrl.identification.bounds import Traces
    from wmr_ctrl.identification.propose import ProposedDrive

BLUE = "#1f77c9"
_MARGINS = drawing.Padding(left=0.62, right=0.18, bottom=0.42, top=0.5)
_AXES = (("v₁", "m/s", "thrust", "N"), ("ω", "rad/s", "moment", "N m"))
FORETOLD = {"guard": "predicted over at most 1 s", "filter": "predicted from commands"}


def write_identification(
    result: BaseIdentification,
    page: AnyPath | None = None,
    plot: AnyPath | None = None,
    drive: ProposedDrive | None = None,
) -> None:
    """Write one self-contained page of HTML, or the picture in it, or both.

    They show speeds as measured and predicted, and residuals with dbar or d; the page also shows a
    proposed ``drive``.  Files are written atomically.  Raises ResultFileError for another suffix or
    if a file cannot be written.
    """
    targets = drawing.picture_targets(plot, "an identification is drawn")
    traces = result.traces()
    drawn, section = drawing_of(result, traces), result.bounds.section
    if targets:
        drawn.written(targets)
    if page is not None:
        drawing.write_html(
            page, "identified.html.j2",
            result=result, scenario=result.scenario, section=section, drive=drive,
            verdicts=Counter(item.verdict for item in result.parameters.values()),
            visited=np.nanmax(np.abs(traces.measured), axis=0).tolist(),
            seconds=float(np.ptp(traces.t)),
            picture=lambda name: drawn.inlined(),
            guarded=section == "guard",
        )  # fmt: skip


def drawing_of(result: BaseIdentification, traces: Traces) -> drawing.Drawing:
    """The picture of an identification."""
    return drawing.Drawing("fit", (8.3, 6.6), partial(_draw, result=result, traces=traces))


def _draw(figure: Figure, result: BaseIdentification, traces: Traces) -> None:
    grid = figure.add_gridspec(3, 2, height_ratios=(1, 1, 0.9), hspace=0.0, wspace=0.0)
    for axis in (0, 1):
        _speeds(figure.add_subfigure(grid[axis, :]), result, traces, axis)
        _residuals(figure.add_subfigure(grid[2, axis]), result, traces, axis)


def _speeds(part: SubFigure, result: BaseIdentification, traces: Traces, axis: int) -> None:
    """Measured and predicted speed; the held-out part is shaded."""
    name, unit, _, _ = _AXES[axis]
    handles = [
        drawing.line_handle("as measured", INK, 0.9),
        drawing.line_handle(FORETOLD[result.bounds.section], BLUE),
    ]
    drawing.heading(part, f"{name} [{unit}]; shaded: held out from this fit", handles)
    axes = drawing.one_axes(part, _MARGINS)
    axes.plot(traces.t, traces.measured[:, axis], color=INK, lw=0.9)
    axes.plot(traces.t, traces.foretold[:, axis], color=BLUE, lw=1.1, alpha=0.85)
    axes.axvspan(traces.held_out_from, traces.t[-1], color=MUTED, alpha=0.12, lw=0)
    axes.set(xlabel="t [s]", xlim=(traces.t[0], traces.t[-1]))


def _residuals(part: SubFigure, result: BaseIdentification, traces: Traces, axis: int) -> None:
    """Residuals, with the bound derived from them."""
    speed, speed_unit, force, force_unit = _AXES[axis]
    forces = result.bounds.section == "guard"
    bound, what = ("dbar", "residual") if forces else ("d", f"off in {speed}")
    handles = [drawing.line_handle(what, BLUE), drawing.line_handle(bound, LIMIT)]
    words = f"Residual as a {force} [{force_unit}]" if forces else f"Deviation [{speed_unit}]"
    drawing.heading(part, words, handles)
    axes = drawing.one_axes(part, _MARGINS)
    axes.plot(traces.t, traces.residual[:, axis], color=BLUE, lw=0.6)
    largest = result.bounds.pairs()[bound][0][axis]
    if np.isfinite(largest):
        for level in (-largest, largest):
            axes.axhline(level, color=LIMIT, lw=1.0)
        drawing.include(axes, (-1.15 * largest, 1.15 * largest))
    axes.set(xlabel="t [s]", xlim=(traces.t[0], traces.t[-1]))
