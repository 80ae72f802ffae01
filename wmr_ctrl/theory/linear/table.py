"""A LinearReport as text: all figures, a line each, then the warnings."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from wmr_ctrl.results.compare import aligned
from wmr_ctrl.theory.checks.stable_ranges import MASSES
from wmr_ctrl.theory.checks.surroundings import lost_samples, rare_poses, rounded_effects

from .linearise import Floats, reference_velocity

if TYPE_CHECKING:
    from .linear_report import LinearReport

_NAMES = 46
"""Columns of a figure's name."""


def lines_of(report: LinearReport, width: int) -> Iterator[str]:
    """Yield the lines of a report; one that is longer than ``width`` is folded."""
    for line in chain(
        _head(report), _poles(report), _times(report), _margins(report), _model_errors(report),
        [""] * bool(report.warnings), (f"- {text}" for text in report.warnings),
    ):  # fmt: skip
        yield textwrap.fill(
            line, width, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False
        )


def _figure(name: str, value: str) -> str:
    return f"{name:<{_NAMES}} {value}"


def _head(report: LinearReport) -> Iterator[str]:
    v, omega = reference_velocity(report.scenario, report.at)[0]
    instant = f"t = {report.at:.4g} s, v_d = {v:.3g} m/s and {omega:.3g} rad/s"
    kind = "time-invariant" if report.time_invariant else f"time-varying; figures at {instant}"
    yield f"{report.law} on {report.scenario.name}, in error coordinates ({kind})"
    if report.guarded:
        yield "The guard is on and inactive there: near that point it changes nothing."
    elif report.drops_guard:
        yield "The scenario's guard is left out: --guard says whether it acts there."
    if report.rest is not None:
        off = f"{report.rest:.2g} m off" if report.rest >= 1e-6 else "on"
        text = f"Where the loop rests, {off} its reference, as if no limit cut its commands"
        yield f"{text}; a start farther from there may end elsewhere."
    yield ""


def _poles(report: LinearReport) -> Iterator[str]:
    if report.kinematic_poles is not None and report.saddle_poles is not None:
        yield _figure("poles of Eq. (7) alone [1/s]", _complex(report.kinematic_poles))
        yield _figure("the same at e3 = pi (saddle)", _complex(report.saddle_poles))
    if report.adaptive_poles is not None:
        verdict = "stable" if report.adaptive_stable else "UNSTABLE"
        shown = f"{_complex(report.adaptive_poles[:3])}  {verdict}"
        yield _figure("poles with learning, rightmost [1/s]", shown)
    if report.late:
        yield (
            "Poles are ln z / T of the loop sampled with the clock, with delay and late sensors; "
            "where poses are rare, from one pose to the next, T being the time between two."
        )
    scenario = report.scenario
    for figures_of, said in (
        ("Margins and Bode plots", rare_poses(scenario)),
        ("All figures", lost_samples(scenario)),
        ("All figures", rounded_effects(scenario)),
    ):
        if said:
            yield f"{figures_of} are {said}."
    yield ""
    rows = [
        (_one(pole), f"{frequency:.5g}", f"{ratio:.4f}")
        for pole, (frequency, ratio) in zip(report.poles, report.damping, strict=True)
    ]
    yield from aligned(("pole [1/s]", "frequency [rad/s]", "damping"), rows).splitlines()
    yield ""


def _times(report: LinearReport) -> Iterator[str]:
    clock = report.scenario.clock.control
    yield _figure(f"spectral radius at {clock:g} s", f"{report.spectral_radius:.6f}")
    yield _figure("largest stable period, linear loop [s]", _number(report.max_sample_time))
    yield _figure(f"largest known delay at {clock:g} s [s]", _number(report.max_delay, "0"))
    if report.mass_range is not None:
        low, high = report.mass_range
        name = f"stable for true over believed mass at {clock:g} s"
        every = report.mass_range == (1 / MASSES, MASSES)
        yield _figure(name, "all that were tried" if every else f"{low:.3g} to {high:.3g}")
    yield _figure("  with learning [s]", _number(report.max_sample_time_adaptive, "-"))
    yield _figure("  at the barrier's kink [s]", _several(report.max_sample_time_kink))
    one_step = _several(report.one_step_safe_time)
    yield _figure("  one step from the barrier, at the start [s]", one_step)


def _margins(report: LinearReport) -> Iterator[str]:
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
    yield from aligned(header, rows).splitlines()
    yield ""


def _model_errors(report: LinearReport) -> Iterator[str]:
    kind = f"at {report.scenario.clock.control:g} s" if report.late else "continuous"
    rows = []
    for item in report.model_errors:
        figures = map(_number, (item.phase, item.disk, item.max_sample_time))
        shown = figures if item.stable else ("unstable",)
        rows.append((f"{item.parameter} is {item.factor:g} times the believed", *shown))
    header = (f"margins, {kind}, if", "phase [deg]", "disk", "period [s]")
    yield from aligned(header, rows).splitlines()


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
