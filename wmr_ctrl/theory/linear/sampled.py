"""Sampled data: spectral radius against the control period, and the largest period that is safe.

The limits without learning are those of the warnings before a run (`wmr_ctrl.theory.checks`); this
module adds the loops whose weights move, and one-step safety at the barrier: the longest hold that
cannot cross either limit.
"""

from collections.abc import Callable, Iterable

import numpy as np

from wmr_ctrl.control.laws.nn import NetworkGains
from wmr_ctrl.control.outside import check_takes_torques
from wmr_ctrl.core.fields.arguments import checks_arguments
from wmr_ctrl.theory.checks.loop import PERIOD, Loop
from wmr_ctrl.theory.checks.network import largest_square, square_bound
from wmr_ctrl.theory.checks.radius import from_pose_to_pose, radius, supremum
from wmr_ctrl.theory.checks.sample_time import kink_limits
from wmr_ctrl.theory.checks.stable_ranges import largest_stable_period as largest_stable_period
from wmr_ctrl.theory.checks.stable_ranges import shortest_tried
from wmr_ctrl.world.phases import drag
from wmr_ctrl.world.scenario import Scenario

from .linearise import (
    Floats,
    Point,
    check_axis,
    check_period,
    law_loop,
    on_reference,
)
from .state_space import is_learning

SPEEDS = 2001
"""Velocities of an axis at which the time to its limit is looked at."""


@checks_arguments
def spectral_radius(
    scenario: Scenario,
    law: str,
    periods: Iterable[float],
    point: Point | None = None,
    memory: str = "frozen",
) -> Floats:
    """Spectral radius of the sampled closed loop for each control period [s]: stable below 1."""
    of = radius_of(scenario, law, point, memory)
    return np.array([of(float(period)) for period in periods])


def radius_of(
    scenario: Scenario, law: str, point: Point | None = None, memory: str = "frozen"
) -> Callable[[float], float]:
    """Function that gives the spectral radius per sample for a period [s], at ``point``.

    ``point`` defaults to the one on the reference.
    """
    at = on_reference(scenario, law) if point is None else point

    loop, learning = law_loop(scenario, law), is_learning(memory)

    def of(period: float) -> float:
        check_period(period, "A loop is sampled with each of the periods.")
        matrix = from_pose_to_pose(loop, at, period, learning=learning)
        return float(radius(matrix) ** (1 / loop.around.samples_a_pose(period)))

    return of


@checks_arguments
def largest_learning_period(scenario: Scenario, law: str, point: Point | None = None) -> float:
    """Supremum of the stable periods [s] with moving weights and estimates; 0.0 if there is none.

    Linearised at ``point`` (default: on the reference with the start's weights); inf if every
    period up to 10 s is stable.
    """
    loop = law_loop(scenario, law)
    return supremum(radius_of(scenario, law, point, "learning"), shortest_tried(loop))


@checks_arguments
def regressor_square(scenario: Scenario) -> tuple[float, Floats]:
    """Largest |S|^2 of nn's network over the reference, and its stability limit for each axis (2).

    Above the limit learning is unstable in continuous time, if the leak is neglected; inf if never.
    """
    loop = law_loop(scenario, "nn")
    bounds = np.array([square_bound(loop, axis) for axis in (0, 1)])
    return largest_square(loop, loop.setup.own(NetworkGains).eta), bounds


@checks_arguments
def kink_periods(scenario: Scenario, law: str) -> Floats | None:
    """Longest stable period (2) [s] at v = v_u2 with v_c0 beyond it; None without a barrier.

    At the kink the rate of the velocity loop is rho instead of rho/2, so the limit is 2/rho for mb.
    inf for a law that adapts its gains so that no period is too long.
    """
    loop = law_loop(scenario, law)
    if not loop.has_barrier or loop.setup.takes_velocity:
        return None
    return _for_own_period(loop, lambda period: kink_limits(loop, period))


def _for_own_period(loop: Loop, limit: Callable[[float], Floats]) -> Floats:
    """Limits (2) [s] on the period that are valid when the law runs at that very period.

    If the law's force does not depend on the period, this is ``limit`` of any period.
    """
    if not loop.uses(PERIOD):
        return limit(loop.scenario.clock.control)

    def share(axis: int) -> Callable[[float], float]:
        return lambda period: period / float(limit(period)[axis])

    return np.array([supremum(share(axis), shortest=1e-3, ratio=2.0) for axis in (0, 1)])


@checks_arguments
def one_step_period(scenario: Scenario, law: str, v_c0: Floats | None = None) -> Floats | None:
    """Longest period (2) [s] in which no |v| < v_u1 can cross the limit, for constant v_c0 (2).

    It is the minimum over v on each axis; v_c0 defaults to the start's.  Friction is assumed to be
    compensated.  None for a law without a barrier, inf if no hold is too long.
    """
    loop = law_loop(scenario, law)
    if not loop.has_barrier or loop.setup.takes_velocity:
        return None
    asked = loop.start.v_c0 if v_c0 is None else np.asarray(v_c0, dtype=float)

    def limit(period: float) -> Floats:
        return np.array([_shortest(scenario, law, axis, asked, period) for axis in range(2)])

    return _for_own_period(loop, limit)


def _shortest(scenario: Scenario, law: str, axis: int, v_c0: Floats, period: float) -> float:
    pull, u1 = pull_of(scenario, law, axis, v_c0, period), scenario.limits.v_u1[axis]
    mass = (scenario.robot.m, scenario.robot.I)[axis]

    def crossing(v: Floats) -> Floats:
        """Time to reach the limit in the force's direction, at the present acceleration."""
        acceleration = pull(v) / mass
        room: Floats = u1 - np.copysign(1.0, acceleration) * v
        return room / np.maximum(np.abs(acceleration), 1e-300)

    inside, u2 = u1 * (1 - 1e-6), scenario.limits.v_u2[axis]
    sides = [sign * u2 + side * 1e-12 * u1 for sign in (-1, 1) for side in (-1, 0, 1)]  # kinks
    return float(crossing(np.append(np.linspace(-inside, inside, SPEEDS), sides)).min())


def pull_of(
    scenario: Scenario, law: str, axis: int, v_c0: Floats, period: float | None = None
) -> Callable[[float | Floats], Floats]:
    """Force [N] or moment [N m] of ``axis`` (0, 1) over its velocity, without friction
    compensation.

    ``v_c0`` (2) is constant; the other axis is at its own v_c0.  The friction that the law models
    is subtracted, so that with a correct model the barrier's own pull remains.  The law runs at
    ``period`` [s], by default the scenario's.
    """
    check_takes_torques(scenario, "forces of a barrier are computed")
    loop = law_loop(scenario, law)
    compensated = 1.0 if loop.uses("model.mu") else 0.0

    def pull(v: float | Floats) -> Floats:
        speeds = np.tile(np.asarray(v_c0, float)[:, None], (1, np.size(v)))
        speeds[axis] = v
        own = loop.force_towards(speeds, v_c0, period)[axis]
        own = own - compensated * drag(scenario.believed, speeds)[axis]
        return own if np.ndim(v) else own[0]

    return pull


@checks_arguments
def pull_curve(scenario: Scenario, law: str, axis: int, v_c0: float, speeds: Floats) -> Floats:
    """Force [N] or moment [N m] of the law at ``speeds`` (N,), less its friction term."""
    check_axis(axis)
    asked = np.zeros(2)
    asked[axis] = v_c0
    return np.asarray(pull_of(scenario, law, axis, asked)(speeds))
