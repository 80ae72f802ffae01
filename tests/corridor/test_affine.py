"""Affine forms enclose a graph's values on a box, and an undefined value stays undefined."""

from concurrent.futures import ThreadPoolExecutor

import casadi as ca
import numpy as np
import pytest

from wmr_proofs.corridor.affine import AffineGraph, Form, _below
from wmr_proofs.corridor.enclosure import OpenBoxError

X = ca.SX.sym("x", 3)
GRAPHS = {
    "tanh of a quotient": ca.tanh(X[0] / 0.3) / (3 + X[1]),
    "products and sines": X[0] * X[1] ** 2 - ca.sin(X[2]) * ca.cos(X[0]),
    "a choice": ca.if_else(X[0] < X[1] + 9, ca.if_else(X[2] < -9, X[1], X[0] * X[2]), X[0]),
    "an inner point": ca.tanh(8 * X[0]) - 3 * X[0],
}
NONE = 1 / X[0]
PASSED = {
    "tanh": ca.tanh(NONE),
    "sine": ca.sin(NONE),
    "a choice of it": ca.if_else(X[1] < 9, NONE, X[1]),
    "a choice by it": ca.if_else(X[1] < NONE, X[1], 1.0),
    "a choice that is open": ca.if_else(X[1] < 0, X[1], X[2]),
    "quotient": X[1] / X[2],
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


@pytest.mark.parametrize("middle", [0.0, 0.05, -0.05])
@pytest.mark.parametrize("name", PASSED)
def test_what_is_no_number_stays_none(name, middle):
    center, radius = np.full((1, 3), middle), np.full((1, 3), 0.1)
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
    for output in (ca.tanh(X), ca.sin(X), ca.if_else(X < 0, X, 1)):
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
    zero = Form(ca.SX(0), ca.SX(1, 1), ca.SX(0), ca.SX(0))
    below = _below(zero, zero)

    assert [float(item) for item in (below.yes, below.no)] == [0.0, 1.0]


@pytest.mark.parametrize("output", [ca.fabs(X), ca.if_else(X[0], X[1], X[2])])
def test_an_operation_without_a_rule_is_refused(output):
    with pytest.raises(OpenBoxError, match="not covered"):
        AffineGraph(X, output)
