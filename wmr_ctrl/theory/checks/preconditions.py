"""Unmet preconditions on units, start, reference, gains, drives and noise."""

import math
from collections.abc import Iterator

import numpy as np

from wmr_ctrl.control.filter.held_loop import STABLE
from wmr_ctrl.control.laws.law import WHOLE
from wmr_ctrl.results.verdicts import Warning
from wmr_ctrl.world.phases import phases, steepness
from wmr_ctrl.world.references import reference_bounds
from wmr_ctrl.world.references.kind import reference_spans
from wmr_ctrl.world.scenario import unit_questions

from .loop import Loop
from .warning import FORCE_UNITS, SPEEDS, UNITS, joined
from .wrong_model import largest_pull

REACHED = 4.0
"""Standard deviations that noise passes about once in a run of 80 s at 10 ms, by either wheel."""
STANDSTILL = 1e-9
"""Desired speed [m/s] that counts as none."""
LIMIT = "limits.v_u1"
ROUNDED = 1e-9
"""Share of a limit that a desired speed may miss by rounding."""
COARSE = 1.0
"""Plant step times slope of the friction that is coarse for RK4."""


def units(loop: Loop) -> Iterator[Warning]:
    """Yield every value that is unusual in its unit, with the unit that was perhaps meant."""
    for key, question in unit_questions(loop.scenario):
        yield Warning(key, question, "units, docs/reference/scenario.md")


def start(loop: Loop) -> Iterator[Warning]:
    """Yield a start outside or at the limit, and a law that ignores such a start."""
    limits = loop.scenario.limits
    back = "only the guard brings it back" if loop.guarded else "nothing certainly brings it back"
    beyond = limits.excess(loop.start.v.tolist())
    for axis, (v, u1) in enumerate(zip(loop.start.v, limits.v_u1, strict=True)):
        named = f"initial.velocity[{axis + 1}] = {v:.9g} {UNITS[axis]}"
        place, most = limits.side(axis, v)
        if beyond[axis] > 0:
            yield Warning(
                "initial.velocity",
                f"{named} is outside {place} = {most:g}: the run begins with a violation, no "
                f"guarantee holds there, and {back}. Start inside the limit.",
                LIMIT,
            )
        elif loop.traits.barrier and abs(v) > u1 - limits.clip:
            yield Warning(
                "initial.velocity",
                f"{named} is within limits.clip = {limits.clip:g} of limits.v_u1[{axis + 1}] = "
                f"{u1:g}, where the barrier is cut off and nearly powerless. Start further inside.",
                "Eq. (15)",
            )
    filtered = loop.setup.takes_velocity and loop.scenario.filter.kind != "none"
    if loop.traits.auxiliary and not (loop.guarded or filtered or loop.uses("limits.")):
        yield from _blind(loop)


def _blind(loop: Loop) -> Iterator[Warning]:
    limits, asked = np.array(loop.scenario.limits.v_u1), np.abs(loop.start.v_c0)
    axes = np.flatnonzero(asked > limits)
    if axes.size:
        named = joined(
            f"|{SPEEDS[i]}| = {asked[i]:.3g} {UNITS[i]} (limit {limits[i]:g})" for i in axes
        )
        means = "set a filter.kind" if loop.setup.takes_velocity else "switch the guard on"
        yield Warning(
            "law",
            f"{loop.law} does not know the velocity limit, and at the start the kinematic loop "
            f"asks for {named}: expect violations. Choose a law that knows the limit, such as mb "
            f"or nn, {means}, or start nearer.",
            "Eq. (7)",
        )


def preconditions(loop: Loop) -> Iterator[Warning]:
    """Yield each violated condition among 0 < v1_d < v_u2[1], |v2_d| < v_u2[2], k_2 >= 1.

    A law without a barrier need only stay below v_u1; a law without Eq. (7) has no further
    conditions.
    """
    slowest, fastest, turning = reference_bounds(loop.scenario)
    if loop.traits.auxiliary and slowest <= STANDSTILL:
        yield _not_moving(loop, slowest)
    yield from _too_fast(loop, fastest)
    end = "the robot may not turn that fast and falls behind, or leaves the limit"
    if loop.has_barrier:
        end = "the angle e3 falls behind and can wind up by whole turns"
    yield from _beyond(loop, 1, f"|v2_d| of the reference reaches {turning:.4g}", turning, end)
    yield from _against_a_side(loop)
    k2 = loop.setup.kinematics.k[1]
    if loop.traits.auxiliary and k2 < 1:
        proof = f"proof of Theorem {loop.traits.theorem}" if loop.traits.theorem else "proof"
        yield Warning(
            loop.setup.kinematic_key,
            f"{loop.setup.kinematic_key}[2] = {k2:g} is below 1, but the {proof} that the path "
            "error vanishes needs at least 1: raise it.",
            "Eq. (42)",
            objects=False,
        )


def _basis(loop: Loop) -> str:
    """Source of the conditions on the reference."""
    theorem = f"Theorem {loop.traits.theorem}, " if loop.traits.theorem else ""
    return f"{theorem}Eq. (7)" if loop.traits.auxiliary else LIMIT


def _too_fast(loop: Loop, fastest: float) -> Iterator[Warning]:
    limit, threshold = loop.scenario.limits.v_u1[0], loop.scenario.limits.v_u2[0]
    end = "the robot may not drive that fast and falls behind, or leaves the limit"
    if loop.has_barrier and threshold <= fastest < limit:
        lag = 1 / (limit - fastest) / loop.setup.kinematics.k[0]
        end = f"the barrier leaves the robot about {lag:.2g} m behind on a straight line"
    yield from _beyond(loop, 0, f"v1_d of the reference reaches {fastest:.4g}", fastest, end)


def _beyond(loop: Loop, axis: int, what: str, value: float, end: str) -> Iterator[Warning]:
    """Yield a reference speed not below the largest that the law can keep: v_u2, or v_u1."""
    limits, unit = loop.scenario.limits, UNITS[axis]
    limit, name = limits.v_u1[axis], f"v_u1[{axis + 1}]"
    bound, raised = f"limits.{name} = {limit:g} {unit}", f"limits.{name}"
    if loop.has_barrier:
        raised = f"v_u2[{axis + 1}]"
        bound = f"limits.{raised} = {limits.v_u2[axis]:g} {unit} ({name} = {limit:g})"
    if value >= (limits.v_u2 if loop.has_barrier else limits.v_u1)[axis]:
        yield Warning(
            "reference",
            f"{what} {unit}, not below {bound}: {end}. Ask for a slower "
            f"{'or wider ' * axis}reference, or raise {raised}.",
            _basis(loop),
        )


def _against_a_side(loop: Loop) -> Iterator[Warning]:
    """Yield a desired motion that exceeds the limit of its direction."""
    limits = loop.scenario.limits
    for axis, span in enumerate(reference_spans(loop.scenario) if limits.apart else ()):
        for asked, way in zip(span, (-1, 1), strict=True):
            key, limit = limits.side(axis, way)
            if way * asked > max(STANDSTILL, way * limit * (1 - ROUNDED)):
                yield Warning(
                    "reference",
                    f"v{axis + 1}_d of the reference reaches {asked:.4g} {UNITS[axis]}, not within "
                    f"{key} = {limit:g} {UNITS[axis]}: the robot may not move like that and falls "
                    f"behind. Ask for another reference, or allow more by {key}.",
                    LIMIT,
                )


def _not_moving(loop: Loop, slowest: float) -> Warning:
    what = (
        f"falls to {slowest:.4g} m/s, that is backwards"
        if slowest < -STANDSTILL
        else "falls to 0, and while it stands still nothing steers the sideways error e2"
    )
    asking = "the theorems ask" if loop.traits.theorem else "convergence is known only"
    remedy = "Ask for a reference that keeps moving forwards."
    if loop.scenario.reference.arrival is not None:
        remedy = (
            "It begins and ends at rest by design; a run shows whether the robot arrives (arrival)."
        )
    return Warning(
        "reference",
        f"v1_d of the reference {what}: {asking} for v1_d > 0 and no convergence is promised "
        f"otherwise. {remedy}",
        _basis(loop),
        objects=slowest < -STANDSTILL,
    )


def late_drives(loop: Loop) -> Iterator[Warning]:
    """Yield a delay of a sample or more, or a prediction beyond the shortest command delay."""
    stated, bound = loop.setup.prediction, loop.setup.bound
    true = bound.delay - bound.jitter
    if stated and stated > true * (1 + WHOLE):
        yield Warning(
            f"gains.{loop.law}.delay",
            f"gains.{loop.law}.delay = {stated:g} s is longer than {true:g} s, the shortest delay "
            "of a command: the law then predicts with commands that have already ended, and can "
            "cycle. State the shortest possible delay, or 0; the guard's (actuator.delay) is the "
            "longest.",
            "prediction of the law",
        )
    elif not stated and loop.scenario.actuator.delay >= loop.scenario.clock.control:
        yield _late(loop)


def _late(loop: Loop) -> Warning:
    held = loop.guarded and not loop.setup.void
    promise = "The guard still keeps the limits, but not the path. " if held else ""
    cost = (
        "the theorems assume that the torque acts at once, and at 10 ms a single period of delay "
        "breaks mb"
        if loop.traits.theorem
        else "what is computed from one sample acts only after the next one"
    )
    return Warning(
        "actuator.delay",
        f"actuator.delay = {loop.scenario.actuator.delay:g} s is a whole control period or more; "
        f"{cost}. {promise}Lower the gains, or shorten both clock.control and the delay.",
        f"Theorem {loop.traits.theorem}" if loop.traits.theorem else "Eq. (4)",
        objects=bool(loop.traits.theorem),
    )


def noise(loop: Loop) -> Iterator[Warning]:
    """Yield torque noise that the barrier may not withstand, for the weakest axis."""
    disturbance, robot = loop.scenario.disturbance, loop.scenario.robot
    if disturbance.std == 0 or loop.guarded or not loop.has_barrier:
        return
    push = math.sqrt(2) * disturbance.std / robot.r * np.array((1.0, robot.l))
    pull = np.maximum(largest_pull(loop, next(phases(loop.scenario))), 0)
    axis = int(np.argmin(pull / push))
    truncate, unit = disturbance.truncate, FORCE_UNITS[axis]
    bound = "unbounded" if math.isinf(truncate) else f"cut at {truncate:g} times that"
    cover = "is covered by no theorem: at" if loop.traits.theorem else "acts against the limit: at"
    yield Warning(
        "disturbance.std",
        f"The torque noise ({disturbance.std:g} N m rms, {bound}) {cover} the start it pushes "
        f"{SPEEDS[axis]} with {push[axis]:.3g} {unit} rms, and the barrier of {loop.law} pulls "
        f"back with at most {pull[axis]:.3g} {unit}. It is not certain that the limit is kept: try "
        "several seeds, start nearer, or switch the guard on.",
        f"Theorem {loop.traits.theorem}" if loop.traits.theorem else "Eqs. (4), (15)",
        objects=bool(pull[axis] < min(truncate, REACHED) * push[axis]),
    )


def coarse_step(loop: Loop) -> Iterator[Warning]:
    """Yield a plant step that is long for mu m g tanh(v1/v_s) at rest, where it is steepest."""
    step, robots = loop.scenario.clock.plant, [item.robot for item in phases(loop.scenario)]
    slope = max(steepness(robot) / robot.m for robot in robots)
    if step * slope <= COARSE:
        return
    yield Warning(
        "clock.plant",
        f"clock.plant = {step:g} s is too coarse for the friction: mu g tanh(v1/v_s) changes at up "
        f"to {slope:.4g} 1/s, and the product of both, {step * slope:.3g}, should be at most "
        f"{COARSE:g} (RK4 diverges from {STABLE:g} on). Choose {COARSE / slope:.2g} s or less, "
        "or a larger robot.v_s.",
        "Eq. (4), RK4",
    )
