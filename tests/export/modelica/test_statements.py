"""Numbers, operations and changes of the robot as Modelica's text, each read back as Python's."""

import math

import casadi as ca
import numpy as np
import pytest

from tests.commands import flat
from tests.papers_robot import paper
from wmr_ctrl.control.controller import controller
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.export.modelica.package import Member, _assignments, _changes
from wmr_ctrl.export.modelica.statements import _PATTERNS, constant, literal
from wmr_ctrl.world.scenario import override

NAMES = vars(math) | {"abs": abs, "min": min, "max": max, "sign": np.sign}
LOGICAL = (ca.OP_AND, ca.OP_OR, ca.OP_NOT)
PAIRS = ((0.7, 0.3), (0.2, 0.9), (0.5, 0.5), (0.7, -0.3))


def read(text, **numbers):
    """The value of an expression of Modelica."""
    for modelica, python in (("^", "**"), ("<>", "!=")):
        text = text.replace(modelica, python)
    return float(eval(text, {"__builtins__": {}}, NAMES | numbers))


@pytest.mark.parametrize("op", _PATTERNS)
def test_an_operation_is_written_as_what_it_computes(op):
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    two = "{1}" in _PATTERNS[op]
    value = ca.Function("f", [x, y], [ca.SX.binary(op, x, y) if two else ca.SX.unary(op, x)])
    pairs = np.round(PAIRS) if op in LOGICAL else PAIRS

    for a, b in pairs:
        assert read(_PATTERNS[op].format("a", "b"), a=a, b=b) == pytest.approx(float(value(a, b)))


@pytest.mark.parametrize(
    "value, text",
    [(math.inf, "1e+300"), (-math.inf, "(-1e+300)"), (-2, "(-2.0)"), (0.1, "0.1"), (0, "0.0")],
)
def test_a_number_is_finite_and_in_parentheses_where_it_is_negative(value, text):
    assert constant(value) == text
    assert literal(value) == text.strip("()")


def test_a_change_holds_from_its_time_until_that_of_the_next():
    rows = [{"t": 10.0, "m": 30.0, "mu": 9.0}, {"t": 20.0, "m": 40.0}]
    members, now = _changes(override(paper(), {"changes": rows}))
    numbers = {item.name: item.value[0] for item in members}
    first = "(if time < changes_1_t then robot_m else changes_1_m)"

    assert [numbers[f"changes_{k}_t"] for k in (1, 2)] == [10.0, 20.0]
    assert [numbers[f"changes_{k}_m"] for k in (1, 2)] == [30.0, 40.0]
    assert now["robot_m"][1] == f"(if time < changes_2_t then {first} else changes_2_m)"
    assert now["robot_mu"][1] == "(if time < changes_1_t then robot_mu else changes_1_mu)"


@pytest.mark.parametrize(
    "unit, text",
    [("m", 'unit = "m"'), ("m, m", 'each unit = "m"'), ("m, rad", 'unit = {"m", "rad"}')],
)
def test_a_unit_is_one_or_one_for_all_or_one_for_each(unit, text):
    assert Member(Signal("a.b", unit, "", size=len(unit.split(","))), (1.0, 2.0)).unit == text


def test_results_follow_the_memory_in_order():
    law = controller(settle(paper(), "pid"))
    places = _assignments(law)
    first = len(law.x0) + 1

    assert [place for _, place in places] == [f"result[{first + k}]" for k in range(len(places))]
    assert [name for name, _ in places[:2]] == ["tau_right", "tau_left"]


def test_an_experiment_shows_each_period(text):
    assert "StopTime = 80.0, Interval = 0.01, Tolerance" in flat(text)
