"""Statements and their order."""

import casadi as ca

from wmr_ctrl.codegen.items import ResultStore, scheduled, statements
from wmr_ctrl.world.model.graph import read

X = ca.SX.sym("x", 4)
EXPRESSION = ca.vertcat(ca.exp(X[0]) * X[1], ca.sin(X[2]), ca.exp(X[0]) + X[3])
GRAPH = read(ca.Function("f", [X], [EXPRESSION]), ["x"], ["y"])


def test_nothing_is_read_before_it_is_computed_and_results_keep_their_order():
    items, known = statements(GRAPH), set[int]()
    for item in items:
        assert item.reads <= known
        known |= set(item.defines)

    stores = [item.store.index for item in items if isinstance(item, ResultStore)]
    assert stores == [0, 1, 2]
    assert scheduled(items[::-1])[-1] is items[0] or scheduled(items) == items
