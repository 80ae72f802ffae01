"""Linear analysis of a law on a scenario, as a value, as JSON and as text."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from itertools import count
from math import inf
from pathlib import Path
from typing import TypeAlias, TypeVar, cast

import numpy as np

from wmr_ctrl.control.laws.registry import LAWS
from wmr_ctrl.control.setup import settle, with_kinematics
from wmr_ctrl.core.fields.arguments import checks_arguments
from wmr_ctrl.core.late_bound import late_bound
from wmr_ctrl.results import json_safe
from wmr_ctrl.theory.checks import warnings_for
from wmr_ctrl.theory.checks.radius import largest_radius
from wmr_ctrl.theory.checks.stable_ranges import largest_period, largest_stable_delay, stable_masses
from wmr_ctrl.world.scenario import Scenario

from .linearise import (
    Floats,
    Point,
    check_inactive,
    instant,
    is_stable,
    law_loop,
    learned_point,
    on_reference,
)
from .margins import Margins, ModelError, margins_at, model_errors, worst
from .sampled import (
    kink_periods,
    largest_learning_period,
    one_step_period,
    radius_of,
)
from .state_space import (
    MEMORY,
    SADDLE,
    constant_speed,
    kinematic_poles,
    late,
    poles_at,
)

T = TypeVar("T")
Progress: TypeAlias = Callable[[float], None]
"""Is called with the share of a job that is done."""

AXES = (0, 1)
_MARGIN_NAMES = tuple(field.name for field in fields(Margins))
FASTEST = 8
"""Poles of the adaptive loop that are listed: the rightmost ones; the rest are the leak's."""
SLOW_PARTS = 8
"""Parts of a report that take their time."""


@dataclass(frozen=True)
class LinearReport:
    """Figures of one law on one scenario, linearised at the time ``at`` [s] of the reference.

    If the desired velocity varies, ``at`` is the requested time, else the time of the largest
    velocity.  ``guarded``: the guard is on, and inactive there.

    Poles in 1/s; times in s; ``margins`` per generalised force, continuous and ``sampled`` with the
    scenario's clock.  None: there is no such limit, or it does not apply.

    Every figure includes drives and sensors.  If ``late`` (a delay, an old or averaged velocity)
    there is no continuous loop: poles are ln z / T of the sampled one, and ``margins`` are the
    sampled ones.
    """

    scenario: Scenario
    law: str
    time_invariant: bool
    at: float
    point: Point
    guarded: bool
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
        """True if the loop with constant estimates and weights is stable or marginal."""
        return is_stable(self.poles)

    @property
    def adaptive_stable(self) -> bool | None:
        """True if it is stable with moving estimates and weights; None if the law never adapts."""
        return None if self.adaptive_poles is None else is_stable(self.adaptive_poles)

    @property
    def cuts(self) -> tuple[str, str]:
        """Places at which the loop is cut for margins."""
        sends = self.scenario.takes_velocity
        return ("v command", "omega command") if sends else ("thrust", "moment")

    @property
    def rest(self) -> float | None:
        """Distance from the reference [m] at rest, of a base that takes velocities."""
        sends = self.scenario.takes_velocity
        return float(np.hypot(*self.point.e[:2])) if sends else None

    @property
    def drops_guard(self) -> bool:
        """True if the scenario has a guard, but the figures are those without it."""
        return self.scenario.guard.enabled and not self.guarded

    @cached_property
    def damping(self) -> list[tuple[float, float]]:
        """Natural frequency [rad/s] and damping ratio of each pole."""
        return [(abs(p), -p.real / abs(p) if p else 1.0) for p in self.poles]

    def to_json(self) -> dict[str, object]:
        """Plain data: complex numbers as [re, im], non-finite or missing values as None."""
        smallest = worst(self.margins)
        each = smallest.as_dict() if smallest else dict.fromkeys(_MARGIN_NAMES)
        content = {
            "scenario": self.scenario.name,
            "law": self.law,
            "time_invariant": self.time_invariant,
            "at": None if self.time_invariant else self.at,
            "rest": self.rest,
            "guard": "inactive" if self.guarded else "left out" if self.drops_guard else None,
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
                "max_sample_time_kink": self.max_sample_time_kink,
                "one_step_safe_time": self.one_step_safe_time,
                "margins": [item and item.as_dict() for item in self.margins],
                "sampled_margins": [item and item.as_dict() for item in self.sampled_margins],
            },
            "model_errors": [asdict(item) for item in self.model_errors],
            "warnings": list(self.warnings),
        }
        return {key: json_safe(item) for key, item in content.items()}

    def table(self, width: int = 100) -> str:
        """The figures as text of at most ``width`` columns, one per line, then the warnings."""
        from .table import lines_of

        return "\n".join(lines_of(self, width))

    @checks_arguments
    def plots(self, folder: str | Path, progress: Progress | None = None) -> list[Path]:
        """Draw poles, sample times and Bode plots into ``folder``."""
        return cast("list[Path]", late_bound("draw_linear")(self, Path(folder), progress))


@checks_arguments
def report_linear(
    scenario: Scenario,
    law: str,
    at: float | None = None,
    *,
    guard: bool = False,
    progress: Progress | None = None,
) -> LinearReport:
    """All figures of ``law`` on ``scenario`` at the time ``at`` [s] of the reference.

    By default that is the time when the reference is fastest; stability and the largest stable
    period are those of its whole period, or of its worst point.  With ``guard`` the guard is on;
    raises ArgumentError if it acts at that point, and for a time outside the run.  Raises
    UnknownNameError or ScenarioError.  ``progress`` is called with the share that is done.
    """
    shares = (min(1.0, k / SLOW_PARTS) for k in count(1))

    def step(value: T) -> T:
        if progress:
            progress(next(shares))
        return value

    scenario = with_kinematics(scenario, LAWS[law])
    time = instant(scenario, at)
    if guard:
        check_inactive(scenario, law, time)
    point, period = on_reference(scenario, law, time), scenario.clock.control
    rest, loop = learned_point(scenario, law, time), law_loop(scenario, law)
    behind, outer = late(scenario), loop.traits.auxiliary
    sampled = step([margins_at(scenario, law, axis, point, period) for axis in AXES])
    return LinearReport(
        scenario=scenario,
        law=law,
        time_invariant=constant_speed(scenario),
        at=time,
        point=point,
        guarded=guard,
        late=behind,
        kinematic_poles=kinematic_poles(scenario) if outer else None,
        saddle_poles=kinematic_poles(scenario, SADDLE) if outer else None,
        poles=step(poles_at(scenario, law, point)),
        adaptive_poles=poles_at(scenario, law, rest, "learning")[:FASTEST] if rest else None,
        spectral_radius=(
            largest_radius(loop, period)
            if at is None
            else radius_of(scenario, law, point, MEMORY[loop.learns])(period)
        ),
        max_sample_time=step(largest_period(loop)),
        max_delay=step(largest_stable_delay(loop)),
        mass_range=step(stable_masses(loop)),
        max_sample_time_kink=step(kink_periods(scenario, law)),
        max_sample_time_adaptive=step(
            largest_learning_period(scenario, law, rest) if rest and not loop.learns else None
        ),
        one_step_safe_time=one_step_period(scenario, law),
        margins=sampled if behind else [margins_at(scenario, law, axis, point) for axis in AXES],
        sampled_margins=sampled,
        model_errors=step(model_errors(scenario, law, time)),
        warnings=tuple(str(item) for item in warnings_for(settle(scenario, law), inf)),
    )


def _pairs(poles: Floats | None) -> list[list[float]] | None:
    return None if poles is None else [[p.real, p.imag] for p in np.asarray(poles, complex)]


def _least(values: Floats | None) -> float | None:
    return None if values is None else float(np.min(values))
