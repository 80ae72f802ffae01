"""Quick expressions are CasADi's own."""

from __future__ import annotations

from itertools import product

import casadi as ca
import numpy as np
import pytest

from tests.quick_expressions import ONE, SEARCHED, TWO

X, Y = ca.SX.sym("x"), ca.SX.sym("y", 2)
SOME = (X, Y, X * X, ca.SX(2.0), 0, 1, 2, 3, -1.0, 0.0, 0.5, np.float64(2.0), ca.DM([1.0, 2.0]))
GIVEN = {
    **{name: [(x,) for x in SOME] for name in ONE},
    **{name: list(product(SOME, repeat=2)) for name in TWO},
    "if_else": [(c, a, b) for c in (X, X < 1, Y > 0, ca.SX(1)) for a, b in product(SOME, repeat=2)],
}


@pytest.mark.parametrize("name", GIVEN)
def test_a_quick_function_makes_the_nodes_of_casadi(name):
    quick = getattr(ca, name)

    assert getattr(ca.casadi._casadi, name) is not SEARCHED[name]
    for given in GIVEN[name]:
        if any(isinstance(item, ca.SX) for item in given):
            found, expected = quick(*given), SEARCHED[name](*given)
            assert type(found) is type(expected)
            assert str(found) == str(expected)


def test_kinds_that_do_not_fit_are_told_as_by_casadi():
    with pytest.raises(RuntimeError, match="Dimension mismatch"):
        ca.SX.sym("a", 2) * ca.SX.sym("b", 3)
    with pytest.raises(NotImplementedError, match="Wrong number or type of arguments"):
        ca.fmax(X, "text")
