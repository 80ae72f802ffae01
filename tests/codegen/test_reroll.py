"""Loops for runs of similar operations."""

import casadi as ca
import pytest

from wmr_ctrl.codegen.items import ArrayLoop, statements
from wmr_ctrl.codegen.reroll import SHORTEST, reroll
from wmr_ctrl.world.model.graph import read


@pytest.mark.parametrize("count", [SHORTEST - 1, SHORTEST, 16])
def test_products_of_vectors_become_a_loop_from_a_length_on(count):
    a, b = ca.SX.sym("a", count), ca.SX.sym("b", count)
    graph = read(ca.Function("f", [a, b], [a * b]), ["a", "b"], ["y"])
    items, places = reroll(graph, statements(graph))
    loops = [(item.op, item.length) for item in items if isinstance(item, ArrayLoop)]

    assert ((ca.OP_MUL, count) in loops) is (count >= SHORTEST)
    assert all(array for array, _ in places.values())
