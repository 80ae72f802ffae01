"""Values of CasADi functions as arrays."""

import casadi as ca
import numpy as np
import pytest

from wmr_ctrl.world.model.evaluate import InPlace, evaluated

X, Y = ca.SX.sym("x", 2), ca.SX.sym("y")
FUNCTION = ca.Function("f", [X, Y], [ca.horzcat(X, Y * X, X + 1), ca.dot(X, X)])


def test_the_numbers_are_those_of_a_call():
    table, square = evaluated(FUNCTION, [[1.5, -2.0]], 3)

    assert (table == np.array([[1.5, 4.5, 2.5], [-2.0, -6.0, -1.0]])).all()
    assert square == [[6.25]]


def test_a_call_in_place_reads_and_writes_the_same_arrays():
    call = InPlace.with_arrays(FUNCTION)
    for x in (1.0, 2.0):
        call.inputs[0][:] = x
        call()
        assert call.outputs[1] == pytest.approx(2 * x * x)
