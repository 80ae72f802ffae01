"""Assumptions of a filter that a run violates: refused unless `filter.trust` permits it."""

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import product

from wmr_ctrl.control.laws.law import Predicting
from wmr_ctrl.core.errors import ScenarioError, show
from wmr_ctrl.core.fields.section import Section
from wmr_ctrl.core.fields.units import rounded
from wmr_ctrl.world.command_loss import COMMAND_LOSS
from wmr_ctrl.world.command_ramp import COMMAND_RAMP, keeps_wheels, quick_stops
from wmr_ctrl.world.effect import ROUNDING, Bound, EffectRole, Pair
from wmr_ctrl.world.encoder import TIME, Encoder
from wmr_ctrl.world.phases import largest_friction, phases
from wmr_ctrl.world.registry import EFFECTS
from wmr_ctrl.world.resistance import Resistance, against, rolling_against
from wmr_ctrl.world.scenario import Scenario
from wmr_ctrl.world.speed_loop import has_loop
from wmr_ctrl.world.wheel_speed_limit import WHEEL_SPEED_LIMIT

from .governor_step import schedules
from .held_loop import (
    counts_on_rims,
    friction_at_a_rim,
    held_friction,
    kick_of_friction,
    push_speeds,
    too_quick,
)

UNITS = ("m/s", "rad/s")
CAPPED = " Here actuator.traction limits tau_max; false leaves that as it is stated."


def check_velocity_base(scenario: Scenario, gains: Section, bound: Bound) -> None:
    """Raise ScenarioError for options that a base that takes velocities cannot have."""
    if scenario.guard.enabled:
        raise ScenarioError(
            'guard.enabled: the guard limits wheel torques, and base.kind = "velocity" takes '
            'velocities. Set guard.enabled = false and filter.kind = "clip" or "governor".'
        )
    if isinstance(gains, Predicting) and gains.delay > 0:
        raise ScenarioError(
            f"{type(gains).KEY}.delay = {gains.delay:g} s: the law predicts from the torques that "
            'it sent, but with base.kind = "velocity" it sends velocities. Set it to 0.'
        )
    refuse_broken_hypotheses(scenario, bound)


def broken_hypotheses(scenario: Scenario, bound: Bound) -> tuple[str, ...]:
    """Sentences on violated conditions of the filter's theorem; empty if all hold.

    ``bound``: sum of the bounds of all effects that are present.
    """
    if scenario.filter.kind == "none":
        return ()
    settings = scenario.filter
    reaches = settings.kind == "clip" and settings.slew is None and settings.free_error is None
    if not reaches:  # a command that acts as 0 is no limit to the clip alone
        v, omega = (sum(pair) for pair in zip(bound.command, bound.dropped, strict=True))
        bound = replace(bound, command=(v, omega))
    sentences = [*_of_every_filter(scenario, bound)]
    stated, own = scenario.filter.rest, scenario.base.rest
    if stated is not None and any(bound.dbar) and own > stated * (1 + ROUNDING):
        sentences.append(
            f"filter.rest = {stated:g} s says that the base stands and holds, and base.rest = "
            f"{own:g} is longer: a push drives it on. State base.rest, of at most filter.rest, or "
            "take out what pushes (disturbances, slopes)."
        )
    if scenario.filter.kind == "governor":
        sentences += _of_the_governor(scenario, bound)
    if scenario.filter.kind == "clip" and scenario.filter.free_error is not None:
        sentences += _of_slow_stops(scenario, bound)
    if scenario.filter.kind == "band":
        sentences += _of_the_band(bound)
    if scenario.filter.slew is not None:
        sentences += _of_slow_commands(scenario, bound)
    capped = CAPPED * scenario.actuator.traction
    return tuple(dict.fromkeys(s + capped * ("actuator.tau_max" in s) for s in sentences))


def refuse_broken_hypotheses(scenario: Scenario, bound: Bound) -> None:
    """Raise ScenarioError for violated conditions, unless filter.trust is set."""
    sentences = broken_hypotheses(scenario, bound)
    if sentences and not scenario.filter.trust:
        raise ScenarioError(  # at most both axes of two things
            f'filter.kind = "{scenario.filter.kind}" guarantees nothing here. '
            f"{' '.join(sentences[:4])} To run it nevertheless, without guarantee, set "
            "filter.trust = true."
        )


def _of_every_filter(scenario: Scenario, bound: Bound) -> Iterator[str]:
    governs = scenario.filter.kind == "governor"
    for item in EFFECTS.present(scenario):
        if item.role is EffectRole.DRIVE and item.active(scenario):
            yield (
                f"{item.title} acts behind the speed loop, so its speed may exceed its command. "
                "Remove it from the scenario."
            )
        elif item.bound is None and (item.role is not EffectRole.SENSOR or governs):
            yield (
                f"{item.title} states no bound that a filter may rely on. Give its Effect one, or "
                "remove it from the scenario."
            )
    rates = scenario.base.wheel_accel, scenario.base.wheel_decel
    if rates[0] != rates[1]:
        yield (
            f"base.wheel_accel = {rates[0]:g} m/s2, wheel_decel = {rates[1]:g} m/s2: with two "
            "rates one wheel may stop while the other turns on, and v or omega passes its command. "
            "State one rate for both, if it holds for the base."
        )
    yield from _of_loops_by_axis(scenario, bound)
    missed = (own != loop == "first-order" for loop, own in _loops(scenario))
    if bound.overshoots and (any(missed) or has_loop(scenario, "first-order")):
        yield (
            f"{bound.overshoots} A filter for first-order loops is for speeds that never exceed "
            "their command. State filter.loop as the base has it, with its intervals."
        )
    if has_loop(scenario, "first-order"):
        yield from _of_pushed_weak_motors(scenario, bound)
        yield from _of_wheels(scenario)
    if has_loop(scenario, "first-order", [0]):
        yield from held_friction(scenario)
    yield from _of_pushes(scenario, bound)


def _loops(scenario: Scenario) -> Iterator[tuple[str, str]]:
    """For each axis: the loop that the filter assumes, and the base's loop."""
    return zip(scenario.filter.loop, scenario.base.loop, strict=True)


def _of_loops_by_axis(scenario: Scenario, bound: Bound) -> Iterator[str]:
    """Loops of v and omega, and their numbers, compared axis by axis."""
    stated, base, governs = scenario.filter, scenario.base, scenario.filter.kind == "governor"
    for axis, (loop, own) in enumerate(_loops(scenario)):
        if loop not in ("first-order", own):
            yield (
                f'filter.loop = "{loop}" does not fit the base of this run, whose base.loop = '
                f"{show(list(base.loop))}. State the loop that the base has."
            )
        elif own == "pi" and loop == own:
            yield from _of_pi_loop(scenario, bound, axis)
        elif loop == own:
            least, most = stated.intervals("gain")[axis]
            bounds = {"gain": ("1", (governs * least, most))}
            if own == "second-order":
                bounds["damping"] = "1", stated.intervals("damping")[axis]
                if stated.frequency is not None:
                    bounds["frequency"] = "rad/s", stated.intervals("frequency")[axis]
                yield from _of_swinging_loop(scenario, axis)
            for key, (unit, ends) in bounds.items():
                value = getattr(base, key)[axis]
                if not _within(value, ends):
                    yield _outside(f"base.{key}[{axis + 1}]", value, unit, f"filter.{key}", ends)


def _of_pushes(scenario: Scenario, bound: Bound) -> Iterator[str]:
    """Objections to pushes on a first-order base beyond d; for a governor also to pushes that slow
    it.
    """
    governs = scenario.filter.kind == "governor"
    swings = [loop == "second-order" for loop in scenario.filter.loop]
    slowed = [s * (governs or swing) for s, swing in zip(against(scenario), swings, strict=True)]
    held = 2 * largest_friction(scenario) * swings[0]  # it changes while the loop's force is held
    both = bound.dbar[0] + slowed[0] + held, bound.dbar[1] + slowed[1]
    pushes, held = push_speeds(scenario, replace(bound, dbar=both)), 0.0
    if counts_on_rims(scenario):
        held = friction_at_a_rim(scenario, pushes[0], bound)
    for axis, speed in enumerate((pushes[0] + held, pushes[1])):
        if speed <= (d := scenario.filter.d[axis]) * (1 + ROUNDING):
            continue
        said, why, other = "Disturbances and errors of the command may push the base on by", "", ""
        if slowed[axis] and not swings[axis]:
            said = "[resistance] and pushes together slow the base by up to"
            why = ": on its way back to rest the speed changes faster than the governor assumes"
            other = ', or use filter.kind = "clip"'
        elif held and axis == 0:
            said += " up to"
            why = ": friction (robot.mu) that changes within a plant step holds back v alone"
            which = "wheel_speed" if scenario.filter.wheel_speed is not None else "channels"
            other = f", shorten clock.plant or leave out filter.{which}"
        yield (
            f"{said} {rounded(speed, 4)} {UNITS[axis]}, and filter.d[{axis + 1}] = {d:g} "
            f"{UNITS[axis]} is less{why}. Raise it to that, if that is below the limit{other}."
        )


def _of_swinging_loop(scenario: Scenario, axis: int) -> Iterator[str]:
    """Objections to effects that no filter for overshooting loops covers."""
    start = scenario.initial.velocity
    if start[axis]:
        yield (
            f"initial.velocity = [{start[0]:g}, {start[1]:g}]: a filter for loops that overshoot "
            "assumes a base at rest at the start, since it does not know what drove it before. "
            "Set it to [0, 0]."
        )
    if scenario.base.rest < math.inf:
        yield (
            f"base.rest = {scenario.base.rest:g}: a base that stands at once does not follow "
            "its loop, as a filter for loops that overshoot assumes. Leave it out."
        )
    yield from _of_weak_motors(scenario)


def _of_pi_loop(scenario: Scenario, bound: Bound, axis: int) -> Iterator[str]:
    stated, base, robot = scenario.filter, scenario.base, scenario.robot
    mass = ("mass", "robot.m", robot.m, "kg"), ("inertia", "robot.I", robot.I, "kg.m2")
    numbers = (
        mass[axis], ("kp", "base.kp", base.kp, "N.s/m"), ("ki", "base.ki", base.ki, "N/m"),
    )  # fmt: skip
    for name, key, value, unit in numbers:
        if not _within(value, stated.interval(name)):
            yield _outside(key, value, unit, f"filter.{name}", stated.interval(name))
    yield from too_quick(scenario)
    if any(change.m is not None or change.I is not None for change in scenario.changes):
        yield (
            "[[changes]] changes the robot's mass while it drives, and the peak gain holds for "
            "loops that do not change. Leave mass and inertia constant: `changes = []` takes out "
            "those of a preset that the file extends."
        )
    viscous, lever = scenario.section(Resistance).viscous[axis], (1.0, robot.l**2)[axis]
    least, most = (lever * c for c in stated.friction)
    if not _within(viscous, (least, most)):
        key, name = f"resistance.viscous[{axis + 1}]", "filter.friction" + " robot.l^2" * axis
        yield _outside(key, viscous, ("N.s/m", "N.m.s/rad")[axis], name, (least, most))
    yield from _of_swinging_loop(scenario, axis)
    push = bound.dbar[axis] + rolling_against(scenario)[axis]
    push += (largest_friction(scenario), 0.0)[axis]
    if push > stated.push[axis] * (1 + ROUNDING):
        unit = ("N", "N.m")[axis]
        yield (
            f"The base may be pushed by {rounded(push, 4)} {unit} (disturbances, Coulomb "
            f"friction and rolling together), and filter.push[{axis + 1}] = "
            f"{stated.push[axis]:g} {unit} is less. Raise it to that."
        )
    if bound.command[axis] > stated.d[axis] * (1 + ROUNDING):
        yield (
            f"The command that acts may be off by {rounded(bound.command[axis], 4)} {UNITS[axis]} "
            f"(base.quantum). Raise filter.d[{axis + 1}] = {stated.d[axis]:g} to that."
        )


def _of_weak_motors(scenario: Scenario) -> Iterator[str]:
    """Objections to a torque limit that the loop may reach."""
    if not math.isinf(most := scenario.actuator.tau_max):
        yield (
            f"actuator.tau_max = {most:g} N.m: behind a torque limit the integral of the loop may "
            "wind up, and the speed then exceeds its command by more than the peak gain. Leave "
            "tau_max out if commands stay low enough for the motors."
        )


def _of_pushed_weak_motors(scenario: Scenario, bound: Bound) -> Iterator[str]:
    """Objections to a torque limit that a pushed first-order loop may reach.

    A wheel at its limit does not brake as the loop requires on either axis.  If both wheels are at
    their limits for a turn, pushes of any size drive the base on.
    """
    most, needed = scenario.actuator.tau_max, most_torque(scenario)
    if any(bound.dbar) and most < needed:
        yield (
            f"actuator.tau_max = {most:g} N.m: a wheel at its limit does not resist pushes, "
            "which may then drive the base on beyond filter.d. Raise it to "
            f"{rounded(needed, 3)} N.m, which the loop never asks for here, or take out what "
            "pushes (disturbances, slopes)."
        )


def _of_wheels(scenario: Scenario) -> Iterator[str]:
    """Objections to wheel limits that need equal loops of v and omega."""
    stated, base, governs = scenario.filter, scenario.base, scenario.filter.kind == "governor"
    speed, alike = stated.wheel_speed is not None, counts_on_rims(scenario)
    which = "filter.wheel_speed" if speed else 'the governor of filter.channels = "wheels"'
    remedy = "Leave it out" if speed else 'Use filter.channels = "body"'
    for key, (linear, angular) in (("tau", base.tau), ("gain", base.gain)):
        if alike and linear != angular and (governs or key == "tau"):
            yield (
                f"base.{key} = [{linear:g}, {angular:g}]: the loops of v and omega differ, so that "
                "no wheel follows a first-order loop of its own, and "
                f"{which} relies on that. {remedy}."
            )
    hold = ("jerk",) if keeps_wheels(scenario) else ("accel", "decel", "jerk")
    bounded = [f"base.{key}" for key in hold if min(getattr(base, key)) < math.inf]
    bounded += ["actuator.tau_max"] * (scenario.actuator.tau_max < most_torque(scenario))
    if speed and bounded:
        yield (
            f"{bounded[0]} may hold back one of v and omega while the other changes, so that a "
            "wheel passes filter.wheel_speed between two commands that keep it. Leave out either"
            f"{quick_stops(scenario) * ('cel' in bounded[0])}."
        )


def most_torque(scenario: Scenario) -> float:
    """Largest wheel torque [N m] of a first-order loop, for all speeds within limits."""
    base, robot, h = scenario.base, scenario.robot, scenario.clock.plant
    robots = [phase.robot for phase in phases(scenario)]
    masses = max(item.m for item in robots), max(item.I for item in robots)
    force, moment = (
        2 * limit * mass * -math.expm1(-h / tau) / h
        for limit, mass, tau in zip(scenario.limits.v_u1, masses, base.tau, strict=True)
    )
    return robot.r * (force + largest_friction(scenario) + moment / robot.l) / 2


def _of_the_band(bound: Bound) -> Iterator[str]:
    """Objections to effects that change commands between the band and the loop of its tables."""
    if bound.hidden:
        yield (
            f"{bound.hidden} The band relies on every command reaching the loop as it was sent. "
            'Use filter.kind = "clip".'
        )
    soonest, latest = bound.takeover
    if bound.losses or soonest != latest:
        yield (
            "Commands may be lost, or delayed by varying times, and the band relies on each one "
            'taking effect, a constant delay after it was sent. Use filter.kind = "clip".'
        )


def _of_slow_commands(scenario: Scenario, bound: Bound) -> Iterator[str]:
    """Objections to effects that make the acting command change faster than it was sent."""
    if bound.hidden:
        yield (
            f"{bound.hidden} With filter.slew the clip relies on every command reaching the loop "
            "as it was sent. Leave out filter.slew."
        )
    yield from _of_the_times(scenario, bound)


def _of_the_times(scenario: Scenario, bound: Bound) -> Iterator[str]:
    """Objections to delays and losses beyond the stated ones."""
    stated = scenario.filter
    for late, ends in product(bound.takeover, dict.fromkeys(stated.intervals("delay"))):
        if not _within(late, ends):
            yield _outside("A command's delay", late, "s", "filter.delay", ends)
    if bound.losses > stated.losses:
        yield (
            f"base.losses = {bound.losses} commands in a row may be lost, and filter.losses = "
            f"{stated.losses} is less. Raise it to that."
        )


def _of_the_governor(scenario: Scenario, bound: Bound) -> Iterator[str]:
    stated = scenario.filter
    if bound.hidden:
        yield (
            f"{bound.hidden} The governor relies on a speed that begins to change at once, and "
            'anything that it does not see breaks its guarantee. Use filter.kind = "clip".'
        )
    if has_loop(scenario, "first-order"):
        for axis, (tau, ends) in enumerate(
            zip(scenario.base.tau, stated.intervals("tau"), strict=True), 1
        ):
            if not _within(tau, ends):
                yield _outside(f"base.tau[{axis}]", tau, "s", "filter.tau", ends)
    yield from _of_the_times(scenario, bound)
    if stated.odometry is not None:
        yield from _of_odometry(scenario, bound, stated.odometry)


def _of_slow_stops(scenario: Scenario, bound: Bound) -> Iterator[str]:
    """Objections to a base that slows down later or less than a stopping clip assumes."""
    stated, base = scenario.filter, scenario.base
    rates = zip(stated.decel or (), base.decel, base.gain, strict=False)
    for axis, (least, rate, gain) in enumerate(rates, 1):
        if (slows := rate * gain) * (1 + ROUNDING) < least:
            yield (
                f"The base slows down by base.decel[{axis}] times base.gain[{axis}] = {slows:g}, "
                f"less than filter.decel[{axis}] = {least:g}. Lower the latter to it."
            )
    for axis, lag in enumerate(base.tau):
        most = 0.0 if stated.tau is None else stated.intervals("tau")[axis][1]
        if base.loop[axis] == "first-order" and lag > most * (1 + ROUNDING):
            yield (
                f"base.tau[{axis + 1}] = {lag:g} s delays a stop, and filter.tau covers {most:g} "
                "s. State filter.tau = [low, high] that holds it."
            )
    for item in EFFECTS.present(scenario):
        covered = item in (COMMAND_RAMP, WHEEL_SPEED_LIMIT)  # the latter never holds back a stop
        covered |= item is COMMAND_LOSS and schedules(scenario)[0].stops_alone
        if not covered and (own := item.bounded(scenario)) and own.hidden:
            yield f"{own.hidden} A stop may then take longer than filter.decel says. Leave it out."
    yield from _of_the_times(scenario, bound)
    if stated.odometry is not None:
        yield from _of_odometry(scenario, bound, stated.odometry)


def _of_odometry(scenario: Scenario, bound: Bound, stated: Pair) -> Iterator[str]:
    """Objections to velocities that are less exact than ``stated``, or not measured at one
    instant.
    """
    kick = kick_of_friction(scenario) * counts_on_rims(scenario)
    for axis, error in enumerate((bound.nbar[0] + kick, bound.nbar[1])):
        if error > stated[axis] * (1 + ROUNDING):
            yield (
                f"The sensors' velocity is off by up to {rounded(error, 4)} {UNITS[axis]}"
                f"{' with friction within plant steps' * (axis == 0 and kick > 0)}, and "
                f"filter.odometry[{axis + 1}] = {stated[axis]:g} {UNITS[axis]} is less. "
                "Raise it to that."
            )
    encoder = scenario.section(Encoder)
    if any(bound.window) or (encoder.counts and encoder.method == TIME):
        yield (
            "The sensors' velocity is a mean over some time (sensor.velocity_window, [encoder]), "
            "and the governor needs that of one instant. Leave out filter.odometry, which it "
            "does not need, or take a sensor without window."
        )
    if bound.age[0] != bound.age[1]:
        yield (
            f"sensor.velocity_age: one axis' velocity is {max(bound.age):g} s old and the other's "
            "is not (gyro.enabled), but the governor takes one age for both. Leave out "
            "filter.odometry, or one of the two sensors."
        )


def _within(value: float, ends: Pair) -> bool:
    return ends[0] * (1 - ROUNDING) <= value <= ends[1] * (1 + ROUNDING)


def _outside(name: str, value: float, unit: str, key: str, ends: Pair) -> str:
    return (
        f"{name} = {value:g}{f' {unit}' * (unit != '1')} is outside {key} = [{ends[0]:g}, "
        f"{ends[1]:g}], which must hold it. Widen the interval."
    )
