"""Operating points to linearise at: on the reference, or at the loop's true equilibrium.

The module also names the signals, and has numerical helpers for the other files.
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from wmr_ctrl.control.controller import controller
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.arguments import checks_arguments
from wmr_ctrl.core.signals import (
    COMMAND,
    FORCE,
    GUARD_DIAGNOSTICS,
    TRACKING_ERROR,
    VELOCITY,
    Signal,
)
from wmr_ctrl.theory.checks.error_coordinates import Floats
from wmr_ctrl.theory.checks.loop import Loop
from wmr_ctrl.theory.checks.rest import rest
from wmr_ctrl.theory.checks.sampled_plant import Point as Point
from wmr_ctrl.theory.checks.sending import loop_of
from wmr_ctrl.theory.checks.surroundings import surroundings
from wmr_ctrl.world.references import sample
from wmr_ctrl.world.scenario import Scenario

MARGINAL = 1e-7
"""Real parts up to this [1/s] count as zero: an estimate without leak, a reference that stands."""


def element_names(signals: Iterable[Signal]) -> list[str]:
    """Names of all elements in order: ``e[1]``, ``e[2]``, ``e[3]``, ``v1``, ``omega``, ..."""
    return [name for signal in signals for name in signal.elements]


DISTURBANCE = Signal(
    "disturbance", "N, N.m", "disturbing generalised force (thrust, turning moment)", 2
)
FORCES = element_names((FORCE,))
DISTURBANCES = element_names((DISTURBANCE,))
STATES = element_names((TRACKING_ERROR, *VELOCITY))
"""e (3), v1, omega: the robot seen from its reference."""


def check_axis(axis: int) -> None:
    """Raise ArgumentError for an invalid axis."""
    if axis not in (0, 1):
        raise ArgumentError(f"axis = {axis} must be 0, the thrust, or 1, the moment.")


def check_period(period: float | None, remedy: str = "Leave it out for a continuous loop.") -> None:
    """Raise ArgumentError for an invalid period [s]; None means continuous."""
    if period is not None and not 0.0 < period < np.inf:
        raise ArgumentError(f"period = {period!r} s must be finite and above 0. {remedy}")


def is_stable(poles: ArrayLike, sampled: bool = False) -> bool:
    """True if no pole is outside the stable region; marginal ones count as stable."""
    values = np.asarray(poles, dtype=complex)
    inside = np.abs(values) <= 1 + MARGINAL if sampled else values.real <= MARGINAL
    return bool(inside.all())


INSTANTS = 257
"""Times of a reference among which the fastest is looked for."""
CLIP_ACTIVE = GUARD_DIAGNOSTICS[0]
SAMPLES = 200
"""Samples after which what guard and law remember of a point is taken as settled."""


def law_loop(scenario: Scenario, law: str) -> Loop:
    """``law`` on ``scenario`` as the checks model it, built once."""
    return loop_of(settle(scenario, law))


def sent_names(scenario: Scenario) -> list[str]:
    """Names of a law's outputs: a generalised force, or a velocity."""
    return element_names(COMMAND) if scenario.takes_velocity else FORCES


def check_reading(scenario: Scenario, period: float | None) -> None:
    """Raise ArgumentError for an invalid period, or if a base needs one and it is missing."""
    check_period(period)
    if period is None and scenario.takes_velocity:
        raise ArgumentError(
            'base.kind = "velocity": the command depends on the period, so there is no continuous '
            "loop. State period=, such as scenario.clock.control."
        )


def unguarded(scenario: Scenario) -> Scenario:
    """The scenario with its guard off."""
    return replace(scenario, guard=replace(scenario.guard, enabled=False))


def reference_velocity(scenario: Scenario, t: float) -> tuple[Floats, Floats]:
    """Desired velocity (2) and its rate (2) at time ``t`` [s]."""
    desired = sample(scenario, np.array([t]))[0]
    return desired[3:5], desired[5:7]


def instant(scenario: Scenario, at: float | None) -> float:
    """Time [s] of the reference to linearise at; by default its time of largest speed.

    Raises ArgumentError for a time outside the run.
    """
    duration = scenario.clock.duration
    if at is None:
        times = np.linspace(0.0, min(duration, scenario.reference.cycle), INSTANTS)
        return float(times[np.abs(sample(scenario, times)[:, 3].round(9)).argmax()])
    if not 0 <= at <= duration:
        raise ArgumentError(
            f"the loop cannot be linearised at {at:g} s: the run lasts from 0 to {duration:g} s "
            "(clock.duration). Choose a time within it."
        )
    return at


@checks_arguments
def on_reference(scenario: Scenario, law: str, t: float = 0.0) -> Point:
    """The robot exactly on its reference at time ``t`` [s]: e = 0, v = v_d.

    Estimates and weights have their start values; a remembered sample is that of the reference. For
    a base that takes velocities it is the loop's equilibrium with settled estimates; ArgumentError
    if there is none.
    """
    if not 0.0 <= t < np.inf:
        raise ArgumentError(f"t = {t:g} s must be a time of the reference, from 0 s on.")
    v_d, v_d_dot = reference_velocity(scenario, t)
    if scenario.takes_velocity:
        return _driving(scenario, law, v_d, float(sample(scenario, np.array([t]))[0][2]))
    loop = law_loop(scenario, law).over(0)
    start = Point(np.zeros(3), v_d, v_d, v_d_dot, np.array(loop.core.x0), np.zeros(2))
    there = loop.after_a_sample(start)
    return replace(there, force=loop.after_a_sample(there).force)


@checks_arguments
def resting_point(scenario: Scenario, law: str, t: float = 0.0) -> Point:
    """The loop's true equilibrium for constant desired velocities, by Newton's method.

    Friction, a wrong model and the leak of the weights are included.  Raises ArgumentError if the
    memory has no equilibrium there.
    """
    start, around = on_reference(scenario, law, t), surroundings(alone(scenario))
    if scenario.takes_velocity:
        return start
    point = rest(law_loop(scenario, law).over(0), around, start, scenario.clock.control)
    if point is None:
        raise ArgumentError(
            f"the loop has no resting point near its reference ({FORCE.name} and friction cannot "
            "balance there); linearise on the reference instead."
        )
    return point


def _driving(scenario: Scenario, law: str, v_d: Floats, theta: float) -> Point:
    point = law_loop(scenario, law).resting(v_d, theta, scenario.clock.control)
    if point is None:
        raise ArgumentError(
            f"{law} on {scenario.name} has no resting point near its reference at v_d = "
            f"{v_d[0]:.3g} m/s, {v_d[1]:.3g} rad/s: `wmr-ctrl check --only stability` says why."
        )
    return point


def alone(scenario: Scenario) -> Scenario:
    """The robot without other effects: ideal drives and sensors, no disturbances."""
    drives = replace(type(scenario.actuator)(), tau_max=scenario.actuator.tau_max)
    return replace(scenario, actuator=drives, sensor=type(scenario.sensor)(), effects={})


def learned_point(scenario: Scenario, law: str, t: float = 0.0) -> Point | None:
    """Equilibrium of an adaptive law, learning settled; None if it does not adapt."""
    if not law_loop(scenario, law).traits.estimates:
        return None
    try:
        return resting_point(scenario, law, t)
    except ArgumentError:
        return on_reference(scenario, law, t)


def check_inactive(scenario: Scenario, law: str, t: float) -> None:
    """Raise ArgumentError if the guard changes the force on the reference at time ``t`` [s].

    The guard's own graph is evaluated, so its own refusals are raised, too.
    """
    on = replace(scenario, guard=replace(scenario.guard, enabled=True))
    system = controller(settle(on, law))
    clipped = next(item.expr for item in system.diagnostics if item.signal == CLIP_ACTIVE)
    graph = system.function("guarded", [system.update, clipped])
    desired = sample(scenario, np.array([t]))[0]
    given, state = np.concatenate((desired, desired[:5])), np.array(system.x0)
    for _ in range(SAMPLES):
        state, acts = (item.full().ravel() for item in graph(given, state, system.p0))
    if acts.any():
        axes = " and ".join(
            name for name, act in zip(("thrust", "moment"), acts, strict=True) if act
        )
        raise ArgumentError(
            f"the guard holds back the {axes} on the reference at {t:g} s: while it acts, the loop "
            "is not that of the law. Choose another time (--at) or a slower reference, or drop "
            "--guard."
        )
