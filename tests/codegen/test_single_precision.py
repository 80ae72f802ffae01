"""C in single precision."""

import math

import casadi as ca
import pytest

from tests.papers_robot import paper
from wmr_ctrl.codegen.single_precision import (
    LARGEST_CONSTANT,
    LIMITS,
    MARGIN,
    package_dialect,
    with_margin,
)
from wmr_ctrl.control.controller import controller
from wmr_ctrl.control.setup import settle


def test_only_limits_are_lowered():
    law = controller(settle(paper(), "mb"))
    pairs = zip(law.params, with_margin(law).params, strict=True)

    changed = {old.signal.name for old, new in pairs if old.value != new.value}
    assert changed == {"limits.v_u1"} <= set(LIMITS)
    (lowered,) = (p for p in with_margin(law).params if p.signal.name == "limits.v_u1")
    assert lowered.value == pytest.approx(
        [x * (1 - MARGIN) for x in paper().limits.v_u1], rel=1e-15
    )


def test_literals_and_functions_are_those_of_float():
    single, double = package_dialect(True), package_dialect(False)

    assert (single.number(0.5), double.number(0.5)) == ("0.5f", "0.5")
    assert single.number(-1e30) == f"(-{LARGEST_CONSTANT!r}f)"
    assert single.number(math.inf) == "WMR_INF"
    assert single.pattern(ca.OP_EXP) == "expf({0})"
    assert single.pattern(ca.OP_FMIN) == "wmr_min({0}, {1})"
    assert single.pattern(ca.OP_INV) == "1.0f / {0}"
    assert single.as_real("t") == "(wmr_real)t"
