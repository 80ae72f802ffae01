"""Check a corridor's certificate: the fixed-point inequality, and the limits on its box.

It imports none of `wmr_proofs.corridor`.  Gradients and second derivatives of the two graphs are
evaluated in balls of python-flint; powers of the sample's matrix are in doubles, and what their
rounding and their end leave is one more input of every sample.  If Q sums up |A^j| so computed, P
bounds what each step of that left out, and p* >= p + P p*, then an input p adds at most Q p*.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, pi, sin

import casadi as ca
import numpy as np
from flint import arb, ctx
from numpy.typing import NDArray

from wmr_ctrl.world.model.graph import SELECT, read

Floats = NDArray[np.float64]
Balls = NDArray[np.object_]
BITS, LONGEST, LEFT = 192, 40_000, 1e-10
"""Precision of balls; most samples, and the share of a deviation at which the sums end."""
UNIT, OUT = 2.0**-46, 1 + 1e-10
"""Share by which a sum of 60 products in doubles errs at most; that of long sums, all >= 0."""
DIRECTIONS, ROBOT, COMMAND = 16, 5, 2


class RefusedError(ArithmeticError):
    """The certificate is refused: the reason as a clause."""


@dataclass(frozen=True)
class Certificate:
    """A corridor's statement as plain data.

    ``law`` and ``step``: graphs of one column each, near ``law_at`` and ``step_at``; ``sizes``: the
    graph of the conditions' limits.  A state has the fast state, ``queue`` commands sent,
    ``memory`` and ``acting``; the law's outputs are command, memory, acting, and conditions'
    values.  ``rest``: the outputs on the reference, without the latter.  A sample has ``steps``
    plant steps; a command acts ``late`` steps later.  In the next ones a ``share`` of the earlier
    command acts, off by ``off`` of the difference.

    Inputs: ``push`` (2), ``pose``, ``reckoned`` (3), ``velocity`` (2), ``body`` (2), ``command``
    (2): error of an acting command, and ``dead`` (2): further error if it may be that small.
    ``law_gap`` and ``step_gap``: further errors on the reference.  ``start`` (n, any): initial
    deviations; ``disc``: radius of one more, and its place in the state.  ``lower`` (conditions):
    what measurement errors take from the limits.

    ``fast``, ``state``, ``out``: the box, of rows (elements, directions, sums and differences with
    ``ratios`` of pairs) of the fast state, the state at samples, and the law's outputs.
    """

    law: ca.Function
    step: ca.Function
    sizes: ca.Function
    law_at: Floats
    step_at: Floats
    rest: Floats
    queue: int
    memory: int
    acting: int
    steps: int
    late: int
    share: Floats
    off: Floats
    push: Floats
    pose: float
    reckoned: Floats
    velocity: Floats
    body: Floats
    command: Floats
    dead: Floats
    law_gap: Floats
    step_gap: Floats
    start: Floats
    disc: tuple[float, int]
    lower: Floats
    ratios: Floats
    fast: Floats
    state: Floats
    out: Floats


def _decided(yes: bool, no: bool) -> bool:
    if yes == no:
        raise RefusedError("a condition is undecided on its box")
    return yes


def _flag(yes: bool, no: bool) -> arb:
    return arb(int(_decided(yes, no)))


_RULES: dict[int, Callable[..., arb]] = {
    SELECT: lambda c, a, b: a if _decided(c != 0, c == 0) else b,
    ca.OP_LT: lambda a, b: _flag(a < b, a >= b),
    ca.OP_LE: lambda a, b: _flag(a <= b, a > b),
    ca.OP_EQ: lambda a, b: _flag(a == b, a != b),
    ca.OP_NE: lambda a, b: _flag(a != b, a == b),
    ca.OP_NOT: lambda a: _flag(a == 0, a != 0),
    ca.OP_AND: lambda a, b: _flag(a != 0 and b != 0, a == 0 or b == 0),
    ca.OP_OR: lambda a, b: _flag(a != 0 or b != 0, a == 0 and b == 0),
    ca.OP_SIGN: lambda a: 2 * _flag(a > 0, a < 0) - 1,
    ca.OP_ADD: lambda a, b: a + b,
    ca.OP_SUB: lambda a, b: a - b,
    ca.OP_MUL: lambda a, b: a * b,
    ca.OP_DIV: lambda a, b: a / b,
    ca.OP_INV: lambda a: 1 / a,
    ca.OP_NEG: lambda a: -a,
    ca.OP_SQ: lambda a: a * a,
    ca.OP_TWICE: lambda a: a + a,
    ca.OP_SQRT: arb.sqrt,
    ca.OP_EXP: arb.exp,
    ca.OP_EXPM1: arb.expm1,
    ca.OP_SIN: arb.sin,
    ca.OP_COS: arb.cos,
    ca.OP_TANH: arb.tanh,
    ca.OP_FABS: abs,
    ca.OP_FMIN: arb.min,
    ca.OP_FMAX: arb.max,
}


def _evaluated(by: ca.SX, outputs: list[ca.SX], at: list[arb]) -> list[arb]:
    """All non-zero entries of some outputs, one after the other."""
    every = ca.vertcat(*(ca.vec(item.nz[:]) for item in outputs))
    graph = read(ca.Function("checked", [by], [every]), ["i"], ("y",))
    done: list[arb] = []
    for node in graph.nodes:
        if node.place is not None:
            done.append(at[node.place[1]])
        elif node.op == ca.OP_CONST:
            done.append(arb(node.number))
        elif node.op in _RULES:
            done.append(_RULES[node.op](*(done[k] for k in node.operands)))
        else:
            raise RefusedError(f"operation {node.op} of CasADi has no rule")
    stores = {item.index: done[item.node] for item in graph.stores}
    result = [stores[k] for k in range(len(stores))]
    if not all(item.is_finite() for item in result):
        raise RefusedError("an operation leaves its domain on its box")
    return result


def _most(value: arb) -> float:
    return float(value.abs_upper()) * (1 + 2**-50)


class _Graph:
    """Value, gradient and second derivatives of a graph."""

    def __init__(self, function: ca.Function, at: Floats) -> None:
        self.by = ca.SX.sym("by", len(at))
        self.output = ca.densify(function(self.by))
        self.slope = ca.jacobian(self.output, self.by)
        self.at = at

    def linear(self) -> tuple[list[arb], Balls]:
        """Values (outputs) and gradients (outputs, inputs) at the point."""
        count = self.output.numel()
        point = [arb(x) for x in self.at.tolist()]
        every = _evaluated(self.by, [self.output, self.slope], point)
        matrix = _zeros(count, len(self.at))
        rows, columns = self.slope.sparsity().get_triplet()
        for i, j, value in zip(rows, columns, every[count:], strict=True):
            matrix[i, j] = value
        return every[:count], matrix

    def remainders(self, sizes: Floats, products: Floats) -> Floats:
        """Largest sums of second order on a box of ``sizes``, by ``products`` of deviations."""
        bent = ca.jacobian(ca.vec(self.slope.nz[:]), self.by)
        pairs = zip(self.at.tolist(), (sizes * OUT).tolist(), strict=True)
        with ctx.workprec(53):
            box = [arb(x, r) for x, r in pairs]
            every = _evaluated(self.by, [bent, self.slope, self.output], box)
        first = list(zip(*self.slope.sparsity().get_triplet(), strict=True))
        result = np.zeros(self.output.numel())
        for place, k, value in zip(*bent.sparsity().get_triplet(), every, strict=False):
            i, j = first[place]
            result[i] += 0.5 * _most(value) * products[j, k]
        return result * OUT


def _zeros(rows: int, columns: int) -> Balls:
    block = np.empty((rows, columns), dtype=object)
    block[...] = arb(0)
    return block


def _doubles(matrix: Balls) -> Floats:
    """Midpoints, each within UNIT of all numbers of its ball."""
    result = np.array([[float(x.mid()) for x in row] for row in matrix])
    wide = np.array([[_most(x - float(x.mid())) for x in row] for row in matrix])
    if not (wide <= UNIT / 4 * np.abs(result) + 1e-40).all():
        raise RefusedError("a matrix takes more bits than balls have here")
    return result


def _rows(size: int, ratios: Floats) -> Floats:
    """Elements, directions of the position, and sums and differences of pairs of deviations."""
    rows = [*np.eye(size)]
    for angle in (k * pi / DIRECTIONS for k in range(DIRECTIONS)):
        rows.append(cos(angle) * rows[0] + sin(angle) * rows[1])
    pairs = [(a, b) for a in range(ROBOT) for b in range(a + 1, ROBOT)]
    for (a, b), ratio in zip(pairs, ratios, strict=True):
        rows += [rows[a] + sign * ratio * rows[b] for sign in (1, -1)]
    return np.array(rows)


class _Sample:
    """Matrices of one sample: the next state and the fast state within it, by state and inputs."""

    def __init__(self, c: Certificate, law: Balls, step: Balls, order: list[int]) -> None:
        n, nz = len(c.state), len(step)
        late, outs = COMMAND * len(c.share), COMMAND + c.memory + c.acting
        self.law = _zeros(len(law), n)
        self.law[:, order] = law
        unit = _zeros(n + 2 * COMMAND + late, n + 2 * COMMAND + late)
        np.fill_diagonal(unit, arb(1))
        sent = [unit[n : n + COMMAND]]
        sent += [unit[nz + COMMAND * k : nz + COMMAND * (k + 1)] for k in range(c.queue)]
        now, courses = unit[:nz], []
        for s in range(c.steps + 1):
            courses.append(now)
            age, phase = divmod(c.late - s + c.steps - 1, c.steps)[0], (s - c.late) % c.steps
            acts = sent[age]
            if phase < len(c.share):
                share, first = arb(c.share[phase]), n + 2 * COMMAND + COMMAND * phase
                acts = (1 - share) * acts + share * sent[age + 1] + unit[first : first + COMMAND]
            push = unit[n + COMMAND : n + 2 * COMMAND]
            now = step[:, :nz] @ now + step[:, nz : nz + COMMAND] @ acts
            now = now + step[:, nz + COMMAND : nz + 2 * COMMAND] @ push
        seen = law[:, :ROBOT]

        def closed(rows: Balls) -> Balls:
            """Rows by state, push, errors of the law's outputs, late commands, measurements."""
            command = rows[:, n : n + COMMAND]
            errors = np.hstack([command, _zeros(len(rows), outs - COMMAND)])
            state = rows[:, :n] + command @ self.law[:COMMAND]
            push, lates = rows[:, n + COMMAND : n + 2 * COMMAND], rows[:, n + 2 * COMMAND :]
            return np.hstack([state, push, errors, lates, command @ seen[:COMMAND]])

        self.within = [_doubles(closed(rows)) for rows in courses[:-1]]
        none = _zeros(outs - COMMAND, COMMAND + outs + late)
        kept = np.hstack([self.law[COMMAND:outs], none, seen[COMMAND:outs]])
        for k in range(outs - COMMAND):
            kept[k, n + 2 * COMMAND + k] = arb(1)
        whole = np.vstack([closed(np.vstack([courses[-1], *sent[: c.queue]])), kept])
        self.A, self.E = np.split(_doubles(whole), [n], axis=1)
        power, self.sums, self.signed = unit[:nz, :nz], [np.zeros((nz, nz))], [_zeros(nz, nz)]
        for _ in range(c.steps):
            self.sums.append((self.sums[-1] + np.abs(_doubles(power))) * OUT)
            self.signed.append(self.signed[-1] + power)
            power = step[:, :nz] @ power


def check(c: Certificate) -> tuple[float, float]:
    """Position [m] and heading [rad] that no deviation exceeds; RefusedError if not shown."""
    with ctx.workprec(BITS):
        return _checked(c)


def _checked(c: Certificate) -> tuple[float, float]:
    law, step = _Graph(c.law, c.law_at), _Graph(c.step, c.step_at)
    shown, by_law = law.linear()
    moved, by_step = step.linear()
    nz, outs, n = len(moved), len(c.rest), len(c.state)
    queue = nz + COMMAND * c.queue
    order = [*range(ROBOT), *range(queue, queue + c.memory), *range(nz, queue),
             *range(queue + c.memory, n)]  # fmt: skip
    sample = _Sample(c, by_law, by_step, order)
    sizes = [c.fast, c.state, c.out, c.push, c.reckoned, c.velocity, c.body, c.command, c.dead]
    if not all((part >= 0).all() and np.isfinite(part).all() for part in sizes) or c.pose < 0:
        raise RefusedError("a size is negative or no number")

    limits = _evaluated(law.by, [ca.densify(c.sizes(law.by))], [arb(x) for x in c.law_at.tolist()])
    level = np.array([_most(x) for x in shown[outs:]])
    room = np.array([float(x.lower()) for x in limits]) * (1 - 2**-50) - c.lower * OUT
    if not ((level + c.out[outs:]) * (1 + 2**-50) <= room).all():
        raise RefusedError("a limit may act on its box")

    products = np.outer(c.fast[:ROBOT], c.fast[:ROBOT])
    sums = c.fast[nz + DIRECTIONS :].reshape(-1, 2).max(axis=1) ** 2 / (4 * c.ratios)
    pairs = [(a, b) for a in range(ROBOT) for b in range(a + 1, ROBOT)]
    for (a, b), most in zip(pairs, sums, strict=True):
        products[a, b] = products[b, a] = min(products[a, b], most)
    error = np.array([c.pose + c.reckoned[0], c.pose + c.reckoned[1], c.reckoned[2], *c.velocity])
    mixed = np.outer(c.fast[:ROBOT], error)
    seen = c.state[order]
    seen[:ROBOT] = c.fast[:ROBOT] + error
    by_seen = np.outer(seen, seen)
    by_seen[:ROBOT, :ROBOT] = products + mixed + mixed.T + np.outer(error, error)
    off = law.remainders(seen, by_seen * OUT)
    off[:outs] += [_most(a - x) for a, x in zip(shown, c.rest.tolist(), strict=False)]
    off[:outs] += c.law_gap
    acts = np.abs(c.rest[:COMMAND]) - c.out[:COMMAND] - c.command > c.dead
    off[:COMMAND] += c.command + np.where(acts, 0.0, c.dead)
    there = np.concatenate([c.fast[:nz], c.out[:COMMAND], c.push, c.body])
    by_there = np.outer(there, there)
    by_there[:ROBOT, :ROBOT] = products
    added = np.array(
        [float((a - x).mid()) for a, x in zip(moved, c.step_at.tolist(), strict=False)]
    )
    each = step.remainders(there, by_there * OUT) + c.step_gap
    each += [
        _most(a - x - y) for a, x, y in zip(moved, c.step_at.tolist(), added.tolist(), strict=False)
    ]
    each += np.array([[_most(x) for x in row[-COMMAND:]] for row in by_step]) @ c.body
    each, off = each * OUT, off * OUT
    changes = (level[-COMMAND:] + c.out[-COMMAND:] + 2 * (c.command + c.dead)) * OUT
    given = np.concatenate([c.push, off[:outs], (c.off * changes).ravel(), error])
    return _summed(c, sample, given, each, off, added)


def _summed(
    c: Certificate, sample: _Sample, given: Floats, each: Floats, off: Floats, added: Floats
) -> tuple[float, float]:
    """Verify the fixed-point inequality: inputs, increments ``each``, errors ``off`` of the law."""
    n, nz, m = len(c.state), len(each), len(given)
    column = np.array([[arb(x)] for x in added.tolist()], dtype=object)
    steady = [_doubles(item @ column)[:, 0] for item in sample.signed]
    box = np.concatenate([sample.sums[-1] @ each, np.zeros(n - nz)])
    begun = np.hstack([c.start, c.disc[0] * np.eye(n)[:, c.disc[1] : c.disc[1] + 2]])
    columns = np.hstack(
        [sample.E, np.eye(n), begun, np.concatenate([steady[-1], np.zeros(n - nz)])[:, None]]
    )
    weights = np.concatenate([given, box, np.ones(begun.shape[1] + 1)])
    scale, course = c.state + 1e-12, [columns]
    unit = slice(m, m + n)
    while (np.abs(course[-1][:, unit]) @ scale > LEFT * scale).any():
        course.append(sample.A @ course[-1])
        if (
            len(course) > LONGEST
            or not np.isfinite(course[-1]).all()
            or np.abs(course[-1]).max() > 1e9
        ):
            raise RefusedError("the loop does not come to rest")
    ways, A = np.array(course), np.abs(sample.A)
    total = np.abs(ways).sum(axis=0)
    lost = (UNIT * A @ total + A @ np.abs(ways[-1])) * OUT
    own = lost @ weights + UNIT * (
        A @ c.state + np.abs(sample.E) @ given + sample.sums[-1] @ each @ np.eye(nz, n)
    )
    rest = own = own * OUT
    for _ in range(40):
        rest = (own + lost[:, unit] @ rest) * OUT
    if not ((own + lost[:, unit] @ rest) * (1 + 1e-12) <= rest).all():
        raise RefusedError("what rounding leaves grows")
    weights[unit] += rest

    def reach(rows: Floats, direct: Floats, beside: Floats, constant: Floats) -> Floats:
        """Largest values of rows of the state; ``direct`` inputs act on the rows without delay."""
        seen = rows @ ways
        size, disc = np.abs(seen), m - ROBOT
        position = np.hypot(seen[..., disc], seen[..., disc + 1]).sum(axis=0) * c.pose
        position += np.hypot(direct[:, disc], direct[:, disc + 1]) * c.pose
        alone = weights.copy()
        alone[disc : disc + 2] -= c.pose * (1 - 2 * UNIT)
        forced = size[..., : m + n].sum(axis=0) @ alone[: m + n] + position
        start = size[..., m + n : -3].sum(axis=2) + np.hypot(size[..., -3], size[..., -2])
        still = np.abs(np.cumsum(np.vstack([constant, seen[..., -1]]), axis=0)).max(axis=0)
        rough = np.abs(rows) @ (total @ weights + c.state) * UNIT
        return (
            forced + start.max(axis=0) + still + np.abs(direct) @ alone[:m] + beside + rough
        ) * OUT

    rows, most = _rows(nz, c.ratios), np.zeros(len(c.fast))
    for s, part in enumerate(sample.within):
        now, direct = np.split(rows @ part, [n], axis=1)
        own = np.abs(rows) @ sample.sums[s] @ each
        most = np.maximum(most, reach(now, direct, own, rows @ steady[s]))
    nothing = np.zeros((n, m))
    state = reach(np.eye(n), nothing, np.zeros(n), np.zeros(n))
    shown = _doubles(sample.law)
    direct = np.zeros((len(shown), m))
    order = np.abs(np.array([[_most(x) for x in row[:ROBOT]] for row in sample.law]))
    direct[:, m - ROBOT :] = order
    out = reach(shown, direct, off, np.zeros(len(shown)))
    parts = (most, c.fast, "fast state"), (state, c.state, "state"), (out, c.out, "law's outputs")
    for found, claimed, name in parts:
        if not (found <= claimed).all():
            k = int((found / np.maximum(claimed, 1e-300)).argmax())
            raise RefusedError(f"{name} {k + 1} reaches {found[k]:.6g} of {claimed[k]:.6g}")
    position = most[nz : nz + DIRECTIONS].max() / cos(pi / (2 * DIRECTIONS)) * OUT
    return float(position), float(most[2])
