"""What the certificate rests on: balls that hold graphs, gains that hold responses."""

from functools import partial
from itertools import combinations

import casadi as ca
import numpy as np
import pytest
from flint import arb, arb_mat, ctx

from tests.papers_robot import safe
from tests.tables import changes
from wmr_ctrl.control.setup import settle
from wmr_proofs.corridor import gains as room
from wmr_proofs.corridor.enclosure import OFTEN, Enclosure, OpenBoxError
from wmr_proofs.corridor.gains import loop_gains
from wmr_proofs.corridor.inputs import conditions
from wmr_proofs.corridor.loop import Curve, SampledLoop
from wmr_proofs.corridor.midradius import MidRadius
from wmr_proofs.corridor.motion import MovingCurve
from wmr_proofs.corridor.sample import ROUNDING, SampleMatrices, SlowLoopError, powers_until

V_D = np.array([0.2, 0.1])


@pytest.fixture(scope="module", params=["prox", "kanayama"])
def loop(request):
    setup = settle(safe(), request.param)
    return SampledLoop(setup, V_D, partial(conditions, setup))


def values(curve, point):
    """The curve's graph in doubles."""
    return np.array([float(x.mid()) for x in curve._value([arb(x) for x in point])])


@pytest.mark.parametrize("name", ["law", "step"])
def test_what_the_linear_part_leaves_stays_below_its_bound(loop, name):
    curve, rng = getattr(loop, name), np.random.default_rng(2)
    size = np.full(len(curve.at), 0.02)
    bound = curve.remainders(np.outer(size, size)).sum(axis=(1, 2))
    slopes = np.array([[float(x.mid()) for x in row] for row in curve.slopes()])
    corners = rng.choice([-1.0, 1.0], size=(200, len(size))) * size

    left = [np.abs(values(curve, curve.at + d) - values(curve, curve.at) - slopes @ d)
            for d in corners]  # fmt: skip

    assert (np.max(left, axis=0) <= bound + 1e-11).all()
    assert np.max(left) > 0


@pytest.mark.slow_but("prox")
def test_the_linear_part_is_a_contraction_whose_rest_is_known(loop):
    gains = loop_gains(loop, np.zeros((len(loop.at), 1)), np.zeros(len(loop.names)))

    assert gains.damping < 1e-3
    assert max(part.constant.max() for part in (gains.fast, gains.state, gains.law)) < 1e-15
    for part in (gains.fast, gains.state, gains.law):
        assert (part.by >= 0).all()
        assert np.isfinite(part.by).all()


@pytest.mark.parametrize("place", [0, 3])
@pytest.mark.slow_but("prox-3")
def test_what_never_changes_brings_the_loop_as_far_as_is_said_and_no_further(loop, place):
    """Of what each plant step adds: summed step by step, in doubles."""
    added, size = np.zeros(len(loop.names)), len(loop.names)
    added[place] = 1e-3
    gains = loop_gains(loop, np.zeros((len(loop.at), 1)), added)
    sample = SampleMatrices(loop)
    A, step = (np.array(item, dtype=float) for item in (sample.A, sample.step))
    within = [np.array(item[:, : sample.n], dtype=float) for item in sample.fast]
    command = [np.array(item[:, sample.n :], dtype=float) for item in sample.fast]
    law = np.array(sample.law[:2], dtype=float)
    x, most, outermost = np.zeros(sample.n), np.zeros(size), np.zeros(sample.n)
    for _ in range(2 * gains.samples):
        own = np.zeros(size)
        for free, forced in zip(within, command, strict=True):
            most = np.maximum(most, np.abs(free @ x + forced @ law @ x + own))
            own = step @ own + added
        x = A @ x
        x[:size] += own
        outermost = np.maximum(outermost, np.abs(x))

    assert (most <= gains.fast.constant[:size] * (1 + 1e-9)).all()
    assert (outermost <= gains.state.constant * (1 + 1e-9)).all()
    assert gains.fast.constant[:size] == pytest.approx(most, rel=0.05, abs=1e-9)


def test_gains_are_sums_of_the_answers_to_single_inputs(loop):
    """Of pushes, of what the law's outputs and what is measured are off, at all plant steps; of
    what plant steps leave; and of a start.  Rows: elements, directions, pairs."""
    n, size, start = len(loop.at), len(loop.names), np.eye(len(loop.at))[:, :3] * 0.5
    gains = loop_gains(loop, start, np.zeros(size))
    sample = SampleMatrices(loop)
    A, step, law, seen, push, outputs = (
        np.array(item, dtype=float)
        for item in (sample.A, sample.step, sample.law, sample.seen, sample.push, sample.outputs)
    )
    turns = np.pi / 16 * np.arange(16)
    rows = [
        *np.eye(size),
        *(np.cos(t) * np.eye(size)[0] + np.sin(t) * np.eye(size)[1] for t in turns),
    ]
    for (a, b), ratio in zip(combinations(range(5), 2), gains.ratios, strict=True):
        rows += [np.eye(size)[a] + sign * ratio * np.eye(size)[b] for sign in (1, -1)]
    rows, inputs = np.array(rows), np.hstack([push, outputs, outputs @ seen])
    powers = [np.eye(n)]
    for _ in range(gains.samples):
        powers.append(A @ powers[-1])
    within = [np.linalg.matrix_power(step, k) for k in range(loop.steps + 1)]
    by, left, begun = (np.zeros((len(rows), k)) for k in (inputs.shape[1] + 1, size, 1))
    for s, (whole, pushed) in enumerate(zip(sample.fast, sample.pushed, strict=True)):
        free, forced = np.split(np.array(whole, dtype=float), [n], axis=1)
        ways = rows @ (free + forced @ law[:2]) @ np.array(powers)
        direct = np.hstack([np.array(pushed, dtype=float), forced,
                            np.zeros((size, len(law) - 2)), forced @ seen[:2]])  # fmt: skip
        each = np.concatenate([ways @ inputs, (rows @ direct)[None]])
        disc = np.hypot(each[..., -5], each[..., -4]).sum(axis=0)
        by = np.maximum(by, np.insert(np.abs(each).sum(axis=0), -5, disc, axis=1))
        own = [np.abs(rows @ power) for power in within[:s]]
        own += [np.abs(ways[..., :size] @ power).sum(axis=0) for power in within[:-1]]
        left = np.maximum(left, np.sum(own, axis=0))
        begun = np.maximum(begun, np.abs(ways @ start).sum(axis=2).max(axis=0)[:, None])

    fast = gains.fast
    pairs = (fast.by, by, 1.03), (fast.steps, left, 4.0), (fast.start[:, None], begun, 1.03)
    for found, least, most in pairs:
        assert (found >= least * (1 - 1e-9)).all()
        moved = least.max(axis=0) > 0  # a memory that moves nothing has a norm all the same
        assert (found <= least * most + 1e-4)[:, moved].all()

    told = np.abs(law @ np.array(powers) @ inputs).sum(axis=0)
    told += np.abs(np.hstack([np.zeros((len(law), 2)), np.eye(len(law)), seen]))
    assert (np.delete(gains.law.by, -6, axis=1) >= told * (1 - 1e-9)).all()


def test_estimates_and_what_an_observer_remembers_are_where_the_loop_keeps_them(monkeypatch):
    """Behind commands under way; before what acts in lagging drives."""
    late = changes("""
        actuator.delay = 0.02
        actuator.lag = 0.02
        guard.enabled = false
    """)
    filtered = changes("sensor.correction = 0.5; sensor.pose_noise = 1e-3")
    setup = settle(safe(late | filtered), "kanayama")
    loop = SampledLoop(setup, V_D, partial(conditions, setup))
    given, n = {}, len(loop.names) + 2 * loop.queue + loop.memory + loop.acting
    rest = np.ones((1, n, n)), np.ones((1, n, n)), np.zeros((n, n))
    monkeypatch.setattr(room, "powers_until", lambda *_: rest)
    monkeypatch.setattr(room, "Responses", lambda *args: given.update(args=args) or 1 / 0)
    with pytest.raises(ZeroDivisionError):
        loop_gains(loop, np.zeros((n, 1)), np.zeros(len(loop.names)))
    memory = len(loop.names) + 2 * loop.queue

    assert loop.acting * loop.queue * loop.filter > 0
    assert given["args"][9] == memory + loop.memory - loop.filter
    assert given["args"][10] == memory + loop.observed[1]


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
