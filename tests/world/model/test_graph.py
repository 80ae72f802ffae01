"""A function read as single assignments: equal values once, choices as one operation."""

import casadi as ca
import pytest

from wmr_ctrl.world.model.graph import SELECT, read, rounds, unrounded

X, P = ca.SX.sym("x", 2), ca.SX.sym("p", 2)


def graph_of(expression):
    return read(ca.Function("f", [X, P], [expression]), ["x", "p"], ["y"])


def operations(expression):
    return [node.op for node in graph_of(expression).nodes if not node.leaf]


def test_a_choice_is_one_operation_and_equal_values_are_one():
    found = operations(ca.if_else(X[0] < X[1], X[0] * X[1], X[1]) + X[0] * X[1])

    assert sorted(found) == sorted([ca.OP_LT, ca.OP_MUL, SELECT, ca.OP_ADD])


def test_quotients_by_a_parameter_share_its_reciprocal():
    shared = operations(ca.vertcat(X[0] / P[0], X[1] / P[0]))

    assert shared.count(ca.OP_MUL) == 2
    assert shared.count(ca.OP_DIV) + shared.count(ca.OP_INV) == 1


def test_a_truth_value_is_known_as_one():
    graph = graph_of(X[0] < X[1])

    assert graph.is_logical(graph.stores[0].node)
    total = graph_of(X[0] + X[1])
    assert not total.is_logical(total.stores[0].node)


def test_rounding_is_found_and_left_out_where_something_varies():
    expression = ca.floor(X[0] / P[0] + 0.5) * P[0]

    assert rounds(expression, X)
    assert not rounds(ca.floor(P[0]) * X[0], X)
    value = ca.Function("v", [X, P], [unrounded(expression, X)])([0.7, 0.0], [0.2, 0.0])
    assert float(value) == pytest.approx(0.7, abs=0.1 + 1e-12)
    assert float(value) != pytest.approx(0.6)
