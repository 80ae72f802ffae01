"""Proofs read the compiled graph: choices as one operation, quotients as C computes them."""

import hashlib
from pathlib import Path

import casadi as ca
import pytest

import wmr_ctrl
from wmr_ctrl.codegen.emit import kernel
from wmr_ctrl.control.laws import LAWS
from wmr_proofs.claims.common import LawGraph, scalars
from wmr_proofs.graph import _NAMES, graph_of, is_parameter
from wmr_proofs.statement import above, at_least, equal, listed, symbols


def operations(graph):
    return [node.op for node in graph.nodes if node.op not in ("input", "const")]


def written(graph, k):
    """A value with all its operands, recursively, as text."""
    node = graph.nodes[k]
    if node.op in ("input", "const"):
        return node.name or repr(node.value)
    return f"{node.op}({', '.join(written(graph, arg) for arg in node.args)})"


PACKAGE = Path(wmr_ctrl.__file__).parent
T = symbols("x y p q", "p q")
X, Y, P, Q = T.values()


@pytest.mark.parametrize(
    "expr, text",
    [
        (X / P, "mul(x, inv(p))"),
        (X / (P - Q), "mul(x, inv(sub(p, q)))"),
        (X / (P - 2), "mul(x, inv(sub(p, 2.0)))"),
        (P / Q, "div(p, q)"),
        (2 / P, "div(2.0, p)"),
        (X / Y, "div(x, y)"),
        (X / (Y + P), "div(x, add(y, p))"),
        (P / X, "div(p, x)"),
        (X / 3, "div(x, 3.0)"),
        (1 / P, "inv(p)"),
        (X / ca.if_else(P > 1, P, 1), "mul(x, inv(choose(lt(1.0, p), p, 1.0)))"),
        (ca.if_else(X > 1, P, Q) / Q, "mul(choose(lt(1.0, x), p, q), inv(q))"),
        (X / ca.if_else(X > 1, P, Q), "div(x, choose(lt(1.0, x), p, q))"),
    ],
)
def test_quotients_by_parameters_are_products_and_no_others(expr, text):
    graph = graph_of(T, [expr])

    assert written(graph, graph.outputs[0]) == text


def test_a_quotient_is_written_alike_once_and_many_times():
    once = graph_of(T, [X / P])
    often = graph_of(T, [X / P, Y / P, X * Y / P])

    assert written(once, once.outputs[0]) == written(often, often.outputs[0])
    assert operations(often).count("inv") == 1


def test_a_choice_is_one_operation():
    assert operations(graph_of(T, [ca.if_else(X > Y, X, Y)])) == ["lt", "choose"]


def test_cuts_and_numbers_are_put_in_after_the_graph_was_read():
    graph = graph_of(T, [X / (P - Q)], {"x": X + 0}, {"q": 2.0})

    assert written(graph, graph.outputs[0]) == "mul(x, inv(sub(p, 2.0)))"


def test_a_constant_is_never_cut():
    graph = graph_of(T, [ca.if_else(X > 0, Y, 0)], {"friction": ca.SX(0)})

    assert graph.input_names == ("x", "y")


@pytest.mark.parametrize("law", sorted(LAWS))
def test_a_law_is_proved_as_it_is_compiled(law):
    """Every value of the C function, by operation and operands, is in the graph that proofs see."""
    found = LawGraph(law)
    system = found.system
    item = kernel("step", "", {"u": system.u, "x": system.x, "p": system.p}, {"y": system.y})
    graph = graph_of(found.symbols, [found.force[i] for i in (0, 1)])
    places = {
        (name, row): element
        for name, ports in (("u", system.inputs), ("x", system.state), ("p", system.params))
        for row, element in enumerate(scalars(ports))
    }
    emitted = [n.operands for n in item.graph.nodes]
    heads = [(_NAMES[n.op], n.number, places[n.place] if n.place else "") for n in item.graph.nodes]

    assert item.operations > 10
    assert fingerprints(heads, emitted) == fingerprints(
        [(n.op, n.value, n.name) for n in graph.nodes], [n.args for n in graph.nodes]
    )


def fingerprints(heads, operands):
    """Set of hashes of the values, each with everything it is computed from."""
    found = []
    for head, args in zip(heads, operands, strict=True):
        text = repr((head, [found[k] for k in args]))
        found.append(hashlib.sha256(text.encode()).hexdigest())
    return set(found)


@pytest.mark.parametrize("law", sorted(LAWS))
def test_the_numbers_of_a_scenario_are_known_by_their_dotted_keys(law):
    system = LawGraph(law).system

    assert all(is_parameter(port.sym[0]) for port in system.params)
    assert not any(is_parameter(port.sym[0]) for port in (*system.inputs, *system.state))


def test_nothing_else_reads_the_instructions_of_casadi():
    readers = [
        path.relative_to(package.parent).as_posix()
        for package in (PACKAGE, PACKAGE.with_name("wmr_proofs"))
        for path in package.rglob("*.py")
        if "instruction_id" in path.read_text("utf-8")
    ]

    assert readers == ["wmr_ctrl/world/model/graph.py"]


@pytest.mark.parametrize(
    "truth, relation",
    [(X >= Y, at_least(X, Y)), (X < 1, above(1, X)), (X * Y == P, equal(X * Y, P)),
     (X == X, equal(0)), (X * X < 0, equal(1))],
)  # fmt: skip
def test_comparison_is_a_relation(truth, relation):
    (found,) = listed((truth,))
    assert (str(found.expr), found.kind) == (str(relation.expr), relation.kind)


def test_other_expressions_are_no_relation():
    with pytest.raises(ValueError, match="no comparison"):
        listed([X + Y])
