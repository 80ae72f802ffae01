"""C in single precision."""

import math

import casadi as ca
import numpy as np
import pytest

from benchmarks.filter_trials.compiled import scenario
from benchmarks.filter_trials.first_order import BY_SIDE, first_order
from tests.papers_robot import paper
from wmr_ctrl.codegen.single_precision import (
    LARGEST_CONSTANT,
    MARGIN,
    package_dialect,
    with_margin,
)  # fmt: skip
from wmr_ctrl.control.controller import controller
from wmr_ctrl.control.filter import filter_system
from wmr_ctrl.control.setup import settle


def values(system):
    return {item.signal.name: item.value for item in system.params}


def test_only_limits_are_lowered():
    """Limits of each direction are lowered by a share of the larger one.

    The limit of v backwards stays: a push alone reaches it, so no command is sent that way.
    """
    law = controller(settle(paper(), "mb"))
    before, after = values(law), values(with_margin(law))
    assert {name for name in before if before[name] != after[name]} == {"limits.v_u1"}
    lowered = [x * (1 - MARGIN) for x in paper().limits.v_u1]
    assert after["limits.v_u1"] == pytest.approx(lowered, rel=1e-15)

    sides = {"limits.v_min": (-0.05, -0.4), "limits.v_max": (0.8, 0.06)}
    own = values(with_margin(filter_system(scenario("governor", sides))))
    less = MARGIN * np.array([0.8, 0.4])
    assert own["limits.v_max"] == pytest.approx(np.array([0.8, 0.06]) - less, rel=1e-15)
    assert own["limits.v_min"] == pytest.approx([-0.05, -0.4 + less[1]], rel=1e-15)


@pytest.mark.parametrize("kind", ["clip", "governor"])
def test_single_precision_keeps_limits_of_each_direction_by_its_margin(kind, monkeypatch):
    for margin in (MARGIN, 0.0):
        monkeypatch.setattr("wmr_ctrl.codegen.package._margin", lambda *_, own=margin: own)
        most = first_order(kind, [{}], BY_SIDE, ("axes",), float32=True)(400, 1)
        assert (most.max() <= 1) == (margin > 0)


def test_literals_and_functions_are_those_of_float():
    single, double = package_dialect(True), package_dialect(False)

    assert (single.number(0.5), double.number(0.5)) == ("0.5f", "0.5")
    assert single.number(-1e30) == f"(-{LARGEST_CONSTANT!r}f)"
    assert single.number(math.inf) == "WMR_INF"
    assert single.pattern(ca.OP_EXP) == "expf({0})"
    assert single.pattern(ca.OP_FMIN) == "wmr_min({0}, {1})"
    assert single.pattern(ca.OP_INV) == "1.0f / {0}"
    assert single.as_real("t") == "(wmr_real)t"
