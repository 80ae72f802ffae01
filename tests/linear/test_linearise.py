"""Exact linearisation: closed forms, names, and quantities that stay constant along a reference."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from wmr_ctrl.core.errors import ArgumentError, UnknownNameError
from wmr_ctrl.theory.checks.rest import newton
from wmr_ctrl.theory.linear import closed_loop, kinematic_poles, on_reference, resting_point
from wmr_ctrl.theory.linear.linear_report import _pairs
from wmr_ctrl.theory.linear.state_space import plant_at
from wmr_ctrl.world.references import Line
from wmr_ctrl.world.scenario import override

K1, K2, K3, V1D, V2D = 10.0, 5.0, 4.0, 0.2, 0.1
RHO, RHO1, M, I = (15.0, 57.6), (1350.0, 21.6), 50.0, 5.4


def test_kinematic_polynomial_in_closed_form(nominal):
    """e' = A e with A written out from Eqs. (7), (33)-(35)."""
    a = np.array([[-K1, V2D, 0], [-V2D, 0, V1D], [0, -K2 * V1D, -K3]])

    assert np.poly(kinematic_poles(nominal)).real == pytest.approx(np.poly(a), rel=1e-12)


def test_plant_in_closed_form(nominal):
    found = plant_at(nominal, on_reference(nominal, "mb"))
    a = np.zeros((5, 5))
    a[0, 1], a[1, 0], a[0, 3], a[1, 2], a[2, 4] = V2D, -V2D, -1, V1D, -1

    assert pytest.approx(a, abs=1e-12) == found.A
    assert found.B[3:, :2] == pytest.approx(np.diag((1 / M, 1 / I)))
    assert found.state_labels == ["e[1]", "e[2]", "e[3]", "v1", "omega"]
    assert found.input_labels == ["force[1]", "force[2]", "disturbance[1]", "disturbance[2]"]


def test_model_based_loop_in_closed_form(nominal):
    """z' = -rho/2 z on the reference, so the poles are the kinematic ones and -rho/2."""
    loop = closed_loop(nominal, "mb")
    expected = np.sort((*kinematic_poles(nominal).real, -RHO[0] / 2, -RHO[1] / 2))

    assert np.sort(loop.poles().real) == pytest.approx(expected, rel=1e-9)
    assert loop.input_labels == ["disturbance[1]", "disturbance[2]"]
    assert loop.output_labels == ["e[1]", "e[2]", "e[3]", "v1", "omega", "force[1]", "force[2]"]
    assert loop.isctime()
    assert closed_loop(nominal, "mb", period=0.02).dt == 0.02


def test_network_loop_with_learning_frozen_in_closed_form(nominal):
    """v' = -rho1/(2 M) (v - v_c0): without feed-forward the axes are second order."""
    line = replace(nominal, reference=Line())
    a = RHO1[0] / (2 * M)
    found = closed_loop(line, "nn").poles()
    expected = np.roots((1, a, a * K1))

    assert np.abs(found[:, None] - expected).min(axis=0).max() < 1e-6


def test_lag_of_the_drives_is_part_of_the_plant(nominal):
    slow = override(nominal, {"actuator.lag": 0.05})
    found = plant_at(slow, on_reference(slow, "mb"))
    poles = np.linalg.eigvals(found.A)

    assert found.nstates == 7
    assert np.sum(np.abs(poles + 20.0) < 1e-6) == 2


def test_settled_point_has_the_friction_in_the_weights(nominal):
    """At rest W'S = F1 = mu m g, up to the leak's share of 3e-4."""
    point = resting_point(nominal, "nn")

    assert point.force[0] == pytest.approx(0.08 * 50 * 9.81, rel=1e-9)
    assert np.abs(point.e).max() < 3e-3


def test_a_loop_that_cannot_rest_is_refused(nominal):
    weak = override(nominal, {"gains.pid.Kp": [0.0, 0.0]})

    with pytest.raises(ArgumentError, match="no resting point"):
        resting_point(weak, "pid")


def test_bad_names_are_answered_with_the_known_ones(nominal):
    with pytest.raises(UnknownNameError, match="mb"):
        closed_loop(nominal, "mbb")
    with pytest.raises(UnknownNameError, match="frozen"):
        closed_loop(nominal, "nn", memory="frosty")


def test_a_resting_point_is_found_to_the_last_digits():
    x = ca.SX.sym("x", 5)
    value = x**3 - ca.DM([1.0, 2.0, 3.0, 4.0, 5.0])
    residual = ca.Function("residual", [x], [value, ca.densify(ca.jacobian(value, x))])

    assert newton(residual, np.full(5, 1.2)) == pytest.approx(
        np.arange(1.0, 6.0) ** (1 / 3), rel=1e-12
    )


def test_poles_are_pairs_of_real_and_imaginary_part():
    assert _pairs(np.array([-1.0 + 2.0j, -3.0])) == [[-1.0, 2.0], [-3.0, 0.0]]
