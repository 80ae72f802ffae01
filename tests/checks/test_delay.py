"""Delay in the sampled linear loop: whole periods, parts of one, and what is said of it."""

from __future__ import annotations

import numpy as np
import pytest

from wmr_ctrl.api import simulate
from wmr_ctrl.checks.sample_time import closed_loop, largest_period, linear_plant, zero_order_hold

CIRCLE = np.array((0.2, 0.1))


def radius(matrix: np.ndarray) -> float:
    return float(np.abs(np.linalg.eigvals(matrix)).max())


@pytest.mark.parametrize(
    ("period", "delay"), [(0.1, 0.05), (0.05, 0.05), (0.02, 0.06), (0.01, 0.05)]
)
def test_prox_is_said_to_cycle_where_it_does(told, loop, period, delay):
    late = {"clock.control": period, "actuator.delay": delay}
    (warning,) = told("prox", late, "paper-simulation", key="clock.control")

    assert f"a delay of {delay:g} s" in warning.sentence
    assert largest_period(loop("prox", late)) == 0
    assert largest_period(loop("prox", {"clock.control": period})) > 0.13


@pytest.mark.parametrize("delay", [0.02, 0.05, 0.07])
def test_a_law_without_memory_is_followed_force_by_force(loop, delay):
    """The matrix moves error and velocity as forces do that each arrive when they are due."""
    late, period = loop("mb", {"clock.control": 0.02, "actuator.delay": delay}), 0.02
    matrix, gain = closed_loop(late, CIRCLE, period), late.feedback(CIRCLE, period)
    rates, push = linear_plant(late.scenario, tuple(CIRCLE))
    tick = 0.01
    free, forced = zero_order_hold(rates, push, tick)
    s, sent = np.array((1e-3, 2e-3, -1e-3, 1e-2, 3e-2)), []
    state = np.concatenate((s, np.zeros(len(matrix) - 5)))
    for k in range(12):
        sent.append(gain[:, :5] @ s)
        for j in range(2):
            due = int(np.floor(((2 * k + j) * tick - delay) / period + 1e-9))
            s = free @ s + forced @ (sent[due] if due >= 0 else np.zeros(2))
        state = matrix @ state
    assert state[:5] == pytest.approx(s, rel=1e-9)


def test_the_peer_stands_half_a_period_and_not_a_whole_one(loop):
    for delay, stable in ((0.05, True), (0.1, False)):
        changed = {"clock.control": 0.1, "actuator.delay": delay}
        assert (radius(closed_loop(loop("kanayama", changed), CIRCLE, 0.1)) < 1) == stable
        run = simulate("paper-simulation-nominal", "kanayama", overrides=changed)
        assert ("oscillates" not in [item.key for item in run.remarks]) == stable
