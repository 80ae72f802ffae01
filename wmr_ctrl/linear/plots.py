"""Figures of a LinearReport: poles, sample times, Nyquist curves, the barrier's pull."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wmr_ctrl.linear.blocks import law_loop
from wmr_ctrl.linear.linearise import Floats
from wmr_ctrl.linear.margins import frequencies, open_loop
from wmr_ctrl.linear.point import learned_point
from wmr_ctrl.linear.pull import pull_curve
from wmr_ctrl.linear.sampled import spectral_radius

if TYPE_CHECKING:
    from wmr_ctrl.linear.report import LinearReport

_FORCES = ("thrust", "moment")
INK, SECOND, LIMIT, MUTED = "#1F77C9", "#E69F00", "#c62828", "#6b6b6b"
SIZE = (6.4, 4.0)
PERIODS = np.geomspace(1e-3, 0.5, 300)


def draw(report: LinearReport, folder: Path) -> list[Path]:
    """Write the figures as PNG into ``folder``, which is made; returns their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    parts = {"poles": _poles, "sample-time": _sample_time, "nyquist": _nyquist}
    if law_loop(report.scenario, report.law).has_barrier:
        parts["pull"] = _pull
    paths = []
    for name, plot in parts.items():
        figure = Figure(SIZE, layout="constrained")
        count = 1 if name in ("poles", "sample-time") else 2
        plot(report, figure.subplots(1, count, squeeze=False)[0])
        path = folder / f"{report.scenario.name}-{report.law}-{name}.png"
        figure.savefig(path, dpi=160)
        paths.append(path)
    return paths


def _poles(report: LinearReport, panels: Sequence[Axes]) -> None:
    (axes,) = panels

    def put(poles: Floats, marker: str, colour: str, label: str) -> None:
        axes.plot(poles.real, poles.imag, marker, color=colour, mfc="none", label=label)

    put(report.poles, "x", INK, "closed loop")
    if report.kinematic_poles is not None:
        put(report.kinematic_poles, "s", MUTED, "kinematic loop alone")
    if report.adaptive_poles is not None:
        put(report.adaptive_poles, "o", LIMIT, "with learning, rightmost")
    axes.axvline(0, color=LIMIT, lw=0.8)
    axes.set(xlabel="real part [1/s]", ylabel="imaginary part [rad/s]")
    axes.set_title(f"{report.law}: poles around the reference")
    _finish(axes)


def _sample_time(report: LinearReport, panels: Sequence[Axes]) -> None:
    (axes,) = panels
    scenario, law = report.scenario, report.law
    axes.plot(PERIODS, spectral_radius(scenario, law, PERIODS), color=INK, label="linear loop")
    rest = learned_point(scenario, law)
    if rest is not None:
        few = PERIODS[::3]
        learning = spectral_radius(scenario, law, few, rest, "learning")
        axes.plot(few, learning, color=SECOND, label="with learning")
    axes.axhline(1, color=LIMIT, lw=0.8, label="limit of stability")
    axes.axvline(scenario.clock.control, color=MUTED, ls="--", label="this scenario's clock")
    axes.set(xscale="log", ylim=(0.9, 1.3), xlabel="control period [s]", ylabel="spectral radius")
    axes.set_title(f"{law}: stability against the control period")
    _finish(axes)


def _nyquist(report: LinearReport, panels: Sequence[Axes]) -> None:
    for axis, panel in enumerate(panels):
        period = report.scenario.clock.control if report.late else None
        loop = open_loop(report.scenario, report.law, axis, period=period)
        w = 1j * frequencies(loop)
        curve = np.squeeze(loop(w if period is None else np.exp(w * period)))
        panel.plot(curve.real, curve.imag, color=INK, label="L(jw), w > 0")
        angle = np.linspace(0, 2 * np.pi, 200)
        panel.plot(np.cos(angle), np.sin(angle), color=MUTED, lw=0.8, label="unit circle")
        panel.plot(-1, 0, "+", color=LIMIT, ms=9, label="-1")
        panel.set(xlim=(-3, 1.5), ylim=(-3, 1.5), aspect="equal", xlabel="real part")
        panel.set_title(f"{report.law}: cut at the {_FORCES[axis]}")
        _finish(panel)
    panels[0].set_ylabel("imaginary part")


def _pull(report: LinearReport, panels: Sequence[Axes]) -> None:
    asked = law_loop(report.scenario, report.law).start.v_c0
    for axis, panel in enumerate(panels):
        u1 = report.scenario.limits.v_u1[axis]
        v = np.linspace(-u1, u1, 800)[1:-1]
        panel.plot(
            v, pull_curve(report.scenario, report.law, axis, float(asked[axis]), v), color=INK
        )
        panel.axhline(0, color=MUTED, lw=0.8)
        for side in (-u1, u1):
            panel.axvline(side, color=LIMIT, lw=0.8)
        panel.set(
            xlabel=("v1 [m/s]", "omega [rad/s]")[axis], ylabel=("force [N]", "moment [N m]")[axis]
        )
        panel.set_title(f"{report.law}: pull at v_c0 = {asked[axis]:.3g}")
        _finish(panel, legend=False)


def _finish(axes: Axes, legend: bool = True) -> None:
    axes.grid(color="#e4e4e4", lw=0.5)
    if legend:
        axes.legend(frameon=False, fontsize=7.5)
