"""Fig. 3 and Fig. 5 of the paper: each panel by itself, and all twelve on a sheet."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from matplotlib.figure import Figure, SubFigure

from wmr_ctrl.report.canvas import (
    Margins,
    heading,
    law_handles,
    legend_row,
    switch_handle,
)
from wmr_ctrl.report.drawing import Drawing
from wmr_ctrl.report.panels import PANELS, Group, Panel
from wmr_ctrl.report.panels.base import switch_time

PANEL_SIZE = (4.7, 2.9)
SHEET_SIZE = (11.7, 15.6)
_SHEET_MARGINS = Margins(left=0.60, right=0.20, bottom=0.46, top=0.36)


def paper_figure(number: int, group: Group, what: str) -> Iterator[Drawing]:
    """The panels and the sheet of Fig. ``number``; ``what`` names it in titles."""
    for panel in PANELS:
        if panel.of(group):
            yield _panel(number, panel, group)
    yield Drawing(
        f"fig{number}_sheet", f"Fig. {number}: {what}", "All panels on one sheet.", SHEET_SIZE,
        partial(_draw_sheet, group=group, title=f"Fig. {number} rerun: {what}"),
    )  # fmt: skip


def _panel(number: int, panel: Panel, group: Group) -> Drawing:
    return Drawing(
        f"fig{number}{panel.letter}_{panel.key}", f"Fig. {number}({panel.letter})", panel.title,
        PANEL_SIZE, partial(_draw_panel, panel=panel, group=group),
    )  # fmt: skip


def _draw_panel(figure: Figure, panel: Panel, group: Group) -> None:
    shown = panel.of(group)
    panel.draw(figure, shown, Margins())
    heading(figure, f"({panel.letter}) {panel.title}")
    _legend(figure, shown, with_switch=panel.letter != "a")


def _draw_sheet(figure: Figure, group: Group, title: str) -> None:
    width, height = SHEET_SIZE
    head = 0.62
    figure.text(0.1 / width, 1 - 0.12 / height, title, weight="bold", size=12, va="top")
    _legend(figure, group, with_switch=True, below=0.40)
    ratios = (head, *6 * ((height - head) / 6,))
    grid = figure.add_gridspec(7, 2, height_ratios=ratios, hspace=0.0, wspace=0.0)
    for index, panel in enumerate(PANELS):
        part = figure.add_subfigure(grid[index // 2 + 1, index % 2])
        _draw_part(part, panel, group)


def _draw_part(part: SubFigure, panel: Panel, group: Group) -> None:
    shown = panel.of(group)
    heading(part, f"({panel.letter}) {panel.title}")
    if shown:
        panel.draw(part, shown, _SHEET_MARGINS)


def _legend(figure: Figure, group: Group, *, with_switch: bool, below: float = 0.24) -> None:
    handles = law_handles(group)
    time = switch_time(next(iter(group.values())))
    if with_switch and time is not None:
        handles.append(switch_handle(time))
    legend_row(figure, handles, below)
