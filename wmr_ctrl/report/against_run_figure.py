"""Figure of linear loops compared with runs: responses from one start, and deviation by size."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from wmr_ctrl.simulation.campaign.against_run import LEVELS, AgainstRun, LawAgainstRun

from .drawing import PICTURES, line_handle, save_figure, target_of
from .style import DASHED, DOTTED, LIMIT, MUTED, house_style, look

COLUMNS = (
    ("ahead", "behind", "e₁"),
    ("left", "right", "e₂"),
    ("turned left", "turned right", "e₃"),
)
"""Columns of panels: the drawn direction, its opposite, and the element of the error."""
DEVIATIONS = (1e-4, 3.0)
"""Deviations that are shown."""


GONE = 0.02
"""Share of its initial value below which a response counts as decayed."""


def draw_against_run(found: AgainstRun, path: Path) -> Path:
    """Write the figure to ``path``; raises ResultFileError if that is impossible."""
    target = target_of(path, PICTURES, f"a figure is drawn as {', '.join(PICTURES)}")
    with house_style():
        figure = Figure((9.0, 5.4), layout="constrained")
        rows = figure.subplots(2, len(COLUMNS), squeeze=False)
        for place, (way, back, name) in enumerate(COLUMNS):
            above, below = rows[:, place]
            for law, each in found.laws.items():
                item, colour = each.directions[way], look(law).colour
                time = each.period * np.arange(len(item.run))
                above.plot(time, item.run[:, place] / item.shown, color=colour)
                above.plot(time, item.linear[:, place] / item.shown, color=MUTED, ls=DASHED, lw=0.9)
                below.loglog(item.sizes, item.deviations, color=colour)
                other = each.directions[back]
                below.loglog(other.sizes, other.deviations, color=colour, ls=DOTTED)
            sizes = [each.directions[way].shown for each in found.laws.values()]
            unit = "rad" if place == 2 else "m"
            shown = f" by {sizes[0]:.2g} {unit}" if len(sizes) == 1 else ""
            above.set_title(f"reference {way}{shown}")
            above.set(xlabel="time [s]", ylabel=f"{name} by its start [1]")
            above.set_xlim(0, max(_until(each, way, place) for each in found.laws.values()))
            for level in LEVELS.values():
                below.axhline(level, color=LIMIT, lw=0.7)
            below.set(xlabel=f"size of the start [{unit}]", ylim=DEVIATIONS)
        rows[1, 0].set_ylabel("deviation by linear answer [1]")
        handles = [line_handle(look(law).label, look(law).colour) for law in found.laws]
        handles += [
            line_handle("linear", MUTED, dash=DASHED),
            line_handle("1 % and 10 %", LIMIT),
            line_handle("the other way", MUTED, dash=DOTTED),
        ]
        figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
        save_figure(figure, target)
    return target


def _until(law: LawAgainstRun, way: str, place: int) -> float:
    """Time [s] after which a law's response has decayed."""
    item = law.directions[way]
    there = np.flatnonzero(np.abs(item.run[:, place]) > GONE * item.shown)
    return law.period * float(there.max(initial=0) + 1)
