"""How a run ended: a value, never an exception, with a sentence that says what to do about it."""

from __future__ import annotations

import math
from enum import StrEnum

from wmr_ctrl.results.monitor import DIVERGENCE, Event, Monitor, RigidMonitor

_AXES = {1: ("linear velocity v1", "m/s"), 2: ("angular velocity omega", "rad/s")}


class Outcome(StrEnum):
    """How a run ended.  The value is the word that files and ``--json`` show."""

    COMPLETED = "completed"
    BOUNDS_LEFT = "bounds-left"
    LIMIT_VIOLATED = "limit-violated"
    DIVERGED = "diverged"
    TIPPED = "tipped"
    SLIPPED = "slipped"
    NON_FINITE = "non-finite"
    FAILED = "failed"

    def sentence(self, monitor: Monitor, guard: bool = False) -> str:
        """What happened, when [s], on which axis, and the remedy, for the run that was watched.

        ``guard`` tells whether the velocity guard was on.
        """
        text = _GUARDED if guard and self is Outcome.LIMIT_VIOLATED else _SENTENCES[self]
        return text.format(
            violation=_place(monitor.first_violation),
            stop=_place(monitor.stopped),
            left=_place(monitor.bounds_left),
            unit=_unit(monitor.stopped),
            bound=f"{DIVERGENCE:g}",
            steps=_steps(monitor.violations),
            extremes=_extremes(monitor.max_abs_v),
            failure=monitor.failure,
            **_rigid(monitor.rigid),
        )


_SENTENCES = {
    Outcome.COMPLETED: (
        "The run completed and both velocities stayed within their limits ({extremes})."
    ),
    Outcome.BOUNDS_LEFT: (
        "The run completed within its limits ({extremes}), but the {left} moved in a way that the "
        "guard's bounds do not admit, so its guarantee does not cover this run. Widen guard.dbar, "
        "or guard.M_min and guard.M_max."
    ),
    Outcome.LIMIT_VIOLATED: (
        "The velocity limit was broken, first by the {violation}; {steps} beyond a limit "
        "({extremes}). Switch the guard on, start inside the limits, or ask for a slower "
        "reference."
    ),
    Outcome.DIVERGED: (
        "The run ended early because of the {stop}: it reached {bound} {unit}, which no robot "
        "survives. Shorten clock.control, lower the law's gains, or start nearer to the reference."
    ),
    Outcome.NON_FINITE: (
        "The run ended early because of the {stop}: it was no longer a finite number. Shorten "
        "clock.control and clock.plant, and look for gains or torques that overflow."
    ),
    Outcome.TIPPED: (
        "The robot fell over: at t = {tipped} s its axis leant by more than body.tilt_max. {slip} "
        "Limit the wheel torques (actuator.tau_max or actuator.traction; `wmr-ctrl check` names "
        "the largest torque without spin or fall), start nearer to the reference, or lower the "
        "centre of mass."
    ),
    Outcome.SLIPPED: (
        "The run completed within its velocity limits ({extremes}), but the wheels slipped: from t "
        "= {slipped} s on, at most by {most} m/s. What the laws and the guard assume did not hold "
        "there. Limit the wheel torques (actuator.tau_max or actuator.traction; `wmr-ctrl check` "
        "names the largest torque without spin)."
    ),
    Outcome.FAILED: "The run ended early: {failure}",
}

_GUARDED = (
    "The velocity limit was broken although the guard was on, first by the {violation}; {steps} "
    "beyond a limit ({extremes}). The run started outside the limits, or left what the guard "
    "assumes: compare guard.dbar, M_min, M_max and nbar with the robot, state the drives' delay "
    "in full, and give them no lag."
)


def outcome_of(monitor: Monitor, guard: bool = False) -> Outcome:
    """The gravest thing that the monitor saw.

    In this order: failed, non-finite, diverged, tipped, limit-violated, slipped, bounds-left,
    completed.  Bounds are left for nothing where the ``guard`` was off: such a run had no guarantee
    to lose.
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
    """What a rigid body showed, as the sentences need it."""
    if seen is None:
        return {}
    slip = "Its wheels had kept their grip."
    if seen.slipped is not None:
        most = f"at most by {seen.max_slip:.3g} m/s"
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


def _unit(event: Event | None) -> str:
    return _AXES[event[1]][1] if event else "m/s or rad/s"


def _steps(count: int) -> str:
    return "1 plant step was" if count == 1 else f"{count} plant steps were"


def _extremes(max_abs_v: tuple[float, float]) -> str:
    linear, angular = max_abs_v
    return f"largest |v1| {linear:.4g} m/s, largest |omega| {angular:.4g} rad/s"
