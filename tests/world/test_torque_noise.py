"""Torque noise and its bounds."""

import math

import pytest

from tests.world.motion import scenario
from wmr_ctrl.world.torque_noise import TORQUE_NOISE_EFFECT, noise_at_most, unbounded


def test_it_is_its_deviation_times_what_is_drawn():
    system = TORQUE_NOISE_EFFECT.build(scenario({"disturbance.std": 0.5}))
    shown = system.function("shown", [system.y])([], [], system.p0, [2.0, -1.0])

    assert shown.full().ravel() == pytest.approx([1.0, -0.5])


@pytest.mark.parametrize("truncate, sigmas", [(2.5, 2.5), (math.inf, 3.0)])
def test_the_guard_counts_both_wheels_at_the_truncation_or_three_deviations(truncate, sigmas):
    noisy = scenario({"disturbance.std": 0.5, "disturbance.truncate": truncate})
    thrust = 2 * sigmas * 0.5 / 0.1

    assert noise_at_most(0.5, sigmas, (0.1, 0.25)) == pytest.approx((thrust, thrust * 0.25))
    assert TORQUE_NOISE_EFFECT.bounded(noisy).dbar == pytest.approx((thrust, thrust * 0.25))
    assert unbounded(noisy) is math.isinf(truncate)
    assert bool(TORQUE_NOISE_EFFECT.bounded(noisy).void) is unbounded(noisy)
