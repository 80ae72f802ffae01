"""Delay in the sampled linear loop: whole periods, fractions of one, and its warnings."""

import numpy as np

from tests.checks.asking import closed
from wmr_ctrl.theory.checks.radius import operating_points, radius
from wmr_ctrl.theory.checks.stable_ranges import stable_periods

CIRCLE = np.array((0.2, 0.1))


def test_stable_periods_need_not_reach_down_to_zero(told, loop):
    """prox with its own gains tolerates a delay of 0.05 s at a period of 0.1 s, but not 0.05 s."""
    late = {"clock.control": 0.1, "actuator.delay": 0.05}
    low, high = stable_periods(at := loop("prox", late))

    assert told("prox", late, "paper-simulation", key="clock.control") == []
    assert 0.05 < low < 0.1 < high
    for period, stable in (
        (0.99 * low, False),
        (1.01 * low, True),
        (0.99 * high, True),
        (1.01 * high, False),
    ):
        assert (_worst(at, period) < 1) is stable


def _worst(at, period):
    """Largest spectral radius over the points of the reference."""
    points = operating_points(at.scenario)
    return max(radius(closed(at, v_d, period)) for v_d in points)
