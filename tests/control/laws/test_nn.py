"""The separable basis against its definition."""

import casadi as ca
import numpy as np
import pytest

from tests.control.laws.points import assert_twin
from tests.tables import changes
from wmr_ctrl.control.laws.nn import corner_basis, dot
from wmr_proofs.paper_functions import corner_centres, gaussian_basis


def functions(eta, node):
    z = ca.SX.sym("z", 6)
    fast = corner_basis(z, ca.SX(eta), ca.SX(node))
    slow = gaussian_basis(z, ca.SX(eta), corner_centres(6, node))
    return tuple(ca.Function("basis", [z], [item, ca.jacobian(item, z)]) for item in (fast, slow))


@pytest.mark.parametrize(
    "eta, node",
    [(2**0.5, 1.0), (3.0, 0.5), pytest.param(0.5, 1.0, marks=pytest.mark.slow)],
)
def test_product_form_equals_definition(eta, node):
    """Values and derivatives, also where a coordinate is exactly zero."""
    fast, slow = functions(eta, node)
    draw = np.random.default_rng(0)
    for _ in range(40):
        z = draw.normal(size=6) * draw.choice([0.0, 0.3, 1.0, 3.0], size=6)
        for found, wanted in zip(fast(z), slow(z), strict=True):
            assert found.full() == pytest.approx(wanted.full(), rel=1e-12, abs=1e-300)


@pytest.mark.parametrize("far", [1e3, 1e8, 1e160, 1e308, -1e308])
def test_far_away_the_network_is_off_not_broken(far):
    fast, _ = functions(2**0.5, 1.0)
    basis = fast((far, 0, 1, 1, 0.2, 0.1))[0].full()

    assert np.isfinite(basis).all()
    assert (basis >= 0).all()
    assert basis.max() == 0.0


def test_its_force_and_weights_are_those_of_its_formulas():
    assert_twin("nn", 40)
    leaking = changes("gains.nn.sigma = [20, 30]; gains.nn.integrator = semi-implicit")
    assert_twin("nn", 40, **leaking)


def test_lanes_do_not_change_the_inner_product():
    a, b = ca.SX.sym("a", 64), ca.SX.sym("b", 64)
    inner = ca.Function("inner", [a, b], [dot(a, b), ca.dot(a, b)])
    draw = np.random.default_rng(0)
    found, wanted = inner(draw.normal(size=64), draw.normal(size=64))

    assert float(found) == pytest.approx(float(wanted), abs=1e-13)
