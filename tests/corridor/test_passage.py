"""Foundations of a flowpipe: spans, the undisturbed run, sample matrices, generator sums."""

from copy import copy
from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest
from flint import arb, ctx

from tests.papers_robot import safe
from tests.tables import changes
from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.corridor import find_corridor
from wmr_proofs.corridor import elementary
from wmr_proofs.corridor.along import Along
from wmr_proofs.corridor.carried import CarriedColumns
from wmr_proofs.corridor.enclosure import Enclosure, OpenBoxError
from wmr_proofs.corridor.inputs import bounded_inputs
from wmr_proofs.corridor.midradius import MidRadius, hull
from wmr_proofs.corridor.motion import MovingCurve
from wmr_proofs.corridor.passage import Passing
from wmr_proofs.corridor.secants import SecantCurve
from wmr_proofs.corridor.spans import MidRadiusGraph
from wmr_proofs.corridor.stretch import _within

x = ca.SX.sym("x", 3)
WHOLE = ca.vertcat(
    ca.sin(x[0]) * x[1] / (2 + x[2] ** 2), ca.tanh(x[1]) - ca.exp(-x[0]), ca.fabs(x[2]) + x[0],
    ca.fmax(x[0], x[1] - x[2]), ca.sqrt(3 + x[0]), ca.if_else(x[2] > -9, ca.cos(x[1]), x[0]),
    ca.expm1(x[2]), ca.fmin(x[0], x[2]),
)  # fmt: skip


@pytest.mark.parametrize("wide", [0.0, 1e-9, 0.3])
def test_spans_hold_what_balls_of_high_precision_say(wide):
    rng = np.random.default_rng(3)
    middle, radius = rng.uniform(-2, 2, (40, 3)), wide * rng.uniform(0, 1, (40, 3))
    graph, balls = MidRadiusGraph("f", [x], WHOLE), Enclosure("f", [x], WHOLE)

    result = graph([MidRadius(middle[:, k], radius[:, k]) for k in range(3)])

    for share in (-0.999, 0.3, 0.999):
        points = middle + share * radius
        for k, row in enumerate(points):
            exact = np.array([float(v.mid()) for v in balls([arb(v) for v in row.tolist()])])
            assert (np.abs(exact - result.middle[k]) <= result.radius[k] + 1e-300).all()
    assert wide > 0 or result.radius.max() < 1e-14


EIGHT = {"reference.kind": "lemniscate", "clock.duration": 1.0,
         "changes": [{"t": 0.505, "m": 60.0}]}  # fmt: skip


@pytest.fixture(scope="module")
def eight():
    return Along(settle(safe(EIGHT), "prox"))


def test_linear_bound_is_that_of_both_ends_of_a_sample(eight):
    """It is nearly the whole bound where pushes are little."""
    little = bounded_inputs(settle(safe("disturbance.std = 1e-3"), "prox"))
    bounds = Passing(eight, little, np.zeros(3)).run(2)

    assert (bounds.linear > 0.75 * bounds.position).all()


def late_passing(law, start, **changed):
    """A passage of a loop behind a delay, not begun."""
    told = {**EIGHT, **changed, "actuator.delay": 0.02, "guard.enabled": False}
    setup = settle(safe(told), law)
    return Passing(Along(setup), bounded_inputs(setup), np.full(3, start))


def test_each_command_that_may_act_counts_in_a_sample(monkeypatch):
    passing = late_passing("mb", 0.0, **{"clock.duration": 0.1, "changes": []})
    place = slice(passing.nz, passing.nz + 2)
    monkeypatch.setattr(passing, "_left", lambda _, sizes, *given: sizes[:, place])
    passing.commands, now = np.array([[5.0, 1.0], [2.0, 3.0]]), SimpleNamespace(count=2)
    acts = passing._step(np.zeros((2, len(passing.along.rows))), np.array([[4.0, 0], [0, 9]]), now)

    assert acts.tolist() == [[5.0, 3.0], [4.0, 9.0]]


@pytest.fixture(scope="module")
def passed():
    """A passage through a whole run, with the samples at which it bounded second derivatives."""
    passing, asked = late_passing("prox", 1e-3), []

    def recorded(place, now):
        asked.append((place, now.k))
        return type(passing)._bend(passing, place, now)

    passing._bend = recorded
    return passing, passing.run(), asked


def test_each_chunk_has_second_derivatives_of_its_own(passed):
    passing, _, asked = passed
    chunks = passing.along.chunks()
    assert {(place, first) for first, _ in chunks for place in (0, 1)} <= set(asked)


def test_commands_that_may_act_later_are_those_of_the_last_samples(passed):
    passing, bounds, _ = passed
    assert len(passing.commands)
    np.testing.assert_array_equal(passing.commands, bounds.box[2][-len(passing.commands) :, :2])


def test_what_a_run_is_off_the_graphs_is_found_wherever_it_is(eight):
    other = copy(eight)
    other.fine, other.outs = eight.fine.copy(), eight.outs.copy()
    other.fine[63, 4, 3] += 1e-7
    other.outs[12, 1] -= 1e-3
    law, step = other._residuals()

    assert step[3] == pytest.approx(1e-7, rel=0.1)
    assert law[1] == pytest.approx(1e-3, rel=0.1)


def test_constants_of_series_are_within_their_radius():
    with ctx.workprec(300):
        off = float(abs(arb(2).log() - arb(float(elementary.LN_2.middle))).upper())
        far = float((1 - arb(elementary.SATURATED).tanh()).upper())
    assert 0 < off <= elementary.LN_2.radius
    assert 0 < far <= elementary.ONE_OFF


@pytest.mark.parametrize(
    "name, most", [("sine", 0.5), ("cosine", 0.5), ("exponential", 300.0),
                       ("hyperbolic_tangent", 60.0)]
)  # fmt: skip
@pytest.mark.parametrize("wide", [0.0, 1e-6, 0.02])
def test_series_hold_what_balls_say_and_are_not_much_wider(name, most, wide):
    ball = {"sine": arb.sin, "cosine": arb.cos, "exponential": arb.exp,
            "hyperbolic_tangent": arb.tanh}[name]  # fmt: skip
    rng = np.random.default_rng(9)
    near = 10.0 ** rng.uniform(-12, -1, 99)
    places = np.concatenate([rng.uniform(-most, most, 300), [0.0], near])
    places *= 1 - 2 * wide
    result = getattr(elementary, name)(MidRadius(places, wide * np.abs(places)))

    for share in (-0.9999, 0.2, 0.9999):
        points = (places * (1 + share * wide)).tolist()
        with ctx.workprec(600):
            off = [float((ball(arb(x)) - m).abs_upper())
                   for x, m in zip(points, result.middle.tolist(), strict=True)]  # fmt: skip
        assert (np.array(off) <= result.radius).all()
    if not wide:
        assert (result.radius <= 2e-13 * np.abs(result.middle) + 1e-15).all()


@pytest.mark.parametrize(
    "expr",
    [
        ca.if_else(x[0] > 0, 1.0, 2.0),
        ca.if_else(x[0], 1.0, 2.0),
        ca.if_else(ca.logic_and(x[0], x[1] > 0), 1.0, 2.0),
        ca.if_else(ca.logic_or(x[0], x[1] < 0), 1.0, 2.0),
        ca.if_else(ca.logic_not(x[0]), 1.0, 2.0),
        ca.sign(x[0]),
        ca.if_else(x[0] <= 0.5, 1.0, 2.0),
        ca.if_else(ca.eq(x[0], 0.5), 1.0, 2.0),
        ca.if_else(ca.ne(x[0], 0.5), 1.0, 2.0),
    ],
)
def test_a_condition_that_a_span_leaves_open_is_not_guessed(expr):
    graph, one = MidRadiusGraph("choice", [x], expr), MidRadius(np.ones(1))
    given = [MidRadius(np.array([0.5]), np.array([0.6])), one, one]

    for point in (0.25, 0.5, 1.0):
        value = float(ca.Function("f", [x], [expr])([point, 1.0, 1.0]))
        assert graph([MidRadius(np.array([point])), one, one]).middle == value
    with pytest.raises(OpenBoxError, match="choice"):
        graph(given)


def test_beyond_their_largest_argument_series_are_not_used():
    graph = MidRadiusGraph("f", [x], ca.vertcat(ca.sin(x[0]), ca.cos(x[0])))
    found = graph([MidRadius(np.array([2.5]))] * 3)

    assert (np.abs(found.middle - [np.sin(2.5), np.cos(2.5)]) <= found.radius + 1e-15).all()
    assert found.radius.max() < 1e-14


def test_a_chord_is_as_unsure_as_its_less_sure_end():
    for ends in ((0.3, 0.5), (0.5, 0.3)):
        radius = np.zeros((1, 4, 2, 6))
        radius[:, [0, 3]] = np.reshape(ends, (2, 1, 1))
        within = _within(MidRadius(0 * radius, radius), 2, 0, 3)

        assert all((part >= 0.5).all() for part in within.apart)


def test_products_of_long_rows_count_the_rounding_of_all_their_terms():
    rng = np.random.default_rng(6)
    a, b = (rng.normal(size=(1, n, m)) for n, m in ((3, 4000), (4000, 3)))
    product = MidRadius(a, np.zeros_like(a)) @ MidRadius(b, np.zeros_like(b))

    for i, k in np.ndindex(3, 3):
        exact = sum((arb(p) * arb(q) for p, q in zip(a[0, i].tolist(), b[0, :, k].tolist(),
                                                     strict=True)), arb(0))  # fmt: skip
        assert abs(float(exact.mid()) - product.middle[0, i, k]) <= product.radius[0, i, k]
    assert product.radius.min() > 4000 * 2.0**-53 * 1000


def test_a_loop_with_more_numbers_than_rounding_is_counted_for_is_refused():
    told = changes("actuator.delay = 0.5; guard.enabled = false")
    for kind in ("circle", "lemniscate"):
        scenario = safe({**told, "reference.kind": kind})
        assert (
            "rounding is counted for 100 at most"
            in find_corridor(scenario, "prox", whole=True).refused
        )


@pytest.mark.parametrize("wide", [1e-4, 0.02, 0.3])
def test_secants_leave_no_more_than_they_say(wide):
    """The graph's tanh turns over within the box; start points are any of the undisturbed loop."""
    by, number, rng = ca.SX.sym("by", 2), ca.SX.sym("number"), np.random.default_rng(7)
    output = ca.vertcat(number * ca.tanh(by[0] / 0.01) + by[1] ** 2, ca.sin(by[1]) * by[0])
    curve = MovingCurve("f", by, number, output, (slice(1), 1.0))
    plain = ca.Function("f", [by, number], [output])
    points = rng.uniform(-0.02, 0.02, (1, 5, 2))
    found = np.array([[plain(point, 2.0).full().ravel() for point in points[0]]])
    result = SecantCurve(curve).over(
        hull(points, 1), MidRadius(np.array([[2.0]]), np.zeros((1, 1))), np.full(2, wide), points,
        found,
    )  # fmt: skip

    most = np.zeros(2)
    for point, value in zip(points[0], found[0], strict=True):
        for off in [*rng.uniform(-wide, wide, (200, 2)), *(wide * np.array([[1, 1], [-1, 1]]))]:
            here = plain(point + off, 2.0).full().ravel()
            most = np.maximum(most, np.abs(here - value - result.slopes.middle[0] @ off))
    assert (most <= result.left[0]).all()
    assert wide < 0.01 or most[0] > result.left[0, 0] / 4


def test_sums_in_single_precision_are_not_below_those_in_double():
    rng = np.random.default_rng(5)
    sizes = 10 ** rng.uniform(-9, 3, (4, 1))
    values, weight = sizes[..., None] * rng.normal(size=(4, 9, 50)), rng.random((9, 50))
    weight[7:] = 1.0
    carried = CarriedColumns(np.arange(50), values, weight, (2, 7))
    rows = rng.normal(size=(3, 30, 4))

    linear, result = carried.sums(rows, carried.sizes)

    every = np.einsum("jrn,nmk->jrmk", rows, values * weight)
    known, bent, pairs = np.split(every, [2, 7], axis=2)
    exact = np.abs(known).sum(axis=(-1, -2)) + np.hypot(pairs[:, :, 0], pairs[:, :, 1]).sum(axis=-1)
    assert (linear >= exact).all()
    assert linear == pytest.approx(exact, rel=1e-3)
    exact += np.abs(bent).sum(axis=(-1, -2))
    assert (result >= exact).all()
    assert result == pytest.approx(exact, rel=1e-3)


def test_columns_of_some_samples_stand_for_those_between():
    """Their rows, plus a box, reach at least as far as all columns, and little farther."""
    rng, times = np.random.default_rng(8), 0.03 * np.arange(40)
    turn, grow = rng.normal(size=(2, 4, 3))
    courses = np.array([[g * np.exp(-t) * np.cos(3 * t + a) for t in times]
                        for a, g in zip(turn.T, grow.T, strict=True)])  # fmt: skip
    values, weight = courses[:, :, :3].transpose(2, 0, 1), 0.5 + rng.random((3, 40))
    before = CarriedColumns(10 + np.arange(40), values, weight, (0, 3))

    after, off = before.thinned(15, 38, 4)

    rows = rng.normal(size=(500, 3))
    far, farther = (np.abs(rows @ (item.values * item.weight).reshape(3, -1)).sum(axis=1)
                    for item in (before, after))  # fmt: skip
    assert len(after.born) == 40 - 24 + 7
    assert (farther + np.abs(rows) @ off >= far).all()
    assert (farther + np.abs(rows) @ off <= 1.1 * far).all()
    assert after.born.tolist() == sorted(set(after.born.tolist()))


def test_a_loop_that_forgets_before_a_block_ends_is_followed(monkeypatch):
    """It has fewer columns than a block has samples if a change cuts a block short."""
    monkeypatch.setattr("wmr_proofs.corridor.along.forgets", lambda *_: 12)
    told = changes("""
        clock.duration = 1.5
        changes = [{t = 0.533, m = 31.0}]
        disturbance.std = 2e-4
    """)
    along = Along(settle(safe(told), "prox"))
    assert along.memory < along.batch

    bounds = Passing(along, bounded_inputs(along.setup), np.zeros(3)).run()

    assert len(bounds.position) == 150
    assert (bounds.share <= 1).all()
