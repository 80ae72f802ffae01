"""A LinearReport as text for the terminal."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import numpy as np

from wmr_ctrl.linear.margins import Margins
from wmr_ctrl.linear.numbers import Floats

if TYPE_CHECKING:
    from wmr_ctrl.linear.report import LinearReport

FORCES = ("thrust", "moment")
WIDTH = 44


def table(report: LinearReport) -> str:
    """All figures, a line each, then the warnings."""
    parts = (_head, _poles, _times, _margins, _errors, _warnings)
    return "\n".join(line for part in parts for line in part(report))


def _head(report: LinearReport) -> list[str]:
    kind = "time-invariant" if report.time_invariant else "time-varying; figures at t = 0"
    return [f"{report.law} on {report.scenario.name}, in error coordinates ({kind})", ""]


def _poles(report: LinearReport) -> list[str]:
    lines = [
        _line("kinematic poles [1/s]", _complex(report.kinematic_poles)),
        _line("the same at e3 = pi (saddle)", _complex(report.saddle_poles)),
    ]
    if report.adaptive_poles is not None:
        verdict = "stable" if report.adaptive_stable else "UNSTABLE"
        shown = f"{_complex(report.adaptive_poles[:3])}  {verdict}"
        lines.append(_line("poles with learning, rightmost [1/s]", shown))
    lines += ["", f"{'pole [1/s]':>24} {'frequency [rad/s]':>20} {'damping':>10}"]
    for pole, (frequency, ratio) in zip(report.poles, report.damping, strict=True):
        lines.append(f"{_one(pole):>24} {frequency:>20.5g} {ratio:>10.4f}")
    return [*lines, ""]


def _times(report: LinearReport) -> list[str]:
    clock = report.scenario.clock.control
    return [
        _line(f"spectral radius at {clock:g} s", f"{report.spectral_radius:.6f}"),
        _line("largest stable period, linear loop [s]", _number(report.max_sample_time)),
        _line("  with learning [s]", _number(report.max_sample_time_adaptive, "-")),
        _line("  at the barrier's kink [s]", _several(report.max_sample_time_kink)),
        _line("  one step from the barrier, at the start [s]", _several(report.one_step_safe_time)),
        "",
    ]


def _margins(report: LinearReport) -> list[str]:
    columns = ("gain up", "gain down", "phase [deg]", "delay [s]", "disk")
    lines = [f"{'margins':<22}" + "".join(f"{name:>13}" for name in columns)]
    clock = f"{report.scenario.clock.control:g} s"
    for label, found in (("continuous", report.margins), (clock, report.sampled_margins)):
        for force, item in zip(FORCES, found, strict=True):
            lines.append(f"{f'{force}, {label}':<22}" + _margin_cells(item))
    return [*lines, ""]


def _margin_cells(item: Margins | None) -> str:
    if item is None:
        return f"{'unstable':>13}"
    shown = (item.gain, item.gain_down, item.phase, item.delay, item.disk)
    return "".join(f"{_number(value):>13}" for value in shown)


def _errors(report: LinearReport) -> list[str]:
    columns = ("phase [deg]", "disk", "period [s]")
    lines = [f"{'robot unlike model':<22}" + "".join(f"{name:>13}" for name in columns)]
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
    return f"{name:<{WIDTH}} {value}"


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
