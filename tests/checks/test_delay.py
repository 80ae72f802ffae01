"""Delay in the sampled linear loop: whole periods, parts of one, and what is said of it."""

import numpy as np
import pytest
import scipy.linalg

from tests.checks.asking import closed
from wmr_ctrl.theory.checks.radius import operating_points, radius
from wmr_ctrl.theory.checks.sampled_plant import Motion
from wmr_ctrl.theory.checks.stable_ranges import stable_periods

CIRCLE = np.array((0.2, 0.1))


def test_stable_periods_need_not_reach_down_to_zero(told, loop):
    """With its own gains prox bears a delay of 0.05 s at 0.1 s, though not at 0.05 s."""
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


@pytest.mark.parametrize("delay", [0.02, 0.05, 0.07])
def test_a_law_without_memory_is_followed_force_by_force(loop, delay):
    """The matrix moves error and velocity as forces do that each arrive when they are due."""
    late, period = loop("mb", {"clock.control": 0.02, "actuator.delay": delay}), 0.02
    matrix = closed(late, CIRCLE, period)
    gain = late.linear(late.on_reference(tuple(CIRCLE)), period).d
    rates, push, _, _ = late.around.rates(Motion((0.0, 0.0, 0.0), tuple(CIRCLE), tuple(CIRCLE)))
    tick = 0.01
    block = scipy.linalg.expm(np.block([[rates, push], [np.zeros((2, 7))]]) * tick)
    free, forced = block[:5, :5], block[:5, 5:]
    s, sent = np.array((1e-3, 2e-3, -1e-3, 1e-2, 3e-2)), []
    state = np.concatenate((s, np.zeros(len(matrix) - 5)))
    for k in range(12):
        sent.append(gain @ s)
        for j in range(2):
            due = int(np.floor(((2 * k + j) * tick - delay) / period + 1e-9))
            s = free @ s + forced @ (sent[due] if due >= 0 else np.zeros(2))
        state = matrix @ state
    assert state[:5] == pytest.approx(s, rel=1e-9)
