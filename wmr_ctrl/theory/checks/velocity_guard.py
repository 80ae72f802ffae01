"""The velocity guard: contradictions of its bounds, gaps, price, and torque chatter."""

import math
from collections.abc import Iterator

from wmr_ctrl.control.guard.contradictions import contradictions
from wmr_ctrl.control.guard.price import (
    SpeedPrice,
    speed_price,
    torque_swing,
    usable_formula,
)
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.core.fields.units import rounded
from wmr_ctrl.results.settings import TIGHTER
from wmr_ctrl.results.verdicts import Warning
from wmr_ctrl.world.phases import largest_friction

from .loop import Loop
from .warning import SPEEDS, UNITS, is_taken

PLACE = "guard, docs/guarantee.md"
REMEDIES = {"disturbance.truncate": "Set disturbance.truncate = 3 for a guarantee."}
OTHER_REMEDY = (
    "Take it out of the scenario, or keep away from the limit with a smaller guard.alpha."
)
"""Remedies for an effect that breaks an assumption, by the key at fault."""
AGAINST = ("against friction ", "")
MOTIONLESS = ("no motion at all", "no turn at all")
"""Words for the way ahead, and for a turn, which no friction brakes."""

NEARLY = 0.9
"""Share of 1/T, the fastest rate of approach, below which a faster one buys more than another T."""
SHAKEN = 0.25
"""Share of the wheels' torque limit, or without one of friction's torque, that counts as a violent
swing."""


def contradicted(loop: Loop) -> Iterator[Warning]:
    """Yield violated bounds: those that the scenario states and, with the guard on, believed
    ones.
    """
    setup = loop.setup
    for item in setup.broken if loop.guarded else contradictions(setup.scenario, setup.bound):
        yield Warning(item.key, item.sentence, PLACE)


def guard_price(loop: Loop) -> Iterator[Warning]:
    """Yield reasons why the guarantee is void, and a reference that is too fast."""
    if not loop.guarded:
        return
    for text in void_effects(loop.setup):
        yield Warning(text.partition(" ")[0], text, PLACE, objects=False)
    price = speed_price(loop.scenario, loop.setup.guard)
    for axis, short in enumerate(price.short):
        if short:
            yield _too_fast(loop, price, axis)


def void_effects(setup: Setup) -> Iterator[str]:
    """Yield the key, the reason and the remedy of each effect that violates an assumption.

    Runs report it by a separate remark, and it does not count as a fault.
    """
    for effect in setup.effects:
        bound = effect.bounded(setup.scenario)
        if bound and bound.void:
            key, _, _ = bound.void.partition(" ")
            yield f"{bound.void} {REMEDIES.get(key, OTHER_REMEDY)}"


def _too_fast(loop: Loop, price: SpeedPrice, axis: int) -> Warning:
    guard, unit = loop.setup.guard, UNITS[axis]
    usable, best = price.usable[axis], price.unbeatable[axis]
    can = f"at most {usable:.3g} {unit}" if usable > 0 else MOTIONLESS[axis]
    late = guard.age[axis] or guard.window[axis] or guard.slowest
    other = f" No guard at all could leave more than {max(best, 0):.3g} {unit}." if late else ""
    sooner = "Shorten clock.control"
    if float(guard.alpha or 0.0) * loop.scenario.clock.control < NEARLY:
        sooner = "Raise guard.alpha"
    return Warning(
        "guard.dbar",
        f"The reference asks for {price.asked[axis]:.3g} {unit}, and {AGAINST[axis]}the guard "
        f"leaves {can}, {usable_formula(guard, axis)}: it falls behind.{other} {sooner}, or "
        f"{TIGHTER}.",
        PLACE,
    )


def violent_alpha(loop: Loop) -> Iterator[Warning]:
    """Yield a velocity error that the guard's slope turns into restless torques."""
    if not loop.guarded:
        return
    guard, robot, numbers = loop.scenario.guard, loop.scenario.robot, loop.setup
    (alpha,), nbar = numbers.value("guard.alpha"), numbers.value("guard.nbar")
    usual = largest_friction(loop.scenario) * robot.r / 2
    bound = usual if math.isinf(numbers.tau_max) else SHAKEN * numbers.tau_max
    for axis, (speed, unit) in enumerate(zip(SPEEDS, UNITS, strict=True)):
        swing = torque_swing(robot, numbers.guard, axis)
        if nbar[axis] and swing > bound > 0:
            calm = rounded(alpha * bound / swing, 2, up=False)
            origin = "" if guard.alpha is not None else " (1/T unless it is stated)"
            remedy = f"Choose guard.alpha = {calm} 1/s or less, which costs usable speed, or "
            if not is_taken(loop.scenario, {"guard.alpha": float(calm)}, loop.law):
                remedy = "No guard.alpha that keeps the limits is as calm as that: "
            yield Warning(
                "guard.alpha",
                f"guard.alpha = {alpha:g} 1/s{origin} turns the error of {speed}, "
                f"{nbar[axis]:.3g} {unit} either way, into torques that swing by about {swing:.3g} "
                f"N m per wheel while the guard acts, more than {bound:.3g} N m. {remedy}measure "
                "better.",
                PLACE,
                objects=False,
            )
