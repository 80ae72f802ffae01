"""The correction gain of the pose estimate, chosen by linear theory instead of by hand.

Between poses the estimate is dead-reckoned; each pose moves it by a share g of what it is off:

    b+ = (1 - g) b + g n,    b the estimate's error, n the pose's (m).

A small g averages the noise but forgets the first pose's error slowly, a large one the reverse.
The loop sees e + b; the covariance of (e, v, memory, b) over a run gives the ISE that noise adds.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import minimize_scalar

from wmr_ctrl.theory.linear.linearise import FORCES, Floats, on_reference
from wmr_ctrl.theory.linear.state_space import law_at, plant_at
from wmr_ctrl.world.scenario import Scenario


def pose_variance(scenario: Scenario) -> float:
    """Variance of a pose's error in x and in y [m^2]: uniform within +-pose_noise."""
    return scenario.sensor.pose_noise**2 / 3


def noise_ise(scenario: Scenario, law: str, gain: float) -> float:
    """Expected part of the position ISE [m^2 s] that pose errors make over the run, linearly."""
    step, show = _matrices(scenario, law)
    clock = scenario.clock
    every = max(1, round(scenario.sensor.pose_period / clock.control))
    move, weight = _between_poses(step, show, every)
    covariance, total = np.zeros_like(step), 0.0
    covariance[-2:, -2:] = pose_variance(scenario) * np.eye(2)
    for k in range(clock.samples // every):
        if k:
            covariance = _corrected(covariance, gain, pose_variance(scenario))
        total += float(np.trace(weight @ covariance))
        covariance = move @ covariance @ move.T
    return total * clock.control


def _between_poses(step: Floats, show: Floats, every: int) -> tuple[Floats, Floats]:
    """Matrix from one pose to the next, and the weight that sums position errors in between."""
    power, weight = np.eye(len(step)), np.zeros_like(step)
    for _ in range(every):
        weight += power.T @ show.T @ show @ power
        power = step @ power
    return power, weight


def best_gain(scenario: Scenario, law: str) -> float:
    """Correction gain in (0, 1] with the smallest expected ISE over the run."""
    best = minimize_scalar(
        lambda log_gain: noise_ise(scenario, law, math.exp(log_gain)),
        bounds=(math.log(2e-3), 0.0), method="bounded", options={"xatol": 1e-3},
    )  # fmt: skip
    return float(math.exp(best.x))


def _matrices(scenario: Scenario, law: str) -> tuple[Floats, Floats]:
    """Over one sample: (plant, memory, b) to the same, and to the position error (e1, e2).

    b is in the robot's frame, which turns with the reference.
    """
    point, period = on_reference(scenario, law), scenario.clock.control
    plant, acting = plant_at(scenario, point, period), law_at(scenario, law, point, period)
    n, m = plant.nstates, acting.nstates
    push = plant.B[:, [plant.input_labels.index(name) for name in FORCES]]
    seen = np.hstack((plant.C, np.zeros((5, m)), np.eye(5, 2)))
    memory = np.hstack((np.zeros((m, n)), np.eye(m), np.zeros((m, 2))))
    force = acting.D @ seen + acting.C @ memory
    moved = np.hstack((plant.A, np.zeros((n, m + 2)))) + push @ force
    remembered = acting.A @ memory + acting.B @ seen
    c, s = math.cos(-point.v_d[1] * period), math.sin(-point.v_d[1] * period)
    turned = np.hstack((np.zeros((2, n + m)), [[c, -s], [s, c]]))
    show = np.hstack((plant.C[:2], np.zeros((2, m + 2))))
    return np.vstack((moved, remembered, turned)), show


def _corrected(covariance: Floats, gain: float, variance: float) -> Floats:
    """After a pose: b keeps 1 - g of itself and takes g of the pose's error."""
    keep = np.eye(len(covariance))
    keep[-2:, -2:] *= 1 - gain
    after = keep @ covariance @ keep.T
    after[-2:, -2:] += gain**2 * variance * np.eye(2)
    return after
