"""Affine forms: what a graph makes of a box as a linear map of its inputs and an error, at once.

    y = c + L xi + r',     |xi_k| <= 1,  |r'| <= r

for many boxes together.  With ``size`` at least as large as all that was added up, the rounding of
an operation is at most ROUNDING of it, and is added to r.  Both sides of an undecided choice are
enclosed by their hull, of |x|, min and max by a secant.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.checks.world import Floats
from wmr_ctrl.corridor.enclosure import OpenBoxError
from wmr_ctrl.model.graph import SELECT, read

STEEPER = (1.0, 1.1, 1.2, 1.3, 1.5, 0.0)
"""Shares of tanh's mean slope over a box that are tried."""
Truth = tuple[NDArray[np.bool_], NDArray[np.bool_]]
"""Where a condition is certain to hold, and where it is certain not to."""
ROUNDING, SUMS = 2.0**-49, 1.0 + 2.0**-40
"""Share of its size by which an operation can err, functions within 4 units of the last place;
sums of up to 8,000 numbers."""


@dataclass(frozen=True)
class Form:
    """``c`` (C), ``L`` (C, columns) or None, ``r`` (C) and ``size`` (C) of C boxes."""

    c: Floats
    L: Floats | None
    r: Floats
    size: Floats

    @property
    def radius(self) -> Floats:
        """Largest distance from c."""
        if self.L is None:
            return self.r
        return np.asarray((np.abs(self.L).sum(axis=1) + self.r) * SUMS)

    @property
    def range(self) -> tuple[Floats, Floats]:
        """Ends of an interval that holds it, with rounding."""
        radius = self.radius + np.abs(self.c) * ROUNDING
        return self.c - radius, self.c + radius


class AffineGraph:
    """A CasADi column of one column of inputs, over boxes."""

    def __init__(self, by: ca.SX, output: ca.SX) -> None:
        """Read the graph."""
        self.inputs, self.outputs = by.numel(), output.numel()
        graph = read(ca.Function("spanned", [by], [ca.densify(output)]), ["i"], ("y",))
        self._nodes = graph.nodes
        stores = {item.index: item.node for item in graph.stores}
        self._stores = [stores[k] for k in range(self.outputs)]

    def __call__(self, given: Sequence[Form]) -> list[Form]:
        """Forms of the outputs; OpenBoxError for operations without a rule."""
        done: list[Form | Truth] = []
        with np.errstate(all="ignore"):
            for node in self._nodes:
                if node.place is not None:
                    done.append(given[node.place[1]])
                elif node.op == ca.OP_CONST:
                    done.append(number(node.number, len(given[0].c)))
                elif node.op not in _RULES:
                    raise OpenBoxError(f"operation {node.op} of CasADi is not covered there")
                else:
                    done.append(_RULES[node.op](*(done[k] for k in node.operands)))
        return [_form(done[k]) for k in self._stores]


def boxes(center: Floats, radius: Floats) -> list[Form]:
    """Forms of boxes (C, n): column k is input k in units of its radius."""
    forms = []
    for k in range(center.shape[1]):
        L = np.zeros(center.shape)
        L[:, k] = radius[:, k]
        size = np.abs(center[:, k]) + radius[:, k]
        forms.append(Form(center[:, k], L, np.zeros(len(center)), size))
    return forms


def number(value: float, count: int) -> Form:
    """A constant of so many boxes."""
    c = np.full(count, float(value))
    return Form(c, None, np.zeros(count), np.abs(c))


def _form(value: Form | Truth) -> Form:
    assert isinstance(value, Form)
    return value


def _rounded(c: Floats, L: Floats | None, r: Floats, size: Floats) -> Form:
    return Form(c, L, r * (1 + ROUNDING) + size * ROUNDING, size * (1 + ROUNDING))


def _sum_of(a: Floats | None, b: Floats | None) -> Floats | None:
    if a is None or b is None:
        return b if a is None else a
    return a + b


def _times(L: Floats | None, by: Floats) -> Floats | None:
    return None if L is None else L * by[:, None]


def add(a: Form, b: Form) -> Form:
    """a + b."""
    return _rounded(a.c + b.c, _sum_of(a.L, b.L), a.r + b.r, a.size + b.size)


def _neg(a: Form) -> Form:
    return Form(-a.c, None if a.L is None else -a.L, a.r, a.size)


def _mul(a: Form, b: Form) -> Form:
    size = a.size * b.size
    if a.L is None and not a.r.any():
        return _rounded(a.c * b.c, _times(b.L, a.c), np.abs(a.c) * b.r, size)
    if b.L is None and not b.r.any():
        return _mul(b, a)
    r = np.abs(b.c) * a.r + np.abs(a.c) * b.r + a.radius * b.radius
    return _rounded(a.c * b.c, _sum_of(_times(a.L, b.c), _times(b.L, a.c)), r, size)


def _along(a: Form, slope: Floats, least: Floats, most: Floats) -> Form:
    """slope a + what lies between ``least`` and ``most``."""
    middle, half = (least + most) / 2, (most - least) / 2
    size = np.abs(slope) * a.size + np.abs(least) + np.abs(most)
    return _rounded(slope * a.c + middle, _times(a.L, slope), np.abs(slope) * a.r + half, size)


def _secant(low: Floats, high: Floats, at_low: Floats, at_high: Floats) -> Floats:
    apart = high - low > 1e-12 * (np.abs(low) + np.abs(high))
    return np.where(apart, (at_high - at_low) / np.where(apart, high - low, 1.0), 0.0)


def _abs(a: Form) -> Form:
    """By its secant, over which |x| is at its ends, and below which at 0."""
    low, high = a.range
    across = (low < 0) & (high > 0)
    slope = np.where(across, _secant(low, high, -low, high), np.where(low >= 0, 1.0, -1.0))
    ends = np.array([np.abs(low) - slope * low, np.abs(high) - slope * high])
    least = np.where(across, np.minimum(ends.min(axis=0), 0.0), 0.0)
    return _along(a, slope, least, np.where(across, ends.max(axis=0), 0.0))


def _max(a: Form, b: Form) -> Form:
    apart = add(a, _neg(b))
    low, high = apart.range
    both = _times_number(add(add(a, b), _abs(apart)), 0.5)
    return _picked((low >= 0, high <= 0), a, b, both)


def _times_number(a: Form, by: float) -> Form:
    return _mul(number(by, len(a.c)), a)


def _hull(a: Form, b: Form) -> Form:
    (al, ah), (bl, bh) = a.range, b.range
    low, high = np.minimum(al, bl), np.maximum(ah, bh)
    return _rounded((low + high) / 2, None, (high - low) / 2, np.maximum(a.size, b.size))


def _picked(truth: Truth, a: Form, b: Form, other: Form) -> Form:
    """``a`` where it is certain, ``b`` where its contrary is, else ``other``."""
    yes, no = truth
    if yes.all() or no.all():
        return a if yes.all() else b

    def of(name: str) -> Floats:
        one, two, three = (getattr(item, name) for item in (a, b, other))
        return np.where(yes, one, np.where(no, two, three))

    L = next((item.L for item in (a, b, other) if item.L is not None), None)
    if L is not None:
        parts = [np.zeros_like(L) if item.L is None else item.L for item in (a, b, other)]
        L = np.where(yes[:, None], parts[0], np.where(no[:, None], parts[1], parts[2]))
    return Form(of("c"), L, of("r"), of("size"))


def _tanh(a: Form) -> Form:
    """By the one of some slopes that leaves least, at the ends and where tanh has that slope."""
    low, high = a.range
    at = np.tanh(np.array([low, high]))
    slope = np.clip(np.outer(STEEPER, _secant(low, high, at[0], at[1])), 0.0, 1.0)
    turn = np.sqrt(1 - slope)
    place = np.arctanh(np.minimum(turn, 1 - ROUNDING))
    left = np.stack([at[0] - slope * low, at[1] - slope * high, turn - slope * place])
    inner = [
        np.where((s * place > low) & (s * place < high), s * left[2], left[0]) for s in (1, -1)
    ]
    every = np.stack([left[0], left[1], *inner])
    least, most = every.min(axis=0), every.max(axis=0)
    best = (most - least).argmin(axis=0), np.arange(len(low))
    return _along(a, slope[best], least[best] - 8 * ROUNDING, most[best] + 8 * ROUNDING)


def _curve(
    f: Callable[[Floats], Floats],
    slope: Callable[[Floats], Floats],
    bend: Callable[[Floats, Floats], Floats],
) -> Callable[[Form], Form]:
    """By the tangent at c; ``bend``: the largest |f''| on an interval."""

    def rule(a: Form) -> Form:
        k, radius = slope(a.c), a.radius
        off = bend(*a.range) * radius**2 / 2
        size = np.abs(f(a.c)) + np.abs(k) * a.size + off
        return _rounded(f(a.c), _times(a.L, k), np.abs(k) * a.r + off, size)

    return rule


def _nearest(low: Floats, high: Floats) -> Floats:
    """Least size on an interval, 0 where it holds 0."""
    return np.where((low <= 0) & (high >= 0), 0.0, np.minimum(np.abs(low), np.abs(high)))


def _below(strict: bool) -> Callable[[Form, Form], Truth]:
    def rule(a: Form, b: Form) -> Truth:
        low, high = add(a, _neg(b)).range
        return (high < 0, low >= 0) if strict else (high <= 0, low > 0)

    return rule


def _choice(truth: Truth | Form, a: Form, b: Form) -> Form:
    if isinstance(truth, Form):
        low, high = truth.range
        truth = (low > 0) | (high < 0), (low == 0) & (high == 0)
    return _picked(truth, a, b, _hull(a, b))


_inverse = _curve(
    lambda x: 1 / x, lambda x: -1 / x**2, lambda low, high: 2 / _nearest(low, high) ** 3
)
_RULES: dict[int, Callable[..., Form | Truth]] = {
    SELECT: _choice,
    ca.OP_ADD: add,
    ca.OP_SUB: lambda a, b: add(a, _neg(b)),
    ca.OP_NEG: _neg,
    ca.OP_TWICE: lambda a: add(a, a),
    ca.OP_MUL: _mul,
    ca.OP_SQ: lambda a: _mul(a, a),
    ca.OP_DIV: lambda a, b: _mul(a, _inverse(b)),
    ca.OP_INV: _inverse,
    ca.OP_FABS: _abs,
    ca.OP_FMAX: _max,
    ca.OP_FMIN: lambda a, b: _neg(_max(_neg(a), _neg(b))),
    ca.OP_TANH: _tanh,
    ca.OP_SIN: _curve(
        np.sin, np.cos, lambda low, high: np.minimum(np.maximum(np.abs(low), np.abs(high)), 1.0)
    ),
    ca.OP_COS: _curve(np.cos, lambda x: -np.sin(x), lambda low, high: np.ones_like(low)),
    ca.OP_SQRT: _curve(
        np.sqrt,
        lambda x: 0.5 / np.sqrt(x),
        lambda low, high: 0.25 * np.where(low > 0, low, 0.0) ** -1.5,
    ),
    ca.OP_LT: _below(True),
    ca.OP_LE: _below(False),
    ca.OP_NOT: lambda a: (a[1], a[0]),
    ca.OP_AND: lambda a, b: (a[0] & b[0], a[1] | b[1]),
    ca.OP_OR: lambda a, b: (a[0] | b[0], a[1] & b[1]),
}
