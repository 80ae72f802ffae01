"""Foundations of the certificate: balls that enclose graphs, gains that bound responses."""

from functools import partial

import casadi as ca
import numpy as np
import pytest
from flint import arb, arb_mat, ctx

from tests.papers_robot import safe
from wmr_ctrl.control.setup import settle
from wmr_proofs.corridor import gains as room
from wmr_proofs.corridor.enclosure import OFTEN, Enclosure, OpenBoxError
from wmr_proofs.corridor.gains import loop_gains
from wmr_proofs.corridor.inputs import conditions
from wmr_proofs.corridor.loop import Curve, SampledLoop
from wmr_proofs.corridor.midradius import MidRadius
from wmr_proofs.corridor.motion import MovingCurve
from wmr_proofs.corridor.sample import (
    ROUNDING,
    SampleMatrices,
    SlowLoopError,
    doubles,
    powers_until,
)

V_D = np.array([0.2, 0.1])


@pytest.fixture(scope="module", params=["prox", "kanayama"])
def loop(request):
    setup = settle(safe(), request.param)
    return SampledLoop(setup, V_D, partial(conditions, setup))


@pytest.mark.slow_but("prox")
def test_the_linear_part_is_a_contraction_whose_rest_is_known(loop):
    gains = loop_gains(loop, np.zeros((len(loop.at), 1)), np.zeros(len(loop.names)))

    assert gains.damping < 1e-3
    assert max(part.constant.max() for part in (gains.fast, gains.state, gains.law)) < 1e-15
    for part in (gains.fast, gains.state, gains.law):
        assert (part.by >= 0).all()
        assert np.isfinite(part.by).all()


def test_what_is_left_after_all_samples_is_a_norm_that_is_not_below_the_truth(loop, monkeypatch):
    gains = loop_gains(loop, np.zeros((len(loop.at), 1)), np.zeros(len(loop.names)))
    with ctx.workprec(2000):
        left = arb_mat(SampleMatrices(loop).A.tolist()) ** gains.samples
        sizes = np.array([float(abs(x).mid()) for x in left.entries()]).reshape(len(loop.at), -1)
    most = (sizes @ gains.scale / gains.scale).max()

    assert most <= gains.damping <= 1.001 * most
    monkeypatch.setattr(room, "_samples", lambda rough: (3, 10.0))
    with pytest.raises(SlowLoopError, match="is left after 3 samples"):
        loop_gains(loop, np.zeros((len(loop.at), 1)), np.zeros(len(loop.names)))


@pytest.mark.parametrize("ball", [arb(2e9), arb(1, 1e-3)])
def test_a_matrix_that_is_large_or_unsure_has_no_doubles(ball):
    assert doubles(np.array([[arb(2)]])) == 2.0
    with pytest.raises(SlowLoopError, match="more bits"):
        doubles(np.array([[arb(2), ball]]))


def test_norms_are_those_of_the_largest_element():
    rng = np.random.default_rng(2)
    course, scale = rng.normal(size=(5, 3, 4)), np.array([0.5, 1.0, 2.0])
    norms = room._weighed(course, np.abs(course), scale)

    assert norms == pytest.approx((np.abs(course) / scale[:, None]).max(axis=1), rel=1e-9)
    assert (np.abs(course) <= norms[:, None] * scale[:, None]).all()


def test_a_condition_that_goes_both_ways_is_not_guessed():
    x = ca.SX.sym("x")
    graph = Enclosure("a corner", [x], ca.if_else(x > 0, x, -2 * x))

    assert graph([arb(3)])[0] == 3
    assert graph([arb(-3)])[0] == 6
    with pytest.raises(OpenBoxError, match="a corner"):
        graph([arb(0, 1)])


KINKS = {
    "a kink": lambda x: ca.if_else(x > 1.0, 3 * x, x + 2),
    "a jump": lambda x: ca.if_else(x > 1.0, x + 0.5, x),
    "a size": lambda x: ca.fabs(x - 1.0),
    "the lesser": lambda x: ca.fmin(x, 1.0),
}


@pytest.mark.parametrize("case", KINKS)
@pytest.mark.parametrize("moving", [False, True])
def test_a_kink_of_what_has_no_second_derivative_is_not_overlooked(case, moving):
    x = ca.SX.sym("x", 2)
    output, products = KINKS[case](x[0]) + x[1] ** 2, np.array([[0.04, 0.04], [0.04, 0.04]])

    def remainder(at):
        if not moving:
            return Curve("f", x, output, np.array([at, 0.0])).remainders(products).sum()
        curve = MovingCurve("f", x, ca.SX(0, 1), output, (slice(1), 1.0))
        wide, point = np.sqrt(np.diag(products)), MidRadius(np.array([at, 0.0]), np.zeros(2))
        bend = curve.bend_within(point, wide, MidRadius(np.zeros(0), np.zeros(0)))
        return curve.remainders(bend, products).sum()

    assert remainder(0.7) == remainder(1.3) == pytest.approx(0.04)
    with pytest.raises(OpenBoxError, match="f"):
        remainder(1.1)


def test_a_graph_in_balls_holds_its_values():
    x, y, rng = ca.SX.sym("x"), ca.SX.sym("y"), np.random.default_rng(3)
    expr = ca.vertcat(ca.tanh(x) * ca.exp(-y), ca.sin(x + y) / (2 + ca.cos(x)), ca.sqrt(1 + x * x))
    graph, plain = Enclosure("some", [x, y], expr), ca.Function("f", [x, y], [expr])
    box = graph([arb(0.3, 0.2)], [arb(-0.1, 0.3)])

    for a, b in rng.uniform(-1, 1, size=(50, 2)):
        exact = plain(0.3 + 0.199 * a, -0.1 + 0.299 * b).full().ravel()
        assert all(ball.contains(arb(value)) for ball, value in zip(box, exact, strict=True))


def test_a_graph_without_entries_stays_empty_however_often_it_is_called():
    graph = Enclosure("none", [], ca.SX(2, 2))

    assert [graph() for _ in range(OFTEN + 2)] == [[]] * (OFTEN + 2)


@pytest.mark.parametrize("samples", [1, 16, 50])
def test_powers_are_off_by_less_than_what_their_sums_are_given(loop, samples):
    with ctx.workprec(600):
        matrix = SampleMatrices(loop).A
        A = arb_mat(matrix.tolist())
        powers, sizes, last = powers_until(matrix, samples)
        for k in range(samples + 1):
            own, most = (last, 0) if k == samples else (powers[k], sizes[k])
            exact = np.array([[float(x.mid()) for x in row] for row in (A**k).tolist()])
            assert (np.abs(own - exact) <= ROUNDING / 4 * most + 2**-52 * np.abs(exact)).all()
            assert k == samples or (np.abs(exact) <= most * (1 + ROUNDING)).all()


def test_products_of_wide_matrices_hold_those_of_all_that_is_in_them():
    rng = np.random.default_rng(2)
    a, b = (
        MidRadius(scale * rng.normal(size=shape), np.abs(rng.normal(size=shape)))
        for scale, shape in ((0.0, (3, 4)), (0.3, (4, 2)))
    )
    product, reached = a @ b, np.zeros((3, 2))
    for _ in range(400):
        left, right = (
            item.middle + item.radius * rng.choice([-1.0, 1.0], item.middle.shape)
            for item in (a, b)
        )
        off = np.abs(left @ right - product.middle)
        assert (off <= product.radius).all()
        reached = np.maximum(reached, off)

    assert (reached > 0.5 * product.radius).all()
