"""Spectral radius of the linear loop along the whole reference, and where it passes 1."""

import math
from collections.abc import Callable, Sequence
from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.world.references import reference_bounds, sample
from wmr_ctrl.world.scenario import Robot, Scenario

from .budget import spend
from .error_coordinates import Floats
from .loop import Loop
from .sampled_plant import Point
from .surroundings import DriveTimes

POINTS = 9
INSIDE = 0.99
SAME = 1e-6
"""Difference of velocities [m/s, rad/s] that is none."""

SHORTEST = 1e-4
"""Shortest period that is tried [s]."""
LONGEST = 10.0
"""Longest period that is tried [s]."""
RATIO = 1.15
"""Factor from one period to the next."""
MARGIN = 1e-9
"""A spectral radius this close to 1 is marginal: so is e2 while the reference stands still."""
RTOL = 1e-7
"""Relative tolerance of an edge of stability; four digits of it are printed."""
STRETCHES = 16
"""Number of stretches of constant velocity into which a reference's period is divided."""
GRAPH = 12.0
"""Work of making a loop's graph for another period, in evaluations."""


def largest_radius(
    loop: Loop, period: float, drives: DriveTimes | None = None, robot: Robot | None = None
) -> float:
    """Spectral radius per sample over a period of the reference, or the largest over its points.

    An aperiodic reference is replaced by several constant operating points, and so is the
    orientation if the plant depends on it, on a slope for example. ``drives`` and ``robot`` default
    to the scenario's; the law keeps its own model.  inf for periods so long that a command is not
    held until the next one.
    """
    if period > loop.longest * (1 + 10 * RTOL):
        return math.inf
    own, samples = loop, loop.around.samples_a_pose(period)
    if (loop := own.at_period(period)) is not own:
        spend(0, GRAPH)
    stretches = stretches_of(loop.scenario)

    def of(v_d: Floats, theta: float) -> Floats:
        at, learning = loop.resting(v_d, theta, period, robot), loop.learns
        if at is None:
            return np.full((1, 1), np.inf)
        return from_pose_to_pose(loop, at, period, drives=drives, robot=robot, learning=learning)

    def at(theta: float) -> float:
        if stretches is None:
            return max(radius(of(v_d, theta)) for v_d in operating_points(loop.scenario))
        each, shares, time = stretches
        counts = np.maximum(1, np.round(shares * time / (period * samples))).astype(int)
        return _of_product([of(v_d, theta) for v_d in each], counts)

    return max(at(theta) for theta in loop.around.headings) ** (1 / samples)


@np.errstate(over="ignore", invalid="ignore")  # what is not finite is no stable loop
def from_pose_to_pose(
    loop: Loop,
    at: Point,
    period: float,
    *,
    drives: DriveTimes | None = None,
    robot: Robot | None = None,
    learning: bool = False,
) -> Floats:
    """Matrix of the sampled loop from one pose to the next, near a point.

    A matrix that grows beyond the range of doubles is scaled down; at that size the number of poses
    makes no difference.
    """
    law = loop.linear(at, period, drives=drives, learning=learning)
    closed = partial(loop.closed, at, period, drives=drives, robot=robot, law=law)
    samples, pose = loop.around.samples_a_pose(period), closed()
    if samples == 1:
        return pose
    none = closed(sample=samples + 1)
    whole = np.linalg.matrix_power(none, samples - 1) @ pose
    if np.isfinite(whole).all() or not np.isfinite(none).all():
        return whole
    return np.eye(len(none)) * min(radius(none) ** samples, np.finfo(float).max)


def only_forwards(loop: Loop) -> float:
    """The reference's least v1_d [m/s] if errors decay forwards but not backwards; else 0.0."""
    period, slowest = loop.scenario.clock.control, reference_bounds(loop.scenario)[0]

    def fades(v1_d: float) -> bool:
        there = loop.on_reference(np.array((v1_d, 0.0)))
        return radius(from_pose_to_pose(loop, there, period)) < 1 - MARGIN

    return slowest if slowest < -SAME and fades(-slowest) and not fades(slowest) else 0.0


def radius(matrix: Floats) -> float:
    """Spectral radius; inf if the law has no derivative there."""
    spend(len(matrix))
    if not np.isfinite(matrix).all():
        return math.inf
    return float(np.abs(np.linalg.eigvals(matrix)).max()) if matrix.size else 0.0


def _of_product(matrices: Sequence[Floats], counts: NDArray[np.intp]) -> float:
    """Spectral radius, per factor, of a product of matrix powers with exponents ``counts``.

    A product that becomes very large or small is scaled on the way.
    """
    if not all(np.isfinite(matrix).all() for matrix in matrices):
        return math.inf
    total, scale = np.eye(len(matrices[0])), 0.0
    for matrix, count in zip(matrices, counts, strict=True):
        size = max(radius(matrix), 1e-3)
        spend(len(matrix))
        power = np.linalg.matrix_power(matrix / size, int(count))
        total = power @ total
        norm = float(np.linalg.norm(total)) or 1.0
        total, scale = total / norm, scale + count * math.log(size) + math.log(norm)
    own = radius(total)
    return math.exp((math.log(own) + scale) / int(counts.sum())) if own > 0 else 0.0


@lru_cache(maxsize=64)
def stretches_of(scenario: Scenario) -> tuple[list[Floats], Floats, float] | None:
    """Desired velocities (2) over one period of the reference, their shares of it, and the period.

    The period is in s.  Equal neighbours are merged; None if the velocities are constant or do not
    repeat.
    """
    cycle = scenario.reference.cycle
    if not math.isfinite(cycle) or scenario.reference.arrival is not None:
        return None
    middles = (np.arange(STRETCHES) + 0.5) * cycle / STRETCHES
    rows = sample(scenario, np.concatenate((middles, middles + cycle)))[:, 3:5]
    if np.abs(rows[STRETCHES:] - rows[:STRETCHES]).max() > SAME:
        return None
    bound = INSIDE * np.array(scenario.limits.v_u2)
    speeds = np.clip(rows[:STRETCHES], -bound, bound).round(9)
    starts = np.flatnonzero((np.diff(speeds, axis=0, prepend=np.inf) != 0).any(axis=1))
    shares = np.diff(np.append(starts, STRETCHES)) / STRETCHES
    return [speeds[i] for i in starts], shares, cycle


@lru_cache(maxsize=64)
def operating_points(scenario: Scenario) -> list[Floats]:
    """Desired velocities (2) of some points of the reference, moved inside v_u2."""
    end = min(scenario.clock.duration, scenario.reference.cycle)
    speeds = sample(scenario, np.linspace(0, end, POINTS))[:, 3:5]
    bound = INSIDE * np.array(scenario.limits.v_u2)
    return list(np.unique(np.clip(speeds, -bound, bound).round(9), axis=0))


def supremum(
    of: Callable[[float], float], shortest: float = SHORTEST, ratio: float = RATIO
) -> float:
    """Largest period up to which the spectral radius ``of(period)`` is at most 1."""
    below, period = 0.0, shortest
    while of(period) <= 1 + MARGIN:
        if period >= LONGEST:
            return math.inf
        below, period = period, period * ratio
    return edge(of, below, period) if below else 0.0


def edge(of: Callable[[float], float], stable: float, unstable: float) -> float:
    """The last stable value between ``stable`` and ``unstable``, by the spectral radius ``of``.

    It is the limit of the whole range if ``of`` crosses 1 once in it.
    """
    from scipy.optimize import brentq  # slow to import, and not needed for most verdicts

    kept = [stable]

    def excess(value: float) -> float:
        above = min(of(value) - 1 - MARGIN, 1.0)  # brentq interpolates no infinity
        if above <= 0:
            kept.append(value)
        return above

    brentq(excess, stable, unstable, xtol=RTOL * max(stable, unstable))
    return min(kept, key=lambda value: abs(value - unstable))
