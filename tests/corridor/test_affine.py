"""Affine forms enclose a graph's values on a box, and an undefined value stays undefined."""

from concurrent.futures import ThreadPoolExecutor

import casadi as ca
import numpy as np
import pytest

from wmr_proofs.corridor.affine import AffineGraph, Form, _below

X = ca.SX.sym("x", 3)
GRAPHS = {
    "tanh of a quotient": ca.tanh(X[0] / 0.3) / (3 + X[1]),
    "products and a root": X[0] * X[1] ** 2 - ca.sqrt(4 + X[2]) * X[0],
    "least and most": ca.fmin(X[0], ca.sin(X[1])) + ca.fmax(X[0] * X[1], ca.fabs(X[2])),
    "a choice": ca.if_else(ca.logic_and(X[0] < X[1], X[2] <= 0.2), ca.cos(X[1]), X[0] * X[2]),
    "one of two": ca.if_else(ca.logic_or(X[0] < X[1], ca.logic_not(X[2] <= 0)), X[0], X[1] * X[2]),
    "a number as a condition": ca.if_else(ca.logic_and(X[0] < X[1], 2.0), X[0], X[1]),
    "no number as a condition": ca.if_else(ca.logic_or(X[0] < X[1], 0.0), X[0], X[2]),
    "an inner point": ca.tanh(8 * X[0]) - 3 * X[0],
}
NONE = ca.sqrt(X[0] - 1e3) + 0 * X[1]
PASSED = {
    "min": ca.fmin(NONE, X[1]),
    "max": ca.fmax(X[1], NONE),
    "tanh": ca.tanh(NONE),
    "sine": ca.sin(NONE),
    "size": ca.fabs(NONE),
    "a choice by it": ca.if_else(X[1] < 0, NONE, X[1]),
    "a choice of it": ca.if_else(X[1] > NONE, NONE, 1.0),
    "quotient": X[1] / ca.fmax(X[2], -1e3),
}


def radius_of(forms):
    return np.abs(forms.L).sum(axis=2) + forms.r


@pytest.mark.parametrize("name", GRAPHS)
def test_every_point_of_a_box_is_within_its_form(name):
    rng, function = np.random.default_rng(3), ca.Function("f", [X], [GRAPHS[name]])
    center = rng.uniform(-1.0, 1.0, (60, 3))
    radius = 10 ** rng.uniform(-8, 0, (60, 3)) * (rng.random((60, 3)) < 0.8)
    forms = AffineGraph(X, GRAPHS[name])(center, radius)

    corners = rng.choice([-1.0, 1.0], (60, 3, 40))
    xi = np.concatenate([corners, rng.uniform(-1.0, 1.0, (60, 3, 200))], axis=2)
    points = center[:, :, None] + radius[:, :, None] * xi
    value = np.array([function(x).full()[0] for x in points])
    off = np.abs(value - forms.c - np.einsum("ci,cip->cp", forms.L[:, 0], xi))
    assert (off <= forms.r + 1e-15).all()
    assert np.median(forms.r - off.max(axis=1, keepdims=True)) < 0.2


@pytest.mark.parametrize("name", PASSED)
def test_what_is_no_number_stays_none(name):
    center, radius = np.zeros((1, 3)), np.full((1, 3), 0.1)
    forms = AffineGraph(X, PASSED[name])(center, radius)
    every = [forms.c, forms.r, forms.size, radius_of(forms)]
    assert not np.isfinite(every).all()


def test_what_is_no_number_does_not_count_where_it_is_not_chosen():
    graph = AffineGraph(X, ca.if_else(X[1] < 1, X[2], NONE))
    forms = graph(np.zeros((1, 3)), np.full((1, 3), 0.1))
    assert radius_of(forms)[0, 0] == pytest.approx(0.1)


@pytest.mark.parametrize("amiss", [np.nan, np.inf])
@pytest.mark.parametrize("part", ["center", "radius"])
@pytest.mark.parametrize("place", range(3))
def test_an_input_that_is_no_number_leaves_none(place, part, amiss):
    for output in (ca.tanh(X), ca.fabs(X), ca.fmax(X, 1), ca.sin(X), ca.if_else(X > 0, X, 1)):
        given = {"center": np.zeros((1, 3)), "radius": np.ones((1, 3))}
        given[part][0, place] = amiss
        assert not np.isfinite(radius_of(AffineGraph(X, output)(**given))[0, place])


@pytest.mark.slow
def test_threads_share_a_graph_and_not_its_boxes():
    graph, rng = AffineGraph(X, ca.vertcat(*GRAPHS.values())), np.random.default_rng(7)
    center = rng.normal(size=(8, 2000, 3)) * 0.3
    radius = np.full_like(center, 0.01)
    alone = [graph(*pair).r for pair in zip(center, radius, strict=True)]
    with ThreadPoolExecutor(8) as pool:
        together = [found.r for found in pool.map(graph, center, radius)]

    assert all(map(np.array_equal, alone, together))


def test_numbers_that_are_known_to_be_equal_are_not_below_each_other():
    """Equal numbers: "less" is certainly false, "at most" certainly true."""
    zero = Form(ca.SX(0), ca.SX(1, 1), ca.SX(0), ca.SX(0))
    below, at_most = (_below(strict)(zero, zero) for strict in (True, False))

    assert [float(item) for item in (below.yes, below.no)] == [0.0, 1.0]
    assert [float(item) for item in (at_most.yes, at_most.no)] == [1.0, 0.0]
