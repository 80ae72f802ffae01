"""Affine forms: enclosures of a graph over a box, as a linear map of its inputs plus an error.

    y = c + L xi + r',     |xi_k| <= 1,  |r'| <= r

They are expressions of the box's middle and half-widths, composed once for a graph, and CasADi
evaluates them for each box.  ``size`` is at least the sum of all absolute values added.  An
operation's rounding error is at most ROUNDING times it, and is added to r.  An undecided choice
gives NaN, since the checker refuses it anyway.

CasADi simplifies these expressions by identities of real numbers.  No bound depends on how a number
was rounded, so simplified expressions have no larger error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache, reduce

import casadi as ca
import numpy as np

from wmr_ctrl.theory.checks.error_coordinates import Floats
from wmr_ctrl.world.model.evaluate import InPlace
from wmr_ctrl.world.model.graph import SELECT, Graph, read

from .enclosure import OpenBoxError

STEEPER = (1.0, 1.1, 1.2, 1.3, 1.5, 0.0)
"""Shares of tanh's mean slope over a box that are tried."""
ROUNDING, SUMS = 2.0**-49, 1.0 + 2.0**-40
"""Share of its size by which an operation can err, functions within 4 units of the last place;
sums of up to 8,000 numbers."""


@dataclass(frozen=True)
class Form:
    """An affine form (see the module): ``c``, the row ``L`` (1, columns), ``r`` and ``size``."""

    c: ca.SX
    L: ca.SX
    r: ca.SX
    size: ca.SX

    @cached_property
    def radius(self) -> ca.SX:
        """Largest distance from c."""
        return (ca.sum2(abs(self.L)) + self.r) * SUMS

    @cached_property
    def range(self) -> tuple[ca.SX, ca.SX]:
        """Interval that contains the form's values, with rounding."""
        radius = self.radius + abs(self.c) * ROUNDING
        return self.c - radius, self.c + radius


@dataclass(frozen=True)
class Truth:
    """Whether a condition is certainly true, and whether it is certainly false."""

    yes: ca.SX
    no: ca.SX


@dataclass(frozen=True)
class Spanned:
    """Forms of C boxes: ``c``, ``r`` and ``size`` (C, outputs), ``L`` (C, outputs, inputs)."""

    c: Floats
    r: Floats
    size: Floats
    L: Floats


Rule = Callable[[list[Form]], list[Form]]
"""A map from forms to forms."""


class AffineGraph:
    """A CasADi column of one column of inputs, over boxes."""

    def __init__(self, by: ca.SX, output: ca.SX) -> None:
        """Read the graph; OpenBoxError for operations without a rule."""
        function = ca.Function("spanned", [by], [ca.densify(output)])
        graph = read(function, ["i"], ("y",))
        for node in graph.nodes:
            chosen = node.op == SELECT and graph.nodes[node.operands[0]].op != ca.OP_LT
            if chosen or not (node.leaf or node.op in _RULES):
                raise OpenBoxError(f"operation {node.op} of CasADi is not covered there")
        self._key = function.serialize()

    def __call__(self, center: Floats, radius: Floats) -> Spanned:
        """Enclose the graph over C boxes: ``center`` and ``radius`` (C, inputs)."""
        return self._boxes(center, radius)

    @cached_property
    def _boxes(self) -> OverBoxes:
        return _over_boxes(self._key)


class OverBoxes:
    """A rule over boxes, as one function of CasADi."""

    def __init__(self, count: int, rule: Rule) -> None:
        """Compose the rule once for ``count`` inputs."""
        self.count = count
        center, radius = ca.SX.sym("center", count), ca.SX.sym("radius", count)
        given = []
        for k in range(count):
            L = ca.SX(1, count)
            L[0, k] = radius[k]
            given.append(Form(center[k], L, ca.SX(0), abs(center[k]) + radius[k]))
        forms = rule(given)
        L = ca.vertcat(*(form.L for form in forms))
        rows, columns = (np.array(part, dtype=int) for part in L.sparsity().get_triplet())
        self._places, self._outputs = (rows, columns), len(forms)
        every = [ca.densify(getattr(form, k)) for k in ("c", "r", "size") for form in forms]
        box, numbers = ca.vertcat(center, radius), ca.vertcat(*every, ca.vec(L.nz[:]))
        self._function = ca.Function("over", [box], [numbers])

    def __call__(self, center: Floats, radius: Floats) -> Spanned:
        """Evaluate the rule on C boxes: ``center`` and ``radius`` (C, inputs)."""
        given, count = np.hstack([center, radius]), self._function.numel_out(0)
        box, answer = np.empty(given.shape[1]), np.empty(count)
        result = np.empty((len(given), count))
        run = InPlace(self._function, [box], [answer])
        for one, row in zip(given, result, strict=True):
            box[:] = one
            run()
            row[:] = answer
        c, r, size = (result[:, k * self._outputs :][:, : self._outputs] for k in range(3))
        L = np.zeros((len(center), self._outputs, self.count))
        L[:, *self._places] = result[:, 3 * self._outputs :]
        return Spanned(c, r, size, L)


@lru_cache(maxsize=64)
def _over_boxes(serialized: str) -> OverBoxes:
    """Compile the affine evaluation of a serialised graph, once for equal graphs."""
    function = ca.Function.deserialize(serialized)
    graph = read(function, ["i"], ("y",))
    return OverBoxes(function.numel_in(0), lambda given: _walked(graph, given))


def _walked(graph: Graph, given: list[Form]) -> list[Form]:
    done: list[Form | Truth] = []
    for node in graph.nodes:
        if node.place is not None:
            done.append(given[node.place[1]])
        elif node.op == ca.OP_CONST:
            done.append(_number(node.number, given[0].L.size2()))
        else:
            done.append(_RULES[node.op](*(done[k] for k in node.operands)))
    stores = {item.index: done[item.node] for item in graph.stores}
    return [_form(stores[k]) for k in range(len(stores))]


def _number(value: float, columns: int) -> Form:
    return Form(ca.SX(value), ca.SX(1, columns), ca.SX(0), ca.SX(abs(value)))


def _form(value: Form | Truth) -> Form:
    assert isinstance(value, Form)
    return value


def _rounded(c: ca.SX, L: ca.SX, r: ca.SX, size: ca.SX) -> Form:
    return Form(c, L, r * (1 + ROUNDING) + size * ROUNDING, size * (1 + ROUNDING))


def _add(a: Form, b: Form) -> Form:
    return _rounded(a.c + b.c, a.L + b.L, a.r + b.r, a.size + b.size)


def _neg(a: Form) -> Form:
    return Form(-a.c, -a.L, a.r, a.size)


def _mul(a: Form, b: Form) -> Form:
    r = abs(b.c) * a.r + abs(a.c) * b.r + a.radius * b.radius
    return _rounded(a.c * b.c, a.L * b.c + b.L * a.c, r, a.size * b.size)


def _picked(truth: Truth, a: Form, b: Form) -> Form:
    """``a`` if the condition is certainly true, ``b`` if certainly false, else no number."""

    def of(one: ca.SX, two: ca.SX) -> ca.SX:
        return ca.if_else(truth.yes, one, ca.if_else(truth.no, two, np.nan))

    return Form(
        *(of(*(getattr(item, name) for item in (a, b))) for name in ("c", "L", "r", "size"))
    )


def _tanh(a: Form) -> Form:
    """Enclose tanh: bound the errors of some slopes at ends and tangent points, keep the best."""
    low, high = a.range
    at_low, at_high = ca.tanh(low), ca.tanh(high)
    apart = high - low > 1e-12 * (abs(low) + abs(high))
    mean = ca.if_else(apart, (at_high - at_low) / (high - low), 0.0)
    best: tuple[ca.SX, ...] = ()
    for share in STEEPER:
        slope = ca.fmin(share * mean, 1.0)
        turn = ca.sqrt(1 - slope)
        place = ca.atanh(ca.fmin(turn, 1 - ROUNDING))
        first, last, top = at_low - slope * low, at_high - slope * high, turn - slope * place
        inner = [
            ca.if_else(ca.logic_and(s * place > low, s * place < high), s * top, first)
            for s in (1, -1)
        ]
        every = [first, last, *inner]
        new: tuple[ca.SX, ...] = slope, reduce(ca.fmin, every), reduce(ca.fmax, every)
        if best:
            less = new[2] - new[1] < best[2] - best[1]
            new = tuple(ca.if_else(less, one, two) for one, two in zip(new, best, strict=True))
        best = new
    slope, least, most = best
    size = abs(slope) * a.size + abs(least) + abs(most)
    off = (most - least) / 2 + 8 * ROUNDING
    return _rounded(slope * a.c + (least + most) / 2, a.L * slope, abs(slope) * a.r + off, size)


def _curve(
    f: Callable[[ca.SX], ca.SX],
    slope: Callable[[ca.SX], ca.SX],
    bend: Callable[[ca.SX, ca.SX], ca.SX],
) -> Callable[[Form], Form]:
    """Enclose a smooth function by its tangent at c; ``bend``: largest |f''| on an interval."""

    def rule(a: Form) -> Form:
        k, value = slope(a.c), f(a.c)
        off = bend(*a.range) * a.radius**2 / 2
        size = abs(value) + abs(k) * a.size + off
        return _rounded(value, a.L * k, abs(k) * a.r + off, size)

    return rule


def _nearest(low: ca.SX, high: ca.SX) -> ca.SX:
    """Least absolute value on an interval; 0 if it contains 0."""
    holds = ca.logic_and(low <= 0, high >= 0)
    return ca.if_else(holds, 0.0, ca.fmin(abs(low), abs(high)))


def _below(a: Form, b: Form) -> Truth:
    low, high = _add(a, _neg(b)).range
    return Truth(high < 0, low >= 0)


_inverse = _curve(
    lambda x: 1 / x, lambda x: -1 / x**2, lambda low, high: 2 / _nearest(low, high) ** 3
)
_RULES: dict[int, Callable[..., Form | Truth]] = {
    SELECT: _picked,
    ca.OP_ADD: _add,
    ca.OP_SUB: lambda a, b: _add(a, _neg(b)),
    ca.OP_NEG: _neg,
    ca.OP_TWICE: lambda a: _add(a, a),
    ca.OP_MUL: _mul,
    ca.OP_SQ: lambda a: _mul(a, a),
    ca.OP_DIV: lambda a, b: _mul(a, _inverse(b)),
    ca.OP_INV: _inverse,
    ca.OP_TANH: _tanh,
    ca.OP_SIN: _curve(ca.sin, ca.cos, lambda low, high: ca.fmax(abs(low), abs(high))),
    ca.OP_COS: _curve(ca.cos, lambda x: -ca.sin(x), lambda low, high: ca.SX(1)),
    ca.OP_LT: _below,
}
