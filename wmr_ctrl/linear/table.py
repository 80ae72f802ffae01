"""A LinearReport as text: all figures, a line each, then the warnings."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from wmr_ctrl.checks.surroundings import lost_poses, rare_poses, rounded_effects
from wmr_ctrl.linear.linearise import Floats
from wmr_ctrl.linear.margins import Margins
from wmr_ctrl.linear.point import reference_velocity

if TYPE_CHECKING:
    from wmr_ctrl.linear.report import LinearReport


def lines_of(report: LinearReport) -> Iterator[str]:
    """Yield the lines of a report."""
    for part in (_head, _poles, _times, _margins, _errors, _warnings):
        yield from part(report)


_FORCES = ("thrust", "moment")
_WIDTH = 44


def _head(report: LinearReport) -> list[str]:
    kind = (
        "time-invariant" if report.time_invariant else f"time-varying; figures at {_when(report)}"
    )
    lines = [f"{report.law} on {report.scenario.name}, in error coordinates ({kind})"]
    if report.guarded:
        lines.append("The guard is on and inactive there: near that point it changes nothing.")
    return [*lines, ""]


def _when(report: LinearReport) -> str:
    v, omega = reference_velocity(report.scenario, report.at)[0]
    return f"t = {report.at:.4g} s, v_d = {v:.3g} m/s and {omega:.3g} rad/s"


def _poles(report: LinearReport) -> list[str]:
    lines = []
    if report.kinematic_poles is not None and report.saddle_poles is not None:
        lines = [
            _line("poles of Eq. (7) alone [1/s]", _complex(report.kinematic_poles)),
            _line("the same at e3 = pi (saddle)", _complex(report.saddle_poles)),
        ]
    if report.adaptive_poles is not None:
        verdict = "stable" if report.adaptive_stable else "UNSTABLE"
        shown = f"{_complex(report.adaptive_poles[:3])}  {verdict}"
        lines.append(_line("poles with learning, rightmost [1/s]", shown))
    if report.late:
        lines.append(
            "Poles are ln z / T of the loop sampled with the clock, delay and late sensors in it;"
            " where poses are rare, from one pose to the next, T being the time between two."
        )
    if said := rare_poses(report.scenario):
        lines.append(f"Margins and Bode plots are {said}.")
    if said := lost_poses(report.scenario):
        lines.append(f"All other figures are {said}.")
    if said := rounded_effects(report.scenario):
        lines.append(f"All figures are {said}.")
    lines += ["", f"{'pole [1/s]':>24} {'frequency [rad/s]':>20} {'damping':>10}"]
    for pole, (frequency, ratio) in zip(report.poles, report.damping, strict=True):
        lines.append(f"{_one(pole):>24} {frequency:>20.5g} {ratio:>10.4f}")
    return [*lines, ""]


def _times(report: LinearReport) -> list[str]:
    clock = report.scenario.clock.control
    return [
        _line(f"spectral radius at {clock:g} s", f"{report.spectral_radius:.6f}"),
        _line("largest stable period, linear loop [s]", _number(report.max_sample_time)),
        _line(f"largest delay at {clock:g} s, if told [s]", _number(report.max_delay, "0")),
        *(
            [_line(f"stable for true over believed mass at {clock:g} s", _mass(report))]
            if report.mass_range is not None
            else []
        ),
        _line("  with learning [s]", _number(report.max_sample_time_adaptive, "-")),
        _line("  at the barrier's kink [s]", _several(report.max_sample_time_kink)),
        _line("  one step from the barrier, at the start [s]", _several(report.one_step_safe_time)),
        "",
    ]


def _mass(report: LinearReport) -> str:
    assert report.mass_range is not None
    low, high = report.mass_range
    return f"{low:.3g} to {high:.3g}"


def _margins(report: LinearReport) -> list[str]:
    columns = ("gain up", "gain down", "phase [deg]", "untold [s]", "disk")
    lines = [f"{'margins':<22}" + "".join(f"{name:>13}" for name in columns)]
    clock = f"{report.scenario.clock.control:g} s"
    rows = {clock: report.sampled_margins}
    for label, both in (rows if report.late else {"continuous": report.margins} | rows).items():
        for force, item in zip(_FORCES, both, strict=True):
            lines.append(f"{f'{force}, {label}':<22}" + _margin_cells(item))
    return [*lines, ""]


def _margin_cells(item: Margins | None) -> str:
    if item is None:
        return f"{'unstable':>13}"
    shown = (item.gain, item.gain_down, item.phase, item.delay, item.disk)
    return "".join(f"{_number(value):>13}" for value in shown)


def _errors(report: LinearReport) -> list[str]:
    columns = ("phase [deg]", "disk", "period [s]")
    kind = f"at {report.scenario.clock.control:g} s" if report.late else "continuous"
    lines = [f"{'unlike model, ' + kind:<22}" + "".join(f"{name:>13}" for name in columns)]
    for item in report.model_errors:
        cells = (item.phase, item.disk, item.max_sample_time)
        shown = "".join(f"{_number(value):>13}" for value in cells)
        name = f"{item.parameter} x {item.factor:g}"
        lines.append(f"{name:<22}" + (shown if item.stable else f"{'unstable':>13}"))
    return lines


def _warnings(report: LinearReport) -> list[str]:
    wrapped = [textwrap.fill(text, 98, subsequent_indent="  ") for text in report.warnings]
    return ["", *(f"- {text}" for text in wrapped)] if wrapped else []


def _line(name: str, value: str) -> str:
    return f"{name:<{_WIDTH}} {value}"


def _number(value: float | None, none: str = "none") -> str:
    if value is None:
        return none
    return f"{value:.5g}" if np.isfinite(value) else "none"


def _several(values: Floats | None) -> str:
    return "-" if values is None else ", ".join(_number(float(value)) for value in values)


def _complex(values: Floats) -> str:
    return ", ".join(_one(value) for value in values)


def _one(value: complex) -> str:
    if abs(value.imag) < 1e-9 * max(1.0, abs(value)):
        return f"{value.real:.5f}"
    return f"{value.real:.5f}{value.imag:+.5f}j"
