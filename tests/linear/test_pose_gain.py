"""The correction gain of the pose estimate: variances in closed form, and the optimum."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.pose_gain import best_gain, noise_ise, pose_variance
from wmr_ctrl.world.scenario import load_scenario, override


@pytest.fixture(scope="module")
def experiment():
    return load_scenario("paper-experiment")


@pytest.mark.parametrize("gain", [0.05, 0.2, 1.0])
def test_variance_of_the_estimate_is_that_of_its_recursion(experiment, gain):
    rng = np.random.default_rng(2)
    b = np.zeros(20_000)
    for _ in range(round(12 / gain)):
        b = (1 - gain) * b + gain * rng.uniform(-0.05, 0.05, b.size)

    assert np.var(b) == pytest.approx(gain / (2 - gain) * pose_variance(experiment), rel=0.05)


def test_best_gain_is_near_the_rule_of_thumb(experiment):
    """800 poses: the rule 1/sqrt(N) is for a loop without memory of its own."""
    best, rule = best_gain(experiment, "mb"), 1 / np.sqrt(800)

    assert rule < best < 3 * rule
    assert noise_ise(experiment, "mb", best) < noise_ise(experiment, "mb", 0.2)


def test_no_noise_no_loss(experiment):
    assert noise_ise(override(experiment, {"sensor.pose_noise": 0.0}), "mb", 0.2) == 0.0
