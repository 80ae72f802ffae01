"""How long may the control period be: the linear loop, the barrier's kink, the first step.

The linear loop is sampled with an exact zero-order hold.  Its state: e (3) and v (2) of the robot,
Eqs. (33)-(35) and (4), linearised on the reference with v_d held constant; the torque's lag and the
commands under way where the drives have lag and delay; the law's memory where it is dynamic.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import lru_cache

import casadi as ca
import numpy as np

from wmr_ctrl.checks.loop import PERIOD, Floats, Loop
from wmr_ctrl.checks.supremum import SHORTEST, supremum
from wmr_ctrl.checks.warning import SPEEDS, UNITS, Warning, joined
from wmr_ctrl.control.controller import controller
from wmr_ctrl.control.setup import settle
from wmr_ctrl.model.dynamics import acceleration, friction, reduced_mass
from wmr_ctrl.model.plant import plant, rk4_step
from wmr_ctrl.model.system import System
from wmr_ctrl.model.tracking import error_rate
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.world.effect import EffectRole
from wmr_ctrl.world.references import sample

SAFE = 0.5
"""Share of a stability limit that the remedies propose."""

MOST_UNDER_WAY = 40
"""Commands that the shortest period that is tried leaves under way in a delay."""

POINTS = 9
INSIDE = 0.99
MOST_STEPS = 500


def sample_time(loop: Loop) -> Iterator[Warning]:
    """Yield what the control period breaks, each with its number."""
    yield from _linear(loop)
    if loop.has_barrier and not loop.guarded:
        yield from _kink(loop)
    inside = (np.abs(loop.start.v) <= loop.scenario.limits.v_u1).all()
    if inside and not loop.setup.with_role(EffectRole.DRIVE):
        yield from _first_step(loop)


def kink_limits(loop: Loop) -> Floats:
    """Longest period (2) [s] that is stable at the barrier's kink, |v| = v_u2 with v_c0 beyond it.

    There the force pulls towards v_u2 with its full slope, twice that of the linear loop, so a
    period below 2 M1/slope is needed: 2/rho for the model-based law.
    """
    u1, u2 = (np.array(limit) for limit in (loop.scenario.limits.v_u1, loop.scenario.limits.v_u2))
    slope = -loop.slope_towards(u2, u2 + 0.5 / (u1 - u2))
    mass = np.array((loop.scenario.robot.m, loop.scenario.robot.I))
    return np.asarray(2 * mass / np.maximum(slope, 1e-300))


def _linear(loop: Loop) -> Iterator[Warning]:
    period, limit = loop.scenario.clock.control, largest_period(loop)
    drives = _drives(loop)
    late = "".join(f"a {word} of {value:g} s and " for word, value in drives.items())
    if limit == 0:
        lower = f"the drives' {' and '.join(drives)} or its gains" if late else "its gains"
        yield Warning(
            PERIOD,
            f"{loop.law} is unstable around the reference with {late}these gains, whatever "
            f"clock.control is (tried from {shortest_tried(loop):g} s up): lower {lower}.",
            f"{loop.equations}, linearised",
        )
    elif period >= limit:
        yield Warning(
            PERIOD,
            f"clock.control = {period:g} s is above {limit:.4g} s, the longest period for which "
            f"{loop.law} is stable around the reference with {late}these gains: choose "
            f"{SAFE * limit:.2g} s or less, or lower the gains.",
            f"{loop.equations}, linearised and sampled",
        )


def _kink(loop: Loop) -> Iterator[Warning]:
    period, limits = loop.scenario.clock.control, kink_limits(loop)
    if (period >= limits).any():
        pairs = zip(SPEEDS, limits, strict=True)
        named = joined(f"{limit:.4g} s for {name}" for name, limit in pairs)
        yield Warning(
            PERIOD,
            f"clock.control = {period:g} s is too long for {loop.law} where the barrier sets in, "
            f"at v_u2 (the bounds are {named}): while the error is large the velocity swings about "
            f"v_u2 and may leave the limit. Choose {SAFE * min(limits):.2g} s or less.",
            "Eqs. (9)-(15), kink at v_u2",
        )


def _first_step(loop: Loop) -> Iterator[Warning]:
    period, limits = loop.scenario.clock.control, np.array(loop.scenario.limits.v_u1)
    reached, outer = first_speeds(loop), "(7), " if loop.traits.auxiliary else ""
    axes = np.flatnonzero(reached > limits)
    if axes.size:
        named = joined(
            f"{SPEEDS[i]} to {reached[i]:.3g} {UNITS[i]} (limit {limits[i]:g})" for i in axes
        )
        yield Warning(
            PERIOD,
            f"The first torque of {loop.law}, held for clock.control = {period:g} s, takes "
            f"{named}: the limit is broken before the second sample. Shorten clock.control, or "
            "start nearer to the reference.",
            f"Eqs. (4), {outer}one held step",
        )


def largest_stable_period(scenario: Scenario, law: str) -> float:
    """Supremum of the periods [s] up to which the sampled linear loop is stable.

    The smallest over points of the reference; 0.0 if no period is stable, inf if all that were
    tried (up to 10 s) are.  Raises UnknownNameError for a law.
    """
    return largest_period(Loop(settle(scenario, law)))


def largest_period(loop: Loop) -> float:
    """The same for a Loop that is at hand."""
    shortest = shortest_tried(loop)
    return min(supremum(_radius_at(loop, v_d), shortest) for v_d in operating_points(loop.scenario))


def shortest_tried(loop: Loop) -> float:
    """The shortest period that is tried [s]: so many commands may be under way, and no more."""
    return max(SHORTEST, loop.scenario.actuator.delay / MOST_UNDER_WAY)


def _drives(loop: Loop) -> dict[str, float]:
    """How late the drives are [s], by word."""
    actuator = loop.scenario.actuator
    words = {"delay": actuator.delay, "lag": actuator.lag}
    return {word: value for word, value in words.items() if value}


def operating_points(scenario: Scenario) -> list[Floats]:
    """Desired velocities (2) of some points of the reference, moved inside v_u2."""
    end = min(scenario.clock.duration, scenario.reference.cycle)
    speeds = sample(scenario, np.linspace(0, end, POINTS))[:, 3:5]
    bound = INSIDE * np.array(scenario.limits.v_u2)
    return list(np.unique(np.clip(speeds, -bound, bound).round(9), axis=0))


def closed_loop(loop: Loop, v_d: Floats, period: float) -> Floats:
    """Matrix that takes the loop's state from one sample to the next.

    The state: error and velocity (5), the lag's force (2) if there is one, the law's memory, then
    the forces that are under way with a delay, the latest first.
    """
    rates, push = linear_plant(loop.scenario, tuple(v_d))
    whole, part = divmod(loop.scenario.actuator.delay, period)
    gain, sent = loop.feedback(v_d, period), int(whole) + bool(part)
    lag, memory = len(rates) - 5, gain.shape[1] - 5
    by_state, by_memory = gain[:, :5], gain[:, 5:]
    gains = np.hstack((by_state, np.zeros((len(gain), lag)), by_memory))
    gains = np.hstack((gains, np.zeros((len(gain), 2 * sent))))
    queue = np.eye(2 * (sent + 1), gains.shape[1], gains.shape[1] - 2 * sent)
    forces = np.vstack((gains[:2], queue[: 2 * sent]))
    free, now, before = _delayed_hold(rates, push, period, part)
    moved = np.hstack((free, np.zeros((len(free), memory + 2 * sent))))
    arriving = 2 * int(whole)
    moved = moved + now @ forces[arriving : arriving + 2]
    if part:
        moved = moved + before @ forces[arriving + 2 : arriving + 4]
    return np.vstack((moved, gains[2:], forces[: 2 * sent]))


def _delayed_hold(
    rates: Floats, push: Floats, period: float, part: float
) -> tuple[Floats, Floats, Floats]:
    """Over a period: free motion, by the force from ``part`` [s] on, and by the one before it."""
    free, _ = zero_order_hold(rates, push, period)
    rest, now = zero_order_hold(rates, push, period - part)
    _, early = zero_order_hold(rates, push, part)
    return free, now, rest @ early


def zero_order_hold(rates: Floats, push: Floats, period: float) -> tuple[Floats, Floats]:
    """Exact matrices of x(t + period) = free x + forced u for x' = rates x + push u, u held."""
    size, inputs = push.shape
    block = np.zeros((size + inputs, size + inputs))
    block[:size, :size], block[:size, size:] = rates, push
    whole = exponential(block * period)
    return whole[:size, :size], whole[:size, size:]


def exponential(matrix: Floats) -> Floats:
    """Matrix exponential by its series after halving the argument to a norm of at most 1/2."""
    norm = float(np.linalg.norm(matrix, 1))
    halvings = max(0, math.ceil(math.log2(norm)) + 1) if norm > 0 else 0
    scaled, term = matrix / 2.0**halvings, np.eye(len(matrix))
    total = term.copy()
    for order in range(1, 16):
        term = term @ scaled / order
        total += term
    for _ in range(halvings):
        total = total @ total
    return total


@lru_cache(maxsize=256)
def linear_plant(scenario: Scenario, v_d: tuple[float, ...]) -> tuple[Floats, Floats]:
    """Rates' gradients by (e, v) and, with a lag, by the acting force; and by the force."""
    robot, lag = scenario.robot, scenario.actuator.lag
    s, force = ca.SX.sym("s", 5), ca.SX.sym("force", 2)
    drag = friction(ca.SX(robot.mu), ca.SX(robot.m), ca.SX(robot.g), ca.SX(robot.v_s), s[3:])
    speeding = acceleration(reduced_mass(ca.SX(robot.m), ca.SX(robot.I)), force, drag)
    rate = ca.vertcat(error_rate(s[:3], s[3:], ca.SX(ca.DM(v_d))), speeding)
    gradient = ca.Function("plant", [s, force], [ca.jacobian(rate, s), ca.jacobian(rate, force)])
    rates, push = (np.asarray(item) for item in gradient(ca.DM([0, 0, 0, *v_d]), 0))
    return _behind_lag(rates, push, lag) if lag > 0 else (rates, push)


def _behind_lag(rates: Floats, push: Floats, lag: float) -> tuple[Floats, Floats]:
    """The plant behind a first-order lag [s] of the force, which becomes part of the state."""
    decay = np.eye(2) / lag
    whole = np.block([[rates, push], [np.zeros((2, len(rates))), -decay]])
    return whole, np.vstack((np.zeros_like(push), decay))


def _radius_at(loop: Loop, v_d: Floats) -> Callable[[float], float]:
    return lambda period: float(np.abs(np.linalg.eigvals(closed_loop(loop, v_d, period))).max())


def first_speeds(loop: Loop) -> Floats:
    """Largest |v1| [m/s] and |omega| [rad/s] while the first torque is held, drives ideal."""
    scenario, robot = loop.scenario, plant(loop.scenario)
    torque = first_torque(loop)
    inputs = np.concatenate((torque, np.zeros(robot.u.numel() - torque.size)))
    steps = min(scenario.clock.substeps, MOST_STEPS)
    step = robot.function("step", [rk4_step(robot, ca.SX(scenario.clock.control / steps))])
    state, largest = np.array(robot.x0), np.abs(loop.start.v)
    for _ in range(steps):
        state = np.asarray(step(inputs, state, robot.p0)).ravel()
        largest = np.maximum(largest, np.abs(state[3:]))
    return largest


def first_torque(loop: Loop) -> Floats:
    """Torques (right, left) [N m] of the first sample, within the wheels' limit."""
    law = controller(loop.setup)
    first = law.function("first", [law.y])
    return np.asarray(first(_first_inputs(loop, law), law.x0, law.p0)).ravel()


def _first_inputs(loop: Loop, law: System) -> list[float]:
    start, initial = loop.start, loop.scenario.initial
    numbers = (*start.reference, *initial.pose, *initial.velocity)
    sizes = sum(port.signal.size for port in law.inputs)
    return [*numbers, *(0.0 for _ in range(sizes - len(numbers)))]
