"""The model-based law."""

import numpy as np
import pytest

from tests.control.laws.points import DRIVING, T, assert_twin, at, graph
from tests.tables import changes
from wmr_ctrl.control.basis import ANY_BASIS
from wmr_ctrl.control.laws.mb import LAW, inside, rule


def test_the_exact_decay_is_that_of_a_whole_period():
    """The force is linear in the rate, so two rates give the rate that the option uses."""

    rho = np.array([15.0, 57.6])
    texts = "", f"gains.mb.rho = {(2 * rho).tolist()}", "gains.mb.decay = exact"
    one, double, exact = (at(graph(LAW.name, **changes(text)), DRIVING)[0] for text in texts)
    rate = rho * (1 + (exact - one) / (double - one))

    assert rate == pytest.approx((1 - np.exp(-rho * T)) / T, rel=1e-9)


def test_its_rate_follows_from_the_basis():
    assert rule(ANY_BASIS) == {"rho": ANY_BASIS.rho}
    assert LAW.inside is inside


def test_its_force_is_that_of_its_formulas():
    assert_twin(LAW.name)
