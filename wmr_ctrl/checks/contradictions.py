"""What a scenario states and can hardly mean: units, bounds, a plant step, a shaken alpha."""

from __future__ import annotations

import math
from collections.abc import Iterator

from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.checks.warning import SPEEDS, UNITS, Warning
from wmr_ctrl.guard.contradictions import contradictions
from wmr_ctrl.scenario.units import unit_questions
from wmr_ctrl.world.phases import largest_friction, phases, steepness

SHAKEN = 0.25
"""Share of the wheels' torque limit that is a violent swing; without limit friction's torque is."""
COARSE, UNSTABLE = 1.0, 2.785
"""Plant step times slope of the friction: what is coarse for RK4, and what makes it diverge."""


def units(loop: Loop) -> Iterator[Warning]:
    """Yield every value that is unusual in its unit, with the unit that may be meant."""
    for key, question in unit_questions(loop.scenario):
        yield Warning(key, question, "units, docs/reference/scenario.md")


def contradicted(loop: Loop) -> Iterator[Warning]:
    """Yield what the scenario breaks: stated bounds, and with the guard on what is believed."""
    setup = loop.setup
    for item in setup.broken if loop.guarded else contradictions(setup.scenario, setup.bound):
        yield Warning(item.key, item.sentence, "guard, docs/guarantee.md")


def coarse_step(loop: Loop) -> Iterator[Warning]:
    """Yield where a plant step is long for mu m g tanh(v1/v_s) at rest, whose slope is steepest."""
    robot, step = loop.scenario.robot, loop.scenario.clock.plant
    slope = max(steepness(robot, phase) / phase.m for phase in phases(loop.scenario))
    if step * slope <= COARSE:
        return
    yield Warning(
        "clock.plant",
        f"clock.plant = {step:g} s is too coarse for the friction: mu g tanh(v1/v_s) changes at up "
        f"to {slope:.4g} 1/s, and the product of both, {step * slope:.3g}, should be at most "
        f"{COARSE:g} (RK4 diverges from {UNSTABLE:g} on). Choose {COARSE / slope:.2g} s or less, "
        "or a larger robot.v_s.",
        "Eq. (4), RK4",
    )


def violent_alpha(loop: Loop) -> Iterator[Warning]:
    """Yield where the velocity's error, through the guard's slope, shakes the torques at the limit.

    The guard's ceiling falls by M_min alpha for each m/s of measured velocity.  At the limit errors
    of -nbar to nbar move it, and the velocity that they cause moves it as much again: together by
    up to 4 nbar M_min alpha, the sum of the response's absolute values being 2 for alpha T <= 1.
    """
    if not loop.guarded:
        return
    guard, robot, numbers = loop.scenario.guard, loop.scenario.robot, loop.setup
    (alpha,), nbar, mass = (numbers.value(f"guard.{name}") for name in ("alpha", "nbar", "M_min"))
    arms = (robot.r / 2, robot.r / (2 * robot.l))
    usual = largest_friction(loop.scenario) * arms[0]
    bound = usual if math.isinf(numbers.tau_max) else SHAKEN * numbers.tau_max
    for axis, (speed, unit) in enumerate(zip(SPEEDS, UNITS, strict=True)):
        swing = 4 * nbar[axis] * mass[axis] * alpha * arms[axis]
        if nbar[axis] and swing > bound > 0:
            calm = alpha * bound / swing
            origin = "" if guard.alpha is not None else " (1/T unless it is stated)"
            yield Warning(
                "guard.alpha",
                f"guard.alpha = {alpha:g} 1/s{origin} turns the error of {speed}, "
                f"{nbar[axis]:.3g} {unit} either way, into torques that swing by about {swing:.3g} "
                f"N m a wheel while the guard acts, more than {bound:.3g} N m. Choose guard.alpha "
                f"= {calm:.2g} 1/s or less, which costs usable speed, or measure better.",
                "guard, docs/guarantee.md",
                objects=False,
            )
