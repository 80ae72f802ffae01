"""Figures of a LinearReport: poles, sample times, and Bode plots by python-control."""

from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wmr_ctrl.results import make_folder
from wmr_ctrl.theory.checks.radius import largest_radius
from wmr_ctrl.theory.linear.linear_report import LinearReport
from wmr_ctrl.theory.linear.linearise import law_loop, learned_point
from wmr_ctrl.theory.linear.margins import open_loop
from wmr_ctrl.theory.linear.sampled import spectral_radius

from .drawing import plain_ticks, save_figure, say_below
from .style import DASHED, LIMIT, MUTED, house_style, look, shown

INK, SECOND = "#1f77c9", "#e69f00"
SIZE = (6.4, 4.0)
RADII = (0.9, 1.3)
"""Spectral radii that are shown."""
PERIODS = np.geomspace(1e-3, 0.5, 150)
Panels: TypeAlias = "np.ndarray[tuple[int, int], np.dtype[np.object_]]"
"""The axes of a figure, by row and column."""


def draw_linear(
    report: LinearReport, folder: Path, progress: Callable[[float], None] | None = None
) -> list[Path]:
    """Write the figures as PNG into ``folder``, which is made; returns their paths.

    ``progress`` is called with the share that is done.
    """
    make_folder(folder)
    parts: dict[str, tuple[Callable[[LinearReport, Panels], None], int, int]] = {
        "poles": (_poles, 1, 1),
        "sample-time": (_sample_time, 1, 1),
        "bode": (_bode, 2, 2),
    }
    paths = []
    for name, (plot, rows, columns) in parts.items():
        path = folder / f"{report.scenario.name}-{report.law}-{name}.png"
        with house_style():
            figure = Figure((SIZE[0], SIZE[1] * (0.6 + 0.4 * rows)), layout="constrained")
            panels = figure.subplots(rows, columns, squeeze=False)
            plot(report, panels)
            handles, labels = panels[0, 0].get_legend_handles_labels()
            if labels:  # below the axes, where no curve is
                figure.legend(handles, labels, loc="outside lower left", ncols=4)
            save_figure(figure, path)
        paths.append(path)
        if progress:
            progress(len(paths) / len(parts))
    return paths


def _poles(report: LinearReport, panels: Panels) -> None:
    axes = panels[0, 0]

    for poles, marker, colour, label in (
        (report.poles, "x", INK, "closed loop"),
        (report.kinematic_poles, "s", MUTED, "kinematic loop alone"),
        (report.adaptive_poles, "o", LIMIT, "with learning, rightmost"),
    ):
        if poles is not None:
            axes.plot(poles.real, poles.imag, marker, color=colour, mfc="none", label=label)
    axes.axvline(0, color=LIMIT, lw=0.8, label="stable on its left")
    axes.set(xlabel="real part [1/s]", ylabel="imaginary part [rad/s]")
    rightmost = shown(float(report.poles.real.max()))
    axes.set_title(f"{_name(report)}: poles around the reference, rightmost at {rightmost} 1/s")


def _sample_time(report: LinearReport, panels: Panels) -> None:
    axes = panels[0, 0]
    scenario, law = report.scenario, report.law
    loop = law_loop(scenario, law)
    largest = np.array([largest_radius(loop, period) for period in PERIODS])
    axes.plot(1e3 * PERIODS, largest, color=INK, label="linear loop, at its worst")
    rest = learned_point(scenario, law, report.at)
    if rest is not None and not loop.learns:
        few = PERIODS[::3]
        learning = spectral_radius(scenario, law, few, rest, "learning")
        axes.plot(1e3 * few, learning, color=SECOND, label="with learning")
    axes.axhline(1, color=LIMIT, lw=0.8, label="stable below it")
    clock = 1e3 * scenario.clock.control
    axes.axvline(clock, color=MUTED, ls=DASHED, label=f"this scenario: {clock:g} ms")
    axes.set(xscale="log", ylim=RADII, xlabel="control period [ms]", ylabel="spectral radius [1]")
    plain_ticks(axes)
    if largest.max() > RADII[1]:
        say_below(axes, f"out of view: up to {shown(float(largest.max()))}")
    said = _stable(report.max_sample_time)
    if report.max_sample_time_adaptive is not None:
        said += f"; with learning {_stable(report.max_sample_time_adaptive)}"
    axes.set_title(f"{_name(report)}: {said}")


def _stable(period: float) -> str:
    """Text on the control periods [s] for which the loop is stable."""
    if not np.isfinite(period):
        return "stable for any period"
    return f"stable up to {shown(1e3 * period)} ms" if period > 0 else "stable for no period"


def _bode(report: LinearReport, panels: Panels) -> None:
    """The loop cut at a force: continuous, unless something is late, and sampled."""
    clock = report.scenario.clock.control
    periods: dict[str, float | None] = {} if report.late else {"continuous": None}
    periods |= {f"sampled, {clock:g} s": clock}
    for axis in (0, 1):
        for name, period in periods.items():
            loop = open_loop(report.scenario, report.law, axis, report.point, period)
            place = panels[:, axis : axis + 1]
            loop.bode_plot(dB=True, ax=place, label=name, title="", legend_loc=False)
        panels[0, axis].set_title(f"{_name(report)}: cut at the {report.cuts[axis]}")
        _note_margins(panels[1, axis], report, axis)


def _note_margins(axes: Axes, report: LinearReport, axis: int) -> None:
    """Text on the margins of the sampled loop."""
    item = report.sampled_margins[axis]
    if item is None:
        text = "sampled: unstable"
    else:
        gain = "any" if item.gain is None else f"{item.gain:.3g}"
        phase = "any" if item.phase is None else f"{item.phase:.3g}°"
        text = f"sampled: gain margin {gain}, phase margin {phase}"
    axes.set_title(text, size=7.5, weight="normal", color=MUTED)


def _name(report: LinearReport) -> str:
    return look(report.law).label
