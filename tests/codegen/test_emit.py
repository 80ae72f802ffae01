"""The emitter on random graphs, loops and branches: the bits of their instructions."""

import re

import casadi as ca
import numpy as np
import pytest

from tests.codegen.compiled import compiled, machine, made
from wmr_ctrl.codegen.emit import definition, split

INPUTS = 6


def assert_same_bits(item, step, draws):
    """A compiled kernel gives what its instructions give, for each draw of its inputs."""
    wanted = machine(item)
    for given in draws:
        assert (step(*given) == wanted(*given)).all(), item.name


def random_graph(name, seed):
    """A few hundred operations: arithmetic, calls, comparisons, choices inside choices."""
    draw = np.random.default_rng(seed)
    x = ca.SX.sym("x", INPUTS)
    pool = [x[i] for i in range(INPUTS)] + [ca.SX(0.5), ca.SX(-2.0)]

    def pick():
        return pool[-1 - min(int(draw.geometric(0.08)), len(pool)) + 1]

    def guarded(value):
        return 1 + value * value

    def condition():
        first = pick() < pick()
        kind = draw.integers(4)
        return (first, ca.logic_not(first), ca.logic_and(first, pick() <= pick()),
                ca.logic_or(first, pick() > 0))[kind]  # fmt: skip

    makers = (
        lambda: pick() + pick(),
        lambda: pick() - pick(),
        lambda: 0.5 * pick() * ca.cos(pick()),
        lambda: pick() / guarded(pick()),
        lambda: ca.sqrt(guarded(pick())) - ca.log(guarded(pick())),
        lambda: ca.exp(-guarded(pick())),
        lambda: ca.fmin(pick(), pick()) + ca.fmax(pick(), 0.25),
        lambda: ca.fabs(pick()) - ca.sign(pick()),
        lambda: ca.if_else(condition(), ca.sin(pick()), pick() / guarded(pick())),
        lambda: ca.if_else(condition(), ca.if_else(condition(), ca.exp(-guarded(pick())), 1), 0),
        lambda: ca.if_else(condition(), condition(), condition()) * pick(),
    )
    for _ in range(160):
        pool.append(makers[draw.integers(len(makers))]() / 2)
    return made(ca.vertcat(*pool[-12:]), name, x=x)


@pytest.mark.parametrize("native", [False, True])
@pytest.mark.slow
def test_random_graphs_equal_their_instructions_to_the_bit(native):
    kernels = [random_graph(f"random{seed}", seed) for seed in range(3)]
    draw = np.random.default_rng(1)
    branches = 0
    for item, step in zip(kernels, compiled(kernels, native=native), strict=True):
        branches += definition(item).count("if (")
        scales = 10.0 ** draw.integers(-3, 3, (40, 1))
        assert_same_bits(item, step, (draw.normal(size=(40, INPUTS)) * scales)[:, None])
    assert branches > 2 * len(kernels)


def network(lanes=8):
    """Tensor product, product with weights in lanes, update: the shape of the network law."""
    W, z = ca.SX.sym("x", 128), ca.SX.sym("u", 5)
    basis = [ca.exp(-z[4])]
    for i in range(6):
        low, high = ca.exp(-z[i % 4] * (i + 1)), ca.exp(z[i % 4] / (i + 1))
        basis = [b * low for b in basis] + [b * high for b in basis]
    outputs = []
    for axis in range(2):
        w = W[64 * axis : 64 * axis + 64]
        sums = [sum(w[j] * basis[j] for j in range(lane, 64, lanes)) for lane in range(lanes)]
        outputs.append(sum(sums))
    following = [0.99 * W[j] - z[j // 64] * basis[j % 64] for j in range(128)]
    return made(ca.vertcat(*outputs, *following), u=z, x=W)


@pytest.mark.parametrize("lanes", [8, 16])
@pytest.mark.slow_but("8")
def test_loops_equal_their_instructions_to_the_bit(lanes):
    item = network(lanes)
    draw = np.random.default_rng(0)
    draws = zip(draw.normal(size=(10, 5)), draw.normal(size=(10, 128)), strict=True)
    assert_same_bits(item, compiled([item])[0], draws)


def test_networks_become_short_loops():
    text = definition(network())

    assert text.count("for (int j = 0; j < 64; ++j)") == 2
    assert text.count("for (int j = 0; j < 8; ++j)") >= 2
    assert len(text.splitlines()) < 120


@pytest.mark.parametrize("whole, prepared", [(False, 1), (True, 2)])
def test_cheap_values_of_parameters_are_prepared_only_where_all_are(whole, prepared):
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    before, _ = split(made(ca.vertcat(x * (p + 1), x * ca.sin(p)), x=x, p=p).graph, whole=whole)

    assert len(before.stores) == prepared


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.slow_but("0", "3")
def test_runs_of_any_shape_keep_their_values(seed):
    """Shuffled, shifted and reversed operands; runs that read results of other runs."""
    draw = np.random.default_rng(seed)
    x = ca.SX.sym("x", 40)
    rows = [ca.vertsplit(x)]
    for _ in range(8):
        before, width = rows[-1], int(draw.integers(8, 24))
        first, second = draw.integers(0, max(1, len(before) - width), 2)
        order = draw.permutation(width) if draw.uniform() < 0.3 else np.arange(width)
        other = before if draw.uniform() < 0.6 else rows[0]
        row = []
        for j in range(min(width, len(before) - max(first, second))):
            left, right = before[first + j], other[(second + order[j]) % len(other)]
            row.append((left + right, left * right, left - right)[seed % 3] / 2)
        rows.append(row if len(row) > 3 else before)
    item = made(ca.vertcat(*rows[-1], *rows[3]), x=x)
    assert_same_bits(item, compiled([item])[0], draw.normal(size=(20, 1, 40)))


def once(x, k):
    """A loop that is read once."""
    return ca.vertcat(*(k * x[j] + 1 for j in range(16)))


def one_more(x, k):
    """A loop of which something else reads one element."""
    scaled = [x[i] * k for i in range(16)]
    return ca.vertcat(*(part + 1 for part in scaled), ca.sin(scaled[3]))


def halves(x, k):
    """A loop whose halves are each read by another loop, which begins where that half does."""
    whole = [(x[i] + k) * x[i] for i in range(16)]
    return ca.vertcat(*(part - k for part in whole[:8]), *(part / 3 for part in whole[8:]))


@pytest.mark.parametrize("outputs, kept", [(once, False), (one_more, True), (halves, False)])
def test_a_loop_keeps_its_array_where_something_else_reads_it(outputs, kept):
    x, k = ca.SX.sym("x", 16), ca.SX.sym("k")
    item = made(outputs(x, k), x=x, k=k)
    draw = np.random.default_rng(4).normal(size=17)

    assert ("sin(" in definition(item)) is kept
    assert ("double a" in definition(item)) is kept
    assert_same_bits(item, compiled([item])[0], [(draw[:16], draw[16:])])


def test_choices_on_one_condition_share_a_branch_and_compute_the_chosen_side_alone():
    x = ca.SX.sym("x", 2)
    free = x[0] > 0
    outputs = [ca.if_else(free, ca.exp(x[1]) + k, ca.log(x[1]) + k) for k in range(5)]
    before, _, branches = definition(made(ca.vertcat(*outputs), x=x)).partition("if (")
    first, _, second = branches.partition("} else {")

    assert [text.count("exp(") for text in (before, first, second)] == [0, 1, 0]
    assert [text.count("log(") for text in (before, first, second)] == [0, 0, 1]
    assert "if (" not in branches


def test_repeated_division_by_a_parameter_is_multiplication():
    u, p = ca.SX.sym("u", 3), ca.SX.sym("p")
    item = made(u / (2 * p), u=u, p=p)
    draw = np.random.default_rng(0)

    assert definition(item).count(" / ") == 1
    (step,), wanted = compiled([item]), machine(item)
    for _ in range(20):
        given = draw.normal(size=3), draw.uniform(0.1, 3, 1)
        assert step(*given) == pytest.approx(wanted(*given), rel=4e-16)


def test_what_parameters_make_alone_leaves_the_kernel():
    x, p = ca.SX.sym("x"), ca.SX.sym("p", 2)
    item = made(x / ca.sqrt(p[0]) + p[1], prepared=True, x=x, p=p)
    length, before, rest = re.match(r"(#.*\n)([\s\S]*?\n}\n)\n([\s\S]*)", definition(item)).groups()

    assert length == "#define WMR_MADE_PREPARED 1\n"
    for slow in ("wmr_sqrt", " / "):
        assert slow in before
        assert slow not in rest
    assert "p[1]" in rest
