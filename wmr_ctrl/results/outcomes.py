"""Monitor and outcome of a run: extremes and events of every plant step, and the run's end.

An outcome is a value, never an exception, with a sentence that says what to do about it.
"""

import math
from dataclasses import dataclass
from enum import StrEnum

from wmr_ctrl.core.data import data
from wmr_ctrl.core.errors import ArgumentError

from .settings import Event

DIVERGENCE = 1e3
"""A run ends where |v1| [m/s] or |omega| [rad/s] reaches this."""
STOP_REASONS = ("", "diverged", "non-finite")
_AXES = {
    1: ("linear velocity v1", "m/s"),
    2: ("angular velocity omega", "rad/s"),
    3: ("speed of a wheel (filter.wheel_speed)", "m/s"),
}
_SAID = data(__package__, "outcomes.toml")


@dataclass(frozen=True)
class RigidMonitor:
    """Extremes and events of a rigid body, over t = 0 and every plant step.

    ``tipped``, ``slipped``: first time [s] at which its tilt exceeded body.tilt_max, which ends the
    run, and at which a tread slipped faster than body.slip_max; None if never. ``max_slip`` [m/s],
    ``max_wheel_speed`` [rad/s], ``max_tilt`` [rad]; ``least_tip_margin`` [1], over the samples.
    """

    tipped: float | None = None
    slipped: float | None = None
    max_slip: float = 0.0
    max_wheel_speed: float = 0.0
    max_tilt: float = 0.0
    least_tip_margin: float = 1.0


@dataclass(frozen=True)
class Monitor:
    """Extremes and events of a run, over t = 0 and every plant step.

    ``max_abs_v``: largest |v1| [m/s] and |omega| [rad/s]; ``least_margin``: the same to the nearer
    limit, negative beyond it, None where not known; ``violations``: number of plant steps beyond a
    limit by more than rounding (1e-12 of it); ``first_violation``: time [s] and axis of the first;
    ``stopped``: time [s] and axis that ended the run early, for ``stop_reason`` (empty if none);
    ``bounds_left``: time [s] and axis of the first motion that the guard's bounds do not explain,
    with the guard on or off.
    ``failure``: what else ended the run early, such as an FMU that refused a step.
    ``d_least``: largest of the logged d_least [N, N m], to be compared with ``Settings.dbar``; None
    if it was not monitored.
    ``rigid``: findings on a rigid body; None for the plane model.
    Raises ArgumentError where the fields contradict one another.
    """

    max_abs_v: tuple[float, float]
    violations: int = 0
    first_violation: Event | None = None
    stopped: Event | None = None
    stop_reason: str = ""
    bounds_left: Event | None = None
    failure: str = ""
    d_least: tuple[float, float] | None = None
    rigid: RigidMonitor | None = None
    least_margin: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        for event in filter(None, (self.first_violation, self.stopped, self.bounds_left)):
            if event[1] not in _AXES:
                raise ArgumentError(f"monitor: an event has the axis {event[1]}; axes are 1 to 3.")
        if self.stop_reason not in STOP_REASONS:
            raise ArgumentError(
                f"monitor.stop_reason = {self.stop_reason!r} must be one of {STOP_REASONS}."
            )
        if (self.violations > 0) != (self.first_violation is not None):
            raise ArgumentError(
                f"monitor.violations = {self.violations} does not fit monitor.first_violation = "
                f"{self.first_violation}: give both, or neither."
            )
        if bool(self.stop_reason) != (self.stopped is not None):
            raise ArgumentError(
                f"monitor.stop_reason = {self.stop_reason!r} does not fit monitor.stopped = "
                f"{self.stopped}: give both, or neither."
            )


class Outcome(StrEnum):
    """End of a run.  The value is the word in files and ``--json``."""

    COMPLETED = "completed"
    BOUNDS_LEFT = "bounds-left"
    LIMIT_VIOLATED = "limit-violated"
    DIVERGED = "diverged"
    TIPPED = "tipped"
    SLIPPED = "slipped"
    NON_FINITE = "non-finite"
    FAILED = "failed"

    def sentence(self, monitor: Monitor, guard: bool = False) -> str:
        """Sentence on the monitor's finding, with time [s], axis and remedy.

        ``guard``: whether the velocity guard was on.
        """
        text = _SAID["guarded" if guard and self is Outcome.LIMIT_VIOLATED else self]
        linear, angular = monitor.max_abs_v
        count, first = monitor.violations, monitor.first_violation
        outside = first is not None and first[0] == 0.0
        return text.format(
            violation=_place(monitor.first_violation),
            stop=_place(monitor.stopped),
            left=_place(monitor.bounds_left),
            unit=_AXES[monitor.stopped[1]][1] if monitor.stopped else "m/s or rad/s",
            bound=f"{DIVERGENCE:g}",
            steps="1 plant step was" if count == 1 else f"{count} plant steps were",
            extremes=f"largest |v1| {linear:.4g} m/s, largest |omega| {angular:.4g} rad/s",
            failure=monitor.failure,
            cause=_cause(outside, guard),
            unexplained=_SAID["unexplained"],
            **_rigid(monitor.rigid),
        )


def _cause(outside: bool, guard: bool) -> str:
    """Cause of a broken limit, with the remedy; a start outside may be only one of several
    causes.
    """
    if not outside:
        return _SAID["uncovered"] if guard else f"Switch {_SAID['unguarded']}"
    text = "The run started outside the limits: start inside them."
    return text if guard else f"{text} If it breaks them then, too: switch {_SAID['unguarded']}"


def beyond_bounds(monitor: Monitor) -> str:
    """Sentence on motion beyond the guard's bounds, in a run with a more severe outcome."""
    return f"The {_place(monitor.bounds_left)} {_SAID['unexplained']}"


def outcome_of(monitor: Monitor, guard: bool = False) -> Outcome:
    """The most severe finding of the monitor.

    In this order: failed, non-finite, diverged, tipped, limit-violated, slipped, bounds-left,
    completed. Without ``guard`` bounds-left is never the outcome: such a run had no guarantee to
    lose.
    """
    if monitor.failure:
        return Outcome.FAILED
    if monitor.stop_reason == "non-finite" or not all(map(math.isfinite, monitor.max_abs_v)):
        return Outcome.NON_FINITE
    if monitor.stop_reason == "diverged" or max(monitor.max_abs_v) >= DIVERGENCE:
        return Outcome.DIVERGED
    if monitor.rigid and monitor.rigid.tipped is not None:
        return Outcome.TIPPED
    if monitor.violations:
        return Outcome.LIMIT_VIOLATED
    if monitor.rigid and monitor.rigid.slipped is not None:
        return Outcome.SLIPPED
    return Outcome.BOUNDS_LEFT if guard and monitor.bounds_left else Outcome.COMPLETED


def _rigid(seen: RigidMonitor | None) -> dict[str, str]:
    if seen is None:
        return {}
    slip = "Its wheels did not slip."
    if seen.slipped is not None:
        most = f"by at most {seen.max_slip:.3g} m/s"
        slip = f"Its wheels slipped from t = {seen.slipped:.6g} s on, {most}."
    return {
        "tipped": f"{seen.tipped or 0.0:.6g}",
        "slipped": f"{seen.slipped or 0.0:.6g}",
        "most": f"{seen.max_slip:.3g}",
        "slip": slip,
    }


def _place(event: Event | None) -> str:
    if event is None:
        return "velocity, at a time that was not recorded"
    time, axis = event
    return f"{_AXES[axis][0]} at t = {time:.6g} s"
