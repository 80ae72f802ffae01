"""What the loop watched at t = 0 and at every plant step, finer than the log's samples."""

from __future__ import annotations

import operator
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from wmr_ctrl.errors import ArgumentError

Event: TypeAlias = tuple[float, int]
"""A time [s] and a velocity axis: 1 linear, 2 angular."""

DIVERGENCE = 1e3
"""A run ends where |v1| [m/s] or |omega| [rad/s] reaches this."""

STOP_REASONS = ("", "diverged", "non-finite")


@dataclass(frozen=True, slots=True)
class RigidMonitor:
    """What a rigid body showed over t = 0 and every plant step.

    ``tipped``, ``slipped``: first time [s] at which it leant over by more than body.tilt_max, which
    ends the run, and at which a tread moved over the ground by more than body.slip_max; None if
    never.  ``max_slip`` [m/s], ``max_wheel_speed`` [rad/s], ``max_tilt`` [rad];
    ``least_tip_margin`` [1], over the samples.
    """

    tipped: float | None = None
    slipped: float | None = None
    max_slip: float = 0.0
    max_wheel_speed: float = 0.0
    max_tilt: float = 0.0
    least_tip_margin: float = 1.0


@dataclass(frozen=True, slots=True)
class Monitor:
    """Extremes and events of a run, over t = 0 and every plant step.

    ``max_abs_v``: largest |v1| [m/s] and |omega| [rad/s]; ``violations``: number of plant steps
    beyond a limit by more than rounding (1e-12 of it); ``first_violation``: time [s] and axis of
    the first of them;
    ``stopped``: time [s] and axis that ended the run early, for ``stop_reason`` (empty if none);
    ``bounds_left``: time [s] and axis of the first motion that the guard's bounds do not admit,
    with the guard on or off.
    ``failure``: what else ended the run early, such as an FMU that refused a step.
    ``d_least``: largest of the logged d_least [N, N m], to be compared with ``Settings.dbar``; None
    where it was not watched.
    ``rigid``: what a rigid body showed; None for the plane model.
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

    def __post_init__(self) -> None:
        linear, angular = self.max_abs_v
        object.__setattr__(self, "max_abs_v", (float(linear), float(angular)))
        object.__setattr__(self, "violations", operator.index(self.violations))
        for name in ("first_violation", "stopped", "bounds_left"):
            object.__setattr__(self, name, _event(name, getattr(self, name)))
        if self.d_least is not None:
            force, moment = self.d_least
            object.__setattr__(self, "d_least", (float(force), float(moment)))
        if isinstance(self.rigid, Mapping):
            object.__setattr__(self, "rigid", RigidMonitor(**self.rigid))
        self._check()

    def _check(self) -> None:
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


def _event(name: str, value: Event | None) -> Event | None:
    if value is None:
        return None
    time, axis = value
    if axis not in (1, 2):
        raise ArgumentError(f"monitor.{name} names axis {axis!r}; it must be 1 or 2.")
    return float(time), operator.index(axis)
