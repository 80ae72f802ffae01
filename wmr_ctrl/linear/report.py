"""What linear theory says of a law on a scenario, as one value, as JSON and as text."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from wmr_ctrl.checks import warnings_for
from wmr_ctrl.checks.lateness import lost_poses, rare_poses, unknown_effects
from wmr_ctrl.checks.sample_time import largest_period, largest_stable_delay, stable_masses
from wmr_ctrl.control.setup import settle, with_kinematics
from wmr_ctrl.fields.arguments import checks_arguments
from wmr_ctrl.laws.registry import LAWS
from wmr_ctrl.linear.blocks import law_loop
from wmr_ctrl.linear.kinematic import SADDLE, kinematic_poles
from wmr_ctrl.linear.linearise import Floats, is_stable
from wmr_ctrl.linear.loop import closed_loop, constant_speed, cycle_at, late
from wmr_ctrl.linear.margins import Margins, ModelError, margins_at, model_errors, worst
from wmr_ctrl.linear.point import Point, learned_point, on_reference
from wmr_ctrl.linear.sampled import (
    kink_periods,
    largest_learning_period,
    one_step_period,
    radius_of,
)
from wmr_ctrl.results import json_safe
from wmr_ctrl.scenario import Scenario

T = TypeVar("T")
Progress: TypeAlias = Callable[[float], None]
"""Is called with the share of a job that is done."""

AXES = (0, 1)
_MARGIN_NAMES = tuple(field.name for field in fields(Margins))
FASTEST = 8
"""Poles of the adaptive loop that are listed: the rightmost ones; the rest are the leak's."""
GONE = 1e-6
"""Sampled poles up to this size are gone within a sample: what is only passed on."""


@dataclass(frozen=True)
class LinearReport:
    """Figures of one law on one scenario, near the reference at t = 0.

    Poles in 1/s; times in s; ``margins`` per generalised force, continuous and ``sampled`` with the
    scenario's clock.  None: there is no such limit, or it does not apply.

    Every figure has drives and sensors in it.  Where ``late`` (a delay, an old or averaged
    velocity) there is no continuous loop: poles are ln z / T of the sampled one, and ``margins``
    are the sampled ones.
    """

    scenario: Scenario
    law: str
    time_invariant: bool
    late: bool
    kinematic_poles: Floats | None
    saddle_poles: Floats | None
    poles: Floats
    adaptive_poles: Floats | None
    spectral_radius: float
    max_sample_time: float
    max_delay: float | None
    mass_range: tuple[float, float] | None
    max_sample_time_kink: Floats | None
    max_sample_time_adaptive: float | None
    one_step_safe_time: Floats | None
    margins: list[Margins | None]
    sampled_margins: list[Margins | None]
    model_errors: list[ModelError]
    warnings: tuple[str, ...]

    @property
    def stable(self) -> bool:
        """Whether the loop is stable, estimates and weights held; marginal counts."""
        return is_stable(self.poles)

    @property
    def adaptive_stable(self) -> bool | None:
        """Whether it is stable with them moving; None for a law that does not adapt."""
        return None if self.adaptive_poles is None else is_stable(self.adaptive_poles)

    @cached_property
    def damping(self) -> list[tuple[float, float]]:
        """Natural frequency [rad/s] and damping ratio of each pole."""
        return [(abs(p), -p.real / abs(p) if p else 1.0) for p in self.poles]

    def to_json(self) -> dict[str, object]:
        """Plain data: complex numbers as [re, im], what is not finite or does not exist as None."""
        smallest = worst(self.margins)
        each = smallest.as_dict() if smallest else dict.fromkeys(_MARGIN_NAMES)
        content = {
            "scenario": self.scenario.name,
            "law": self.law,
            "time_invariant": self.time_invariant,
            "poles_of": "sampled loop, ln z / T" if self.late else "continuous loop",
            "stable": self.stable,
            "adaptive_stable": self.adaptive_stable,
            "kinematic_poles": _pairs(self.kinematic_poles),
            "saddle_poles": _pairs(self.saddle_poles),
            "poles": _pairs(self.poles),
            "damping": [ratio for _, ratio in self.damping],
            "adaptive_poles": _pairs(self.adaptive_poles),
            "spectral_radius": self.spectral_radius,
            "max_sample_time": self.max_sample_time,
            "max_delay": self.max_delay,
            "mass_range": self.mass_range and list(self.mass_range),
            "max_sample_time_kink": _least(self.max_sample_time_kink),
            "max_sample_time_adaptive": self.max_sample_time_adaptive,
            "one_step_safe_time": _least(self.one_step_safe_time),
            "gain_margin": each["gain"],
            "gain_margin_down": each["gain_down"],
            "phase_margin": each["phase"],
            "delay_margin": each["delay"],
            "disk_margin": each["disk"],
            "per_axis": {
                "max_sample_time_kink": _listed(self.max_sample_time_kink),
                "one_step_safe_time": _listed(self.one_step_safe_time),
                "margins": [item and item.as_dict() for item in self.margins],
                "sampled_margins": [item and item.as_dict() for item in self.sampled_margins],
            },
            "model_errors": [asdict(item) for item in self.model_errors],
            "warnings": list(self.warnings),
        }
        return {key: json_safe(item) for key, item in content.items()}

    def table(self) -> str:
        """The same as text: all figures, a line each, then the warnings."""
        parts = (_head, _poles, _times, _margins, _errors, _warnings)
        return "\n".join(line for part in parts for line in part(self))

    @checks_arguments
    def plots(self, folder: str | Path, progress: Progress | None = None) -> list[Path]:
        """Draw poles, sample times, Bode, Nyquist and the barrier's pull into ``folder``."""
        from wmr_ctrl.linear.plots import draw

        return draw(self, Path(folder), progress)


class _Steps:
    """Hands values on, and tells which share of so many there have been."""

    def __init__(self, progress: Progress | None, count: int) -> None:
        self._progress, self._count, self._done = progress, count, 0

    def __call__(self, value: T) -> T:
        self._done += 1
        if self._progress:
            self._progress(min(1.0, self._done / self._count))
        return value


SLOW_PARTS = 8
"""Parts of a report that take their time."""


def report_linear(scenario: Scenario, law: str, progress: Progress | None = None) -> LinearReport:
    """All figures of ``law`` on ``scenario``; raises UnknownNameError or ScenarioError.

    ``progress`` is called with the share that is done.
    """
    step = _Steps(progress, SLOW_PARTS)
    scenario = with_kinematics(scenario, LAWS[law])
    at, period = on_reference(scenario, law), scenario.clock.control
    rest, loop = learned_point(scenario, law), law_loop(scenario, law)
    behind, outer = late(scenario), loop.traits.auxiliary
    sampled = step([margins_at(scenario, law, axis, at, period) for axis in AXES])
    return LinearReport(
        scenario=scenario,
        law=law,
        time_invariant=constant_speed(scenario),
        late=behind,
        kinematic_poles=kinematic_poles(scenario) if outer else None,
        saddle_poles=kinematic_poles(scenario, SADDLE) if outer else None,
        poles=step(_poles_at(scenario, law, at)),
        adaptive_poles=_adaptive_poles(scenario, law, rest),
        spectral_radius=radius_of(scenario, law, at)(period),
        max_sample_time=step(largest_period(loop)),
        max_delay=step(largest_stable_delay(loop)),
        mass_range=step(stable_masses(loop)),
        max_sample_time_kink=step(kink_periods(scenario, law)),
        max_sample_time_adaptive=step(_learning_period(scenario, law, rest)),
        one_step_safe_time=one_step_period(scenario, law),
        margins=sampled if behind else [margins_at(scenario, law, axis, at) for axis in AXES],
        sampled_margins=sampled,
        model_errors=step(model_errors(scenario, law)),
        warnings=tuple(str(item) for item in warnings_for(settle(scenario, law))),
    )


def _poles_at(scenario: Scenario, law: str, at: Point, memory: str = "frozen") -> Floats:
    """Poles [1/s], those furthest right first; ln z / T of the sampled loop where it is late."""
    if not late(scenario):
        return _sorted(closed_loop(scenario, law, at, memory=memory).poles())
    period = scenario.clock.control
    matrix, samples = cycle_at(scenario, law, at, period, memory)
    z = np.linalg.eigvals(matrix).astype(complex)
    return _sorted(np.log(z[np.abs(z) > GONE]) / (samples * period))


def _adaptive_poles(scenario: Scenario, law: str, rest: Point | None) -> Floats | None:
    return None if rest is None else _poles_at(scenario, law, rest, "learning")[:FASTEST]


def _learning_period(scenario: Scenario, law: str, rest: Point | None) -> float | None:
    return None if rest is None else largest_learning_period(scenario, law, rest)


def _sorted(poles: ArrayLike) -> Floats:
    values = np.asarray(poles, dtype=complex)
    return values[np.lexsort((values.imag, -values.real))]


def _pairs(poles: Floats | None) -> list[list[float]] | None:
    return None if poles is None else [[p.real, p.imag] for p in np.asarray(poles, complex)]


def _listed(values: Floats | None) -> list[float] | None:
    return None if values is None else [float(value) for value in values]


def _least(values: Floats | None) -> float | None:
    return None if values is None else float(np.min(values))


_FORCES = ("thrust", "moment")
_WIDTH = 44


def _head(report: LinearReport) -> list[str]:
    kind = "time-invariant" if report.time_invariant else "time-varying; figures at t = 0"
    return [f"{report.law} on {report.scenario.name}, in error coordinates ({kind})", ""]


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
    if said := unknown_effects(report.scenario):
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
