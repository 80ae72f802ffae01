"""Loops for runs of similar operations."""

import casadi as ca
import pytest

from wmr_ctrl.codegen.items import ArrayLoop, statements
from wmr_ctrl.codegen.reroll import SHORTEST, reroll
from wmr_ctrl.world.model.graph import read


@pytest.mark.parametrize("count, rolled", [(SHORTEST - 1, False), (16, True)])
def test_products_of_vectors_become_a_loop_from_a_length_on(count, rolled):
    a, b = ca.SX.sym("a", count), ca.SX.sym("b", count)
    graph = read(ca.Function("f", [a, b], [a * b]), ["a", "b"], ["y"])
    items, places = reroll(graph, statements(graph))
    loops = [item for item in items if isinstance(item, ArrayLoop)]

    assert any(item.op == ca.OP_MUL and item.length == count for item in loops) is rolled
    assert all(array for array, _ in places.values())
