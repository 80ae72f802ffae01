"""A LinearReport as text: all figures, a line each, then the warnings."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from itertools import zip_longest
from typing import TYPE_CHECKING

import numpy as np

from wmr_ctrl.theory.checks.stable_ranges import MASSES
from wmr_ctrl.theory.checks.surroundings import lost_samples, rare_poses, rounded_effects

from .linearise import Floats, reference_velocity

if TYPE_CHECKING:
    from .linear_report import LinearReport

_NAMES = 46
"""Columns of a figure's name."""


def lines_of(report: LinearReport, width: int) -> Iterator[str]:
    """Yield the lines of a report, at most ``width`` columns each."""
    yield from _head(report, width)
    yield from _poles(report, width)
    yield from _figures(_times(report), width)
    yield from _margins(report, width)
    yield from _model_errors(report, width)
    if report.warnings:
        yield ""
    for text in report.warnings:
        yield _folded(f"- {text}", width)


def _folded(text: str, width: int) -> str:
    return textwrap.fill(
        text, width, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False
    )


def _figures(figures: list[tuple[str, str]], width: int) -> Iterator[str]:
    """A line for each name and value; the value on its own line if it does not fit."""
    for name, value in figures:
        line = f"{name:<{_NAMES}} {value}"
        if len(line) <= width:
            yield line
        else:
            yield _folded(name, width)
            yield textwrap.fill(value, width, initial_indent="    ", subsequent_indent="    ")


def _table(header: tuple[str, ...], rows: Sequence[tuple[str, ...]], width: int) -> Iterator[str]:
    """Columns to the right of the rows' names; a paragraph for each row if they do not fit."""
    cells = zip_longest(header, *rows, fillvalue="")
    first, *others = (max(map(len, column)) + 2 for column in cells)
    if first + sum(others) <= width:
        for name, *values in (header, *rows):
            right = (f"{value:>{size}}" for value, size in zip(values, others, strict=False))
            yield f"{name:<{first}}{''.join(right)}"
        return
    yield _folded(header[0], width)
    for name, *values in rows:
        named = (f"{key} {value}" for key, value in zip(header[1:], values, strict=False))
        shown = values if len(values) < len(header) - 1 else named
        yield _folded(f"- {name}: {', '.join(shown)}", width)


def _head(report: LinearReport, width: int) -> Iterator[str]:
    v, omega = reference_velocity(report.scenario, report.at)[0]
    instant = f"t = {report.at:.4g} s, v_d = {v:.3g} m/s and {omega:.3g} rad/s"
    kind = "time-invariant" if report.time_invariant else f"time-varying; figures at {instant}"
    yield _folded(f"{report.law} on {report.scenario.name}, in error coordinates ({kind})", width)
    if report.guarded:
        text = "The guard is on and inactive there: near that point it changes nothing."
        yield _folded(text, width)
    elif report.drops_guard:
        text = "The scenario's guard is left out: --guard says whether it acts there."
        yield _folded(text, width)
    if report.rest is not None:
        off = f"{report.rest:.2g} m off" if report.rest >= 1e-6 else "on"
        text = f"Where the loop rests, {off} its reference, as if no limit cut its commands"
        yield _folded(f"{text}; a start farther from there may end elsewhere.", width)
    yield ""


def _poles(report: LinearReport, width: int) -> Iterator[str]:
    figures = []
    if report.kinematic_poles is not None and report.saddle_poles is not None:
        figures = [
            ("poles of Eq. (7) alone [1/s]", _complex(report.kinematic_poles)),
            ("the same at e3 = pi (saddle)", _complex(report.saddle_poles)),
        ]
    if report.adaptive_poles is not None:
        verdict = "stable" if report.adaptive_stable else "UNSTABLE"
        shown = f"{_complex(report.adaptive_poles[:3])}  {verdict}"
        figures.append(("poles with learning, rightmost [1/s]", shown))
    yield from _figures(figures, width)
    if report.late:
        yield _folded(
            "Poles are ln z / T of the loop sampled with the clock, with delay and late sensors; "
            "where poses are rare, from one pose to the next, T being the time between two.",
            width,
        )
    scenario = report.scenario
    for figures_of, said in (
        ("Margins and Bode plots", rare_poses(scenario)),
        ("All other figures", lost_samples(scenario)),
        ("All figures", rounded_effects(scenario)),
    ):
        if said:
            yield _folded(f"{figures_of} are {said}.", width)
    yield ""
    rows = [
        (_one(pole), f"{frequency:.5g}", f"{ratio:.4f}")
        for pole, (frequency, ratio) in zip(report.poles, report.damping, strict=True)
    ]
    yield from _table(("pole [1/s]", "frequency [rad/s]", "damping"), rows, width)
    yield ""


def _times(report: LinearReport) -> list[tuple[str, str]]:
    clock = report.scenario.clock.control
    figures = [
        (f"spectral radius at {clock:g} s", f"{report.spectral_radius:.6f}"),
        ("largest stable period, linear loop [s]", _number(report.max_sample_time)),
        (f"largest known delay at {clock:g} s [s]", _number(report.max_delay, "0")),
    ]
    if report.mass_range is not None:
        low, high = report.mass_range
        name = f"stable for true over believed mass at {clock:g} s"
        every = report.mass_range == (1 / MASSES, MASSES)
        figures.append((name, "all that were tried" if every else f"{low:.3g} to {high:.3g}"))
    return [
        *figures,
        ("  with learning [s]", _number(report.max_sample_time_adaptive, "-")),
        ("  at the barrier's kink [s]", _several(report.max_sample_time_kink)),
        ("  one step from the barrier, at the start [s]", _several(report.one_step_safe_time)),
    ]


def _margins(report: LinearReport, width: int) -> Iterator[str]:
    given = {f"{report.scenario.clock.control:g} s": report.sampled_margins}
    if not report.late:
        given = {"continuous": report.margins} | given
    rows = []
    for label, both in given.items():
        for force, item in zip(report.cuts, both, strict=True):
            figures = (item.gain, item.gain_down, item.phase, item.delay, item.disk) if item else ()
            rows.append((f"{force}, {label}", *(map(_number, figures) if item else ("unstable",))))
    header = ("margins", "gain up", "gain down", "phase [deg]", "delay [s]", "disk")
    yield ""
    yield from _table(header, rows, width)
    yield ""


def _model_errors(report: LinearReport, width: int) -> Iterator[str]:
    kind = f"at {report.scenario.clock.control:g} s" if report.late else "continuous"
    rows = []
    for item in report.model_errors:
        figures = map(_number, (item.phase, item.disk, item.max_sample_time))
        shown = figures if item.stable else ("unstable",)
        rows.append((f"{item.parameter} is {item.factor:g} times the believed", *shown))
    header = (f"margins, {kind}, if", "phase [deg]", "disk", "period [s]")
    yield from _table(header, rows, width)


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
        return f"{value.real:z.5f}"
    return f"{value.real:z.5f}{value.imag:+.5f}j"
