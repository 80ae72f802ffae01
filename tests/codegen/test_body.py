"""Choices that depend on each other: branches compute what they need, in a valid order."""

import casadi as ca
import numpy as np

from tests.codegen.compiled import compiled, machine, made
from wmr_ctrl.codegen.body import body
from wmr_ctrl.codegen.dialect import LANES, SCALAR
from wmr_ctrl.codegen.emit import definition
from wmr_ctrl.world.model.graph import read


def one_after_the_other():
    """A choice that reads another one on the same condition."""
    x = ca.SX.sym("x", 3)
    first = ca.if_else(x[0] > 0, ca.exp(x[1]), ca.log(1 + x[2] * x[2]))
    second = ca.if_else(x[0] > 0, ca.exp(ca.sin(first)), ca.log(2 + ca.cos(first)))
    return made(ca.vertcat(first, second), "after", x=x)


def shared_by_an_inner_one():
    """A value that a branch returns, and that a choice within it reads on one side only."""
    x = ca.SX.sym("x", 3)
    value = ca.exp(x[1])
    inner = ca.if_else(x[2] > 0, ca.sin(value) * ca.exp(x[2]), ca.log(1 + x[2] * x[2]))
    outer = [ca.if_else(x[0] > 0, item, 0.5) for item in (value, inner)]
    return made(ca.vertcat(*outer), "within", x=x)


def test_choices_that_read_each_other_keep_their_values():
    kernels = [one_after_the_other(), shared_by_an_inner_one()]
    for item, step in zip(kernels, compiled(kernels), strict=True):
        wanted = machine(item)
        assert definition(item).count("if (") >= 2
        for signs in np.ndindex(2, 2, 2):
            x = np.array([0.3, 0.7, 1.1]) * (2 * np.array(signs) - 1)
            assert (step(x) == wanted(x)).all(), item.name


def test_a_sine_and_a_cosine_of_one_angle_are_one_call_in_lanes():
    x = ca.SX.sym("x")
    function = ca.Function("both", [x], [ca.vertcat(ca.sin(x), ca.cos(x))])
    graph = read(function, ["x"], ["y"])
    scalar, lanes = ("\n".join(body(graph, dialect)) for dialect in (SCALAR, LANES))

    assert "wmr_sin(" in scalar
    assert "wmr_cos(" in scalar
    assert "wmr_cos(" not in lanes
