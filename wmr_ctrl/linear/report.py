"""What linear theory says of a law on a scenario, as one value: poles, margins, sample times."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from wmr_ctrl.checks import warnings_for
from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.linear.along import constant_speed
from wmr_ctrl.linear.kinematic import SADDLE, kinematic_poles
from wmr_ctrl.linear.loop import closed_loop
from wmr_ctrl.linear.margins import Margins, margins_at, worst
from wmr_ctrl.linear.numbers import Floats, is_stable, radius
from wmr_ctrl.linear.one_step import one_step_period
from wmr_ctrl.linear.point import Point, on_reference, settled
from wmr_ctrl.linear.robustness import ModelError, model_errors
from wmr_ctrl.linear.sampled import kink_periods, largest_learning_period, largest_stable_period
from wmr_ctrl.results import json_safe
from wmr_ctrl.scenario import Scenario

AXES = (0, 1)
FASTEST = 8
"""Poles of the adaptive loop that are listed: the rightmost ones; the rest are the leak's."""


@dataclass(frozen=True)
class LinearReport:
    """Figures of one law on one scenario, near the reference at t = 0.

    Poles in 1/s; times in s; ``margins`` per generalised force, continuous and ``sampled`` with the
    scenario's clock.  None: there is no such limit, or it does not apply.
    """

    scenario: Scenario
    law: str
    time_invariant: bool
    kinematic_poles: Floats
    saddle_poles: Floats
    poles: Floats
    adaptive_poles: Floats | None
    spectral_radius: float
    max_sample_time: float
    max_sample_time_kink: Floats | None
    max_sample_time_adaptive: float | None
    one_step_safe_time: Floats | None
    margins: list[Margins | None]
    sampled_margins: list[Margins | None]
    model_errors: list[ModelError]
    warnings: tuple[str, ...]

    @property
    def stable(self) -> bool:
        """Whether the continuous loop is stable, estimates and weights held; marginal counts."""
        return is_stable(self.poles)

    @property
    def adaptive_stable(self) -> bool | None:
        """Whether it is stable with them moving; None for a law that does not adapt."""
        return None if self.adaptive_poles is None else is_stable(self.adaptive_poles)

    @cached_property
    def damping(self) -> list[tuple[float, float]]:
        """Natural frequency [rad/s] and damping ratio of each pole."""
        return [(abs(p), -p.real / abs(p) if p else 1.0) for p in self.poles]

    def to_json(self) -> dict[str, Any]:
        """Plain data: complex numbers as [re, im], what is not finite or does not exist as None."""
        each = {key: _worst(self.margins, key) for key in (f.name for f in fields(Margins))}
        found = {
            "scenario": self.scenario.name,
            "law": self.law,
            "time_invariant": self.time_invariant,
            "stable": self.stable,
            "adaptive_stable": self.adaptive_stable,
            "kinematic_poles": _pairs(self.kinematic_poles),
            "saddle_poles": _pairs(self.saddle_poles),
            "poles": _pairs(self.poles),
            "damping": [ratio for _, ratio in self.damping],
            "adaptive_poles": _pairs(self.adaptive_poles),
            "spectral_radius": self.spectral_radius,
            "max_sample_time": self.max_sample_time,
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
        return dict(json_safe(found))

    def table(self) -> str:
        """The same as text."""
        from wmr_ctrl.linear.table import table

        return table(self)

    def plots(self, folder: str | Path) -> list[Path]:
        """Draw poles, sample times, Nyquist curves and the barrier's pull into ``folder``."""
        from wmr_ctrl.linear.plots import draw

        return draw(self, Path(folder))


def report_linear(scenario: Scenario, law: str) -> LinearReport:
    """All figures of ``law`` on ``scenario``; raises UnknownNameError or ScenarioError."""
    at, period = on_reference(scenario, law), scenario.clock.control
    rest = resting_point(scenario, law)
    return LinearReport(
        scenario=scenario,
        law=law,
        time_invariant=constant_speed(scenario),
        kinematic_poles=kinematic_poles(scenario),
        saddle_poles=kinematic_poles(scenario, SADDLE),
        poles=_sorted(closed_loop(scenario, law, at).poles()),
        adaptive_poles=_adaptive_poles(scenario, law, rest),
        spectral_radius=radius(closed_loop(scenario, law, at, period).A),
        max_sample_time=largest_stable_period(scenario, law),
        max_sample_time_kink=kink_periods(scenario, law),
        max_sample_time_adaptive=_learning_period(scenario, law, rest),
        one_step_safe_time=one_step_period(scenario, law),
        margins=[margins_at(scenario, law, axis, at) for axis in AXES],
        sampled_margins=[margins_at(scenario, law, axis, at, period) for axis in AXES],
        model_errors=model_errors(scenario, law),
        warnings=tuple(str(item) for item in warnings_for(scenario, law)),
    )


def resting_point(scenario: Scenario, law: str) -> Point | None:
    """Where an adaptive law settles with all that it has learned; None if it does not adapt."""
    if not Loop(scenario, law).adaptive:
        return None
    try:
        return settled(scenario, law)
    except ArgumentError:
        return on_reference(scenario, law)


def _adaptive_poles(scenario: Scenario, law: str, rest: Point | None) -> Floats | None:
    if rest is None:
        return None
    return _sorted(closed_loop(scenario, law, rest, memory="learning").poles())[:FASTEST]


def _learning_period(scenario: Scenario, law: str, rest: Point | None) -> float | None:
    return None if rest is None else largest_learning_period(scenario, law, rest)


def _sorted(poles: Any) -> Floats:
    found = np.asarray(poles, dtype=complex)
    return found[np.lexsort((found.imag, -found.real))]


def _pairs(poles: Floats | None) -> list[list[float]] | None:
    return None if poles is None else [[p.real, p.imag] for p in np.asarray(poles, complex)]


def _listed(values: Floats | None) -> list[float] | None:
    return None if values is None else [float(value) for value in values]


def _least(values: Floats | None) -> float | None:
    return None if values is None else float(np.min(values))


def _worst(found: list[Margins | None], key: str) -> float | None:
    smallest = worst(found)
    return None if smallest is None else getattr(smallest, key)
