"""Regions of a claim (each a `Case`), and the charts of one axis of the barrier.

A case is given as a chart of free positive numbers onto the region: ``values`` maps the chart's
numbers to the inputs that it fixes, in any arithmetic (rationals, z3, fraction fields), so that the
cover of a domain by its cases can itself be proved.

On an axis v_c0 lies in one of 7 or 11 places, v in one of 5 or 7.  u2 > 0 and the width
b = u1 - u2 > 0 are free, so every case holds for all 0 < v_u2 < v_u1.  Each interval is the image
of a positive number n under n/(1 + n); beyond u2 + 1/b the target is written by the gap
d = u1 - |v_c1|, which makes every root rational: v_c0 = u1 - d + 1/d (less 1/b for the smooth
barrier).
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product
from typing import Any, TypeAlias

POSITIVE, NONNEGATIVE, NONZERO, FREE = "> 0", ">= 0", "!= 0", "any"
Domains: TypeAlias = dict[str, str]
"""What each number may be, by name."""
Values: TypeAlias = dict[str, Any]
"""Numbers of a chart, or the inputs that it fixes, by name."""
_SAMPLES = tuple(map(Fraction, ("1/2", "3/5", "7/4", "2/7", "5/3", "11/13")))


@dataclass(frozen=True)
class Case:
    """Numbers of the chart with their domains, and the inputs as functions of them."""

    label: str
    numbers: Domains = field(default_factory=dict)
    values: Callable[[Values], Values] = lambda _: {}
    declared: Domains = field(default_factory=dict)

    def sample(self, names: tuple[str, ...], shift: int) -> dict[str, Fraction]:
        """A rational point of the case, with a value for each input in ``names``."""
        chart = {name: _sample(k + shift) for k, name in enumerate(self.numbers)}
        fixed = self.values(chart)
        point = {name: Fraction(fixed[name]) for name in names if name in fixed}
        for k, name in enumerate(n for n in names if n not in fixed):
            signed = self.declared.get(name, FREE) in (FREE, NONZERO)
            sign = -1 if signed and not (k + shift) % 3 else 1
            point[name] = sign * _sample(3 * k + 5 * shift + 1)
        return point

    def described(self) -> list[Any]:
        """Fingerprint for records: numbers and domains, and the chart at two exact points.

        Charts are quotients of polynomials, so different charts have different values there.
        """
        charts = [{name: _sample(3 * k + s) for k, name in enumerate(self.numbers)} for s in (1, 2)]
        points = [sorted((n, str(x)) for n, x in self.values(chart).items()) for chart in charts]
        return [self.label, dict(self.numbers), dict(self.declared), points]


Cases: TypeAlias = tuple[Case, ...]


def _sample(k: int) -> Fraction:
    return _SAMPLES[k % len(_SAMPLES)] + Fraction(k % 7, 3 * (1 + k % 5))


def at(**coordinates: str | int | Fraction) -> dict[str, Fraction]:
    """An exact point: whole numbers, or text such as ``4/5`` or ``0.8``."""
    return {name: Fraction(value) for name, value in coordinates.items()}


TARGETS = ("far-", "middle-", "near-", "zero", "near+", "middle+", "far+")
TARGET_EDGES = ("edge-", "corner-", "corner+", "edge+")
SMOOTH_TARGETS = ("beyond-", "corner-", "near-", "zero", "near+", "corner+", "beyond+")
"""Regions of the smooth barrier, which has no middle one: beyond v_u2 the target follows at once.
"""
SIDES = ("out-", "in-", "zero", "in+", "out+")
SIDE_EDGES = ("kink-", "kink+")
CHARTED = ("far", "middle", "near", "beyond", "out", "in")


def axis_case(suffix: str, target: str, side: str, order: str = "") -> Case:
    """One region, of inputs v<suffix>, c<suffix>, u1<suffix>, u2<suffix>.

    ``order`` (``<``, ``=``, ``>``) relates |v| and |v_c1| if they are in one interval.
    """
    u2_name, b_name, j_name, i_name = (f"{name}{suffix}" for name in ("u2", "b", "j", "i"))
    is_placed = side[:-1] in CHARTED and order != "="
    names = [u2_name, b_name, *([j_name] if target[:-1] in CHARTED else [])]
    names += [i_name] if is_placed else []

    def values(n: Values) -> Values:
        u2, b = n[u2_name], n[b_name]
        i = j = n[j_name] if target[:-1] in CHARTED else 0
        if is_placed:
            i = n[i_name]
        if order == ">":
            i = j + i
        elif order == "<":
            i = j * i / (1 + i)
        c, v = target_value(target, u2, b, j), side_value(side, u2, b, i)
        return {f"u1{suffix}": u2 + b, u2_name: u2, f"c{suffix}": c, f"v{suffix}": v}

    label = f"v_c0 {target}, v {side}" + (f", |v| {order} |v_c1|" if order else "")
    return Case(label, dict.fromkeys(names, POSITIVE), values)


def target_value(target: str, u2: Any, b: Any, j: Any) -> Any:
    """v_c0 of a region."""
    d = b / (1 + j)
    size = {
        "zero": u2 - u2,
        "near": u2 * j / (1 + j),
        "corner": u2,
        "middle": u2 + j / (1 + j) / b,
        "edge": u2 + 1 / b,
        "far": u2 + b - d + 1 / d,
        "beyond": u2 + b - d + 1 / d - 1 / b,
    }[target.rstrip("+-")]
    return -size if target.endswith("-") else size


def side_value(side: str, u2: Any, b: Any, i: Any) -> Any:
    """v of a region."""
    sizes = {"zero": u2 - u2, "in": u2 * i / (1 + i), "kink": u2, "out": u2 + b * i / (1 + i)}
    size = sizes[side.rstrip("+-")]
    return -size if side.endswith("-") else size


def tangent_case(y_side: str, v_side: str) -> Case:
    """Inputs y and v, each on one of its sides."""
    names = {"u2": POSITIVE, "b": POSITIVE}
    names |= {n: POSITIVE for n, s in (("k", y_side), ("i", v_side)) if s[:-1] in CHARTED}

    def values(n: Values) -> Values:
        u2, b = n["u2"], n["b"]
        y, v = (side_value(side, u2, b, n.get(k, 0)) for side, k in ((y_side, "k"), (v_side, "i")))
        return {"u1": u2 + b, "u2": u2, "y": y, "v": v}

    return Case(f"y {y_side}, v {v_side}", names, values)


def open_cases(suffix: str = "") -> Cases:
    """The 35 open regions, where everything is differentiable."""
    return tuple(axis_case(suffix, t, s) for t in TARGETS for s in SIDES)


def _ordered_cases(
    targets: Iterable[str], sides: Iterable[str], orders: tuple[str, ...], *more: tuple[str, str]
) -> Cases:
    """Regions, with every order of |v| and |v_c1| if both share an interval or are in ``more``."""
    return tuple(
        axis_case("", t, s, order)
        for t, s in product(targets, sides)
        for order in (orders if _shared(t, s) or (t[:-1], s[:-1]) in more else ("",))
    )


def all_cases() -> Cases:
    """All regions with their boundaries, and the order of |v| and |v_c1| in a common interval."""
    return _ordered_cases((*TARGETS, *TARGET_EDGES), (*SIDES, *SIDE_EDGES), ("<", "=", ">"))


def off_target_cases() -> Cases:
    """The open regions without v = v_c1, where A is 0."""
    cases = _ordered_cases(TARGETS, SIDES, ("<", ">"))
    return tuple(case for case in cases if case.label != "v_c0 zero, v zero")


def smooth_cases(sides: Iterable[str] = SIDES + SIDE_EDGES) -> Cases:
    """All regions of the smooth barrier; ordered also where v and v_c1 have opposite signs."""
    return _ordered_cases(SMOOTH_TARGETS, sides, ("<", "=", ">"), ("beyond", "out"))


def target_cases(edges: bool = True) -> Cases:
    """Regions of v_c0 alone (v at 0)."""
    targets = TARGETS + TARGET_EDGES if edges else TARGETS
    return tuple(axis_case("", t, "zero") for t in targets)


def _shared(target: str, side: str) -> bool:
    pairs = {("near", "in"), ("far", "out"), ("beyond", "out")}
    return target[-1] == side[-1] and (target[:-1], side[:-1]) in pairs


def joined(one: Case, two: Case) -> Case:
    """Both cases together; their inputs and numbers must have different names."""

    def values(n: Values) -> Values:
        return one.values(n) | two.values(n)

    declared = one.declared | two.declared
    return Case(f"{one.label}; {two.label}", one.numbers | two.numbers, values, declared)


def paired_cases() -> Cases:
    """Every open region of axis 1 and of axis 2 once, each paired with a region of the other axis.

    This is enough if the statement is a sum of one term per axis: terms of independent variables
    whose sum is 0 are constant on their regions.
    """
    return tuple(map(joined, open_cases("1"), open_cases("2")[::-1]))


def renamed(case: Case, names: dict[str, str], declared: Domains | None = None) -> Case:
    """The case with its inputs under other names."""

    def values(n: Values) -> Values:
        return {names.get(key, key): value for key, value in case.values(n).items()}

    return Case(case.label, case.numbers, values, case.declared | (declared or {}))


def law_cases(cases: Iterable[Case], axis: int) -> Cases:
    """Cases of one axis under the names of a law's ports."""
    k = axis + 1
    names = {"v": ("v1", "omega")[axis], "u1": f"limits.v_u1[{k}]", "u2": f"limits.v_u2[{k}]"}
    masses = dict.fromkeys(("model.m", "model.I", "robot.v_s"), POSITIVE)
    return tuple(renamed(case, names, masses) for case in cases)
