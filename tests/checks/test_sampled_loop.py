"""The sampled linear loop against known limits, known poles and simulated runs."""

from dataclasses import replace

import numpy as np
import pytest

from tests.checks.asking import closed
from wmr_ctrl.theory.checks.loop import Loop
from wmr_ctrl.theory.checks.stable_ranges import largest_period

CIRCLE = np.array([0.2, 0.1])


@pytest.mark.parametrize("period, radius", [(0.06, 0.99691), (0.07, 1.3366), (0.1, 2.530)])
def test_spectral_radii_of_the_model_based_loop(loop, period, radius):
    eigenvalues = np.linalg.eigvals(closed(loop("mb"), CIRCLE, period))

    assert np.abs(eigenvalues).max() == pytest.approx(radius, rel=2e-4)


def test_fast_sampling_shows_the_poles_of_kinematics_and_velocity_loop(loop):
    eigenvalues = np.linalg.eigvals(closed(loop("mb"), CIRCLE, 1e-4))
    poles = np.sort(np.log(eigenvalues.astype(complex)).real / 1e-4)

    assert poles == pytest.approx([-28.8, -9.999, -7.5, -3.94934, -0.05166], rel=5e-3)


@pytest.mark.parametrize("law", ["pid", "smc", "mb", "nn"])
def test_limit_separates_stable_from_unstable_matrices(loop, law):
    at = loop(law)
    limit = largest_period(at)

    def radius(period):
        return np.abs(np.linalg.eigvals(closed(at, CIRCLE, period))).max()

    assert 0.02 < limit < 1
    assert radius(0.999 * limit) < 1 < radius(1.001 * limit)


def test_adaptive_laws_keep_their_estimates_out_of_the_loop(loop):
    sizes = {law: closed(loop(law), CIRCLE, 0.01).shape[0] for law in ("smc", "mb", "nn")}

    assert sizes == {"smc": 5, "mb": 5, "nn": 5}
    assert closed(loop("pid"), CIRCLE, 0.01).shape == (8, 8)


@pytest.mark.parametrize("declared, states", [(True, 5), (False, 9)])
def test_a_law_states_itself_what_its_memory_is(loop, declared, states):
    setup = loop("smc").setup
    traits = replace(setup.law.traits, estimates=declared)
    stated = replace(setup, law=replace(setup.law, traits=traits))

    assert closed(Loop(stated), CIRCLE, 0.01).shape == (states, states)
