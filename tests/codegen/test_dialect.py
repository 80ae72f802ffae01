"""C text of operations."""

import math

import casadi as ca
import pytest

from wmr_ctrl.codegen.dialect import LANES, SCALAR
from wmr_ctrl.core.errors import ArgumentError


@pytest.mark.parametrize(
    "value, text",
    [(0.1, "0.1"), (-2.0, "(-2.0)"), (math.inf, "WMR_INF"), (-math.inf, "(-WMR_INF)"),
     (math.nan, "WMR_NAN")],
)  # fmt: skip
def test_constants_are_safe_in_any_expression(value, text):
    assert SCALAR.number(value) == text
    assert LANES.number(value) == f"wmr_all({text})"


def test_choices_and_truth_values():
    assert SCALAR.choice("c", "a", "b") == "c ? a : b"
    assert LANES.choice("c", "a", "b") == "wmr_choose(c, a, b)"
    assert LANES.choice("c", "a", "b", truths=True) == "wmr_pick(c, a, b)"
    assert (SCALAR.as_real("t"), LANES.as_real("t")) == ("t", "wmr_number(t)")
    assert (SCALAR.as_truth("x"), LANES.as_truth("x")) == ("(x != 0)", "wmr_truth(x)")


def test_an_operation_without_c_is_named():
    assert SCALAR.pattern(ca.OP_LE) == "{0} <= {1}"
    assert LANES.pattern(ca.OP_LE) == "wmr_mask({0} <= {1})"
    with pytest.raises(ArgumentError, match="CasADi's operation erf, of which there is no C"):
        SCALAR.pattern(ca.OP_ERF)
