"""V1 without any noise: where it rises although theory has it fall."""

from __future__ import annotations

from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from wmr_ctrl.campaign import Campaign
from wmr_ctrl.report.canvas import Margins, heading, law_handles, legend_row, one_axes
from wmr_ctrl.report.drawing import Drawing
from wmr_ctrl.report.panels import Group
from wmr_ctrl.report.style import LIMIT, look
from wmr_ctrl.results import Run

CASE = "paper-simulation-nominal"
_END = 5.0
"""How long it is shown [s]."""

_FLOOR = 1e-6
"""The least V1 that is shown."""


def barrier_drawing(campaign: Campaign) -> Drawing:
    """V1 of MB and NN in the run without noise and without the change; rises are marked."""
    group = {law: campaign.runs[CASE, law] for law in ("mb", "nn")}
    return Drawing(
        "lyapunov_noise_free",
        "V₁ without noise and without the change",
        "Stretches in which V₁ rises from sample to sample are drawn red. MB’s V₁ falls, but for "
        "one step of 0.02 % of its start, where v_c0 leaves the saturated region between two "
        "samples. NN’s rises again and again, by a tenth of its start in all.",
        (9.6, 2.4),
        partial(_draw, group=group),
    )


def _draw(figure: Figure, group: Group) -> None:
    axes = one_axes(figure, Margins(left=0.62, right=0.14, bottom=0.42, top=0.50))
    for law, run in group.items():
        _trace(axes, law, run)
    axes.set(yscale="log", xlabel="t [s]", ylabel="V₁", xlim=(0, _END), ylim=(_FLOOR, 20))
    heading(figure, "Lyapunov function values without noise")
    rising = Line2D([], [], color=LIMIT, lw=2.2, label="rising")
    legend_row(figure, [*law_handles(group), rising])


def _trace(axes: Axes, law: str, run: Run) -> None:
    rows = slice(0, run.settings.index(_END))
    t, y = run.time[rows], np.maximum(run["V1"][rows], _FLOOR)
    axes.plot(t, y, color=look(law).colour, lw=1.1)
    rising = np.concatenate((np.diff(y) > 0, [False]))
    rising[1:] |= rising[:-1].copy()
    axes.plot(t, np.where(rising, y, np.nan), color=LIMIT, lw=2.0, alpha=0.9)
