"""What the paper's measure hides: figures of e1, V1 and the torques that one ISE cannot show."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from wmr_ctrl.campaign import Campaign, FigureTable
from wmr_ctrl.report.drawing import (
    Drawing,
    Padding,
    dots,
    heading,
    law_handles,
    legend_row,
    mark_switch,
    one_axes,
    plain_ticks,
    row_of_axes,
    rows_of,
    running_rms,
    seed_handle,
    switch_handle,
    thin,
)
from wmr_ctrl.report.paper_figures import Group, switch_time
from wmr_ctrl.report.style import INK, LIMIT, MUTED, look, shown
from wmr_ctrl.results import Run
from wmr_ctrl.scenario import load_scenario

HIDDEN = ("measure", "switch", "lyapunov_noise_free", "torque")
"""Names of the figures, in the report's order."""

WITH, WITHOUT = "paper-simulation", "paper-simulation-no-switch"
_COLUMNS = (
    ("ise_total", "whole-run ISE [m² s + rad² s]"),
    ("e1_rms_70_80", "RMS of $e_1$ over 70–80 s [m]"),
)


def measure_figures(campaign: Campaign) -> tuple[Drawing, ...]:
    """Every figure of :data:`HIDDEN`, in their order."""
    return (
        measure_drawing(campaign),
        switch_drawing(campaign),
        barrier_drawing(campaign),
        torque_drawing(campaign),
    )


def measure_drawing(campaign: Campaign) -> Drawing:
    """ISE and late e1 of every seed, with and without the change of parameters."""
    return Drawing(
        "measure",
        "The same change of parameters, in two measures",
        "Each mark is a seed, each bar a median. The factor is the median of “with the change” "
        "over “without it”, seed by seed. The ISE over the whole run, the paper’s measure, cannot "
        "tell MB with the change from MB without it; e₁ can.",
        (9.6, 2.6),
        partial(_draw_measure, table=campaign.table),
    )


def _draw_measure(figure: Figure, table: FigureTable) -> None:
    padding = Padding(left=0.60, right=0.62, bottom=0.42, top=0.62)
    for axes, (name, label) in zip(
        row_of_axes(figure, padding, (1, 1), 0.95), _COLUMNS, strict=True
    ):
        _panel_measure(axes, table, name, label)
    heading(figure, "What the change at 40 s does, in two measures")
    handles = [
        seed_handle("parameters change at 40 s", filled=True),
        seed_handle("the same seeds without the change", filled=False),
    ]
    legend_row(figure, handles, 0.26)


def _panel_measure(axes: Axes, table: FigureTable, name: str, label: str) -> None:
    laws = table.laws
    rows_of(axes, [look(law).label for law in laws])
    axes.set(xscale="log", xlabel=label)
    plain_ticks(axes)
    for row, law in enumerate(laws):
        changed, same = (table.values(name, case, law) for case in (WITH, WITHOUT))
        dots(axes, changed.values(), row - 0.2, law)
        dots(axes, same.values(), row + 0.2, law, filled=False)
        axes.annotate(_factor(changed, same), (1, row), xycoords=("axes fraction", "data"),
                      xytext=(6, 0), textcoords="offset points", va="center", size=8,
                      weight="bold", color=INK)  # fmt: skip
    axes.annotate("factor", (1, 1), xycoords="axes fraction", xytext=(6, 4), va="bottom",
                  textcoords="offset points", size=6.5, color=MUTED)  # fmt: skip


def _factor(changed: dict[int, float | None], same: dict[int, float | None]) -> str:
    ratios = [
        value / other
        for seed, value in changed.items()
        if value is not None and (other := same.get(seed))
    ]
    return f"× {shown(float(np.median(ratios)))}" if ratios else ""


_FROM = 20.0
_MEAN = 1.0

Runs = Mapping[tuple[str, str], Run]


def switch_drawing(campaign: Campaign) -> Drawing:
    """Running RMS of e1 with and without the change, one small panel per law."""
    return Drawing(
        "switch",
        "The error along the robot’s heading, with the change and without",
        "RMS of e₁ over a sliding second, first seed. SMC recovers fully and NN most of the way; "
        "MB keeps an offset of 1.5 cm, PID one of 4.5 cm where it had 1.9 cm before.",
        (9.6, 2.5),
        partial(_draw_switch, runs=campaign.runs, laws=campaign.table.laws),
    )


def _draw_switch(figure: Figure, runs: Runs, laws: tuple[str, ...]) -> None:
    padding = Padding(left=0.62, right=0.12, bottom=0.42, top=0.64)
    row = row_of_axes(figure, padding, (1,) * len(laws), 0.16)
    for axes, law in zip(row, laws, strict=True):
        _panel_switch(axes, law, runs)
        if axes is not row[0]:
            axes.tick_params(labelleft=False)
    row[0].set_ylabel("RMS of $e_1$ over 1 s [m]")
    _share_range(row)
    heading(figure, "What the change at 40 s does to the error along the heading")
    time = switch_time(runs[WITH, laws[0]])
    handles = [
        Line2D([], [], color=INK, lw=1.4, label="with the change"),
        Line2D([], [], color=MUTED, lw=1.0, label="without it, same noise"),
        *([switch_handle(time)] if time is not None else []),
    ]
    legend_row(figure, handles, 0.26)


def _panel_switch(axes: Axes, law: str, runs: Runs) -> None:
    changed, same = runs[WITH, law], runs[WITHOUT, law]
    axes.plot(*_running_error(same), color=MUTED, lw=0.9)
    axes.plot(*_running_error(changed), color=look(law).colour, lw=1.4)
    axes.set(yscale="log", xlabel="t [s]", xlim=(_FROM, changed.settings.duration))
    axes.set_xticks((30, 40, 50, 60, 70))
    axes.set_title(look(law).label, color=look(law).colour, pad=3)
    mark_switch(axes, switch_time(changed))


def _running_error(run: Run) -> tuple[np.ndarray, np.ndarray]:
    rows = slice(run.settings.index(_FROM), None)
    rms = running_rms(run["e[1]"], max(1, round(_MEAN / run.settings.control)))
    return thin(run.time[rows], np.maximum(rms[rows], 1e-6), 600)


def _share_range(row: tuple[Axes, ...]) -> None:
    low = min(axes.get_ylim()[0] for axes in row)
    high = max(axes.get_ylim()[1] for axes in row)
    for axes in row:
        axes.set_ylim(low, high)


NOMINAL = "paper-simulation-nominal"
_END = 5.0
"""How long it is shown [s]."""

_FLOOR = 1e-6
"""The least V1 that is shown."""


def barrier_drawing(campaign: Campaign) -> Drawing:
    """V1 of MB and NN in the run without noise and without the change; rises are marked."""
    group = {law: campaign.runs[NOMINAL, law] for law in ("mb", "nn")}
    return Drawing(
        "lyapunov_noise_free",
        "V₁ without noise and without the change",
        "Stretches in which V₁ rises from sample to sample are drawn red. MB’s V₁ falls, but for "
        "one step of 0.02 % of its start, where v_c0 leaves the saturated region between two "
        "samples. NN’s rises again and again, by a tenth of its start in all.",
        (9.6, 2.4),
        partial(_draw_barrier, group=group),
    )


def _draw_barrier(figure: Figure, group: Group) -> None:
    axes = one_axes(figure, Padding(left=0.62, right=0.14, bottom=0.42, top=0.50))
    for law, run in group.items():
        _trace_barrier(axes, law, run)
    axes.set(yscale="log", xlabel="t [s]", ylabel="V₁", xlim=(0, _END), ylim=(_FLOOR, 20))
    heading(figure, "Lyapunov function values without noise")
    rising = Line2D([], [], color=LIMIT, lw=2.2, label="rising")
    legend_row(figure, [*law_handles(group), rising])


def _trace_barrier(axes: Axes, law: str, run: Run) -> None:
    rows = slice(0, run.settings.index(_END))
    t, y = run.time[rows], np.maximum(run["V1"][rows], _FLOOR)
    axes.plot(t, y, color=look(law).colour, lw=1.1)
    rising = np.concatenate((np.diff(y) > 0, [False]))
    rising[1:] |= rising[:-1].copy()
    axes.plot(t, np.where(rising, y, np.nan), color=LIMIT, lw=2.0, alpha=0.9)


def slip_torque() -> float:
    """Wheel torque at which the paper's robot spins its wheels [N m].

    All its weight on the two driving wheels, and a tyre's friction coefficient of 1: m g r / 2.
    """
    robot = load_scenario(WITH).robot
    return robot.m * robot.g * robot.r / 2


def torque_drawing(campaign: Campaign) -> Drawing:
    """RMS from 2 s on and peak of the wheel torque, every law and seed."""
    return Drawing(
        "torque",
        "Wheel torques in Section V’s simulation",
        "RMS from 2 s on (hollow) and largest value (filled), every seed. The line is where a "
        "tyre with a friction coefficient of 1 would slip if the two driving wheels bore all the "
        "weight. The peaks last for the first tenths of a second.",
        (9.6, 2.0),
        partial(_draw_torque, table=campaign.table),
    )


def _draw_torque(figure: Figure, table: FigureTable) -> None:
    axes = one_axes(figure, Padding(left=0.60, right=0.20, bottom=0.42, top=0.50))
    rows_of(axes, [look(law).label for law in table.laws])
    for row, law in enumerate(table.laws):
        dots(axes, table.values("tau_rms", WITH, law).values(), row, law, filled=False)
        dots(axes, table.values("tau_peak", WITH, law).values(), row, law)
    axes.set(xscale="log", xlabel="wheel torque [N m]")
    axes.set_xlim(1, max(200, axes.get_xlim()[1]))
    plain_ticks(axes)
    axes.axvline(slip_torque(), color=LIMIT, lw=1.0)
    axes.axvspan(slip_torque(), axes.get_xlim()[1], color=LIMIT, alpha=0.08, lw=0)
    heading(figure, "Wheel torques: RMS and peak")
    handles = [
        seed_handle("RMS from 2 s on", filled=False),
        seed_handle("peak", filled=True),
        Line2D([], [], color=LIMIT, lw=1.0, label=f"tyres slip, {slip_torque():.3g} N m"),
    ]
    legend_row(figure, handles)
