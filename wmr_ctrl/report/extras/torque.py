"""Wheel torques: RMS and peak beside what the tyres can pass on."""

from __future__ import annotations

from functools import partial

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from wmr_ctrl.campaign import Campaign, Table
from wmr_ctrl.report.canvas import Margins, heading, legend_row, one_axes
from wmr_ctrl.report.drawing import Drawing
from wmr_ctrl.report.extras.dots import dots, plain_ticks, rows_of, seed_handle
from wmr_ctrl.report.style import LIMIT, look
from wmr_ctrl.scenario import load_scenario

CASE = "paper-simulation"


def slip_torque() -> float:
    """Wheel torque at which the paper's robot spins its wheels [N m].

    All its weight on the two driving wheels, and a tyre's friction coefficient of 1: m g r / 2.
    """
    robot = load_scenario(CASE).robot
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
        partial(_draw, table=campaign.table),
    )


def _draw(figure: Figure, table: Table) -> None:
    axes = one_axes(figure, Margins(left=0.60, right=0.20, bottom=0.42, top=0.50))
    rows_of(axes, [look(law).label for law in table.laws])
    for row, law in enumerate(table.laws):
        dots(axes, table.values("tau_rms", CASE, law).values(), row, law, filled=False)
        dots(axes, table.values("tau_peak", CASE, law).values(), row, law)
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
