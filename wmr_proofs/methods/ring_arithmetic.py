"""Arithmetic of exact algebra: values are elements of a fraction field, or undefined (None)."""

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

from flint import fmpq
from flint.utils.flint_exceptions import DomainError

from wmr_proofs.graph import ARITHMETIC, Arithmetic, Ask, UndecidedError
from wmr_proofs.regions import FREE, NONNEGATIVE, POSITIVE, Case

from .field import Algebra

HUGE = 1e100
"""A bound on targets beyond this is taken as not reached (stated with the claims that use it)."""


class RingArithmetic(Arithmetic):
    """Values of one case; conditions are decided by signs, else by ``ask``."""

    def __init__(
        self, case: Case, names: tuple[str, ...], fixed: Mapping[float, bool], spare: int
    ) -> None:
        free = {n: case.declared.get(n, FREE) for n in names}
        self.algebra = Algebra(case.numbers | free, spare)
        chart = {name: self.algebra.by_name[name] for name in case.numbers}
        self.inputs = {n: self.algebra.by_name[n] for n in names} | case.values(chart)
        self.fixed = fixed
        self.ask: Ask = lambda _: True
        self.nonzero: set[Any] = set()

    def constant(self, value: float) -> Any:
        """The double, exactly."""
        return self.algebra.number(value)

    def variable(self, name: str) -> Any:
        """Element of an input."""
        return self.algebra.field(self.inputs[name])

    def apply(self, op: str, args: list[Any]) -> Any:
        """Element of an operation; None if it is undefined."""
        if any(arg is None for arg in args):
            return None
        if op in ("div", "inv"):
            below = self._nonzero(self.algebra.reduced(args[-1]))
            return args[0] / below if op == "div" else 1 / below
        if op in ARITHMETIC:
            return ARITHMETIC[op](*args)
        if op not in _OPERATIONS:
            raise UndecidedError(f"no exact algebra of {op} is known")
        return _OPERATIONS[op](self, *args)

    def _nonzero(self, below: Any) -> Any:
        """A denominator; UndecidedError if it may be 0 in this case."""
        if below not in self.nonzero and not self.algebra.never_zero(below):
            raise UndecidedError("a denominator that may be 0")
        return below

    def compare(self, op: str, left: Any, right: Any, ask: Ask) -> bool:
        """Truth by the sign of right - left."""
        if left is None or right is None:
            raise UndecidedError("a comparison of what may be undefined")
        gap = self.algebra.reduced(right - left)
        known = _TRUTH[op].get(self.algebra.sign(gap) or "?")
        if known is None:
            known = self._stated(op, left, right)
        return self._asked(op, gap, ask) if known is None else known

    def _asked(self, op: str, gap: Any, ask: Ask) -> bool:
        """Ask one question per sign, so that related conditions are decided consistently."""
        if op in ("eq", "ne"):
            return ask(("zero", gap)) == (op == "eq")
        return ask(("above", gap)) if op == "lt" else not ask(("above", -gap))

    def _stated(self, op: str, left: Any, right: Any) -> bool | None:
        """Truth of a bound on ``left`` by a hypothesis ``left < constant``, or its negation."""
        if op != "lt" or right.number is None:
            return None
        for value, truth in self.fixed.items():
            if right.number == Fraction(value):
                self.nonzero |= {left, -left} if not truth and value > 0 else set()
                return truth
        return None

    def number(self, condition: bool) -> Any:
        """1 or 0."""
        return self.algebra.number(int(condition))

    def smaller(self, left: Any, right: Any) -> Any:
        """Minimum of two elements, if the sign of their difference is known."""
        if right.number is not None and right.number > HUGE:
            return left
        return self._pick(right - left, left, right)

    def larger(self, left: Any, right: Any) -> Any:
        """Maximum of two elements, if the sign of their difference is known."""
        return self._pick(right - left, right, left)

    def _pick(self, gap: Any, if_positive: Any, if_negative: Any) -> Any:
        return if_positive if self._upward(gap) else if_negative

    def _upward(self, value: Any) -> bool:
        found = self.algebra.sign(value)
        return not self.ask(("above", -value)) if found is None else found[0] != "-"

    def magnitude(self, value: Any) -> Any:
        """|value|."""
        return value if self._upward(value) else -value

    def signum(self, value: Any) -> Any:
        """sgn(value)."""
        found = self.algebra.sign(value)
        if found not in ("+", "-", "0"):
            return None
        return self.algebra.number({"+": 1, "-": -1, "0": 0}[found])

    def root(self, value: Any) -> Any:
        """Square root: exact for squares, else an atom with its relation."""
        value = self.algebra.reduced(value)
        top, bottom = _polynomial_root(value.numer), _polynomial_root(value.denom)
        if top is not None and bottom is not None:
            return self.magnitude(self.algebra.field(top) / self.algebra.field(bottom))
        if self.algebra.sign(value) not in ("+", "+0", "0"):
            raise UndecidedError("a root of what may be negative")
        atom = self.algebra.atom("sqrt", value, NONNEGATIVE)
        self.algebra.relate(atom, value)
        return atom

    def logarithm(self, value: Any) -> Any:
        """log as a sum over the factors of its argument, each an atom."""
        if self.algebra.sign(value) != "+":
            raise UndecidedError("a logarithm of what may not be positive")
        total = self.algebra.number(0)
        for poly, side in ((value.numer, 1), (value.denom, -1)):
            content, factors = poly.factor()
            signs = 0
            for factor, times in factors:
                found = self.algebra.polynomial_sign(factor)
                if found not in ("+", "-"):
                    return self.algebra.atom("log of", value, FREE)
                signs += times * (found == "-")
                factor = factor if found == "+" else -factor
                total += side * times * self.algebra.atom("log", self.algebra.field(factor), FREE)
            content = content * (-1) ** signs
            if content < 0:
                return None
            if content != 1:
                total += side * self.algebra.atom("log", self.algebra.field(content), FREE)
        return total

    def exponential(self, value: Any) -> Any:
        """exp of a sum with integer coefficients as a product of atoms; else one atom."""
        if any(c.denominator != 1 for c in value.numer.coeffs()):
            return self.algebra.atom("exp", value, POSITIVE)
        product, field = self.algebra.number(1), self.algebra.field
        for monomial, times in value.numer.terms():
            term = field.over(field.polynomial({monomial: fmpq(1)}), value.denom)
            product = product * self.algebra.atom("exp", term, POSITIVE) ** int(times)
        return product

    def sine_cosine(self, angle: Any) -> tuple[Any, Any]:
        """(sin, cos) of a sum of generators, by angle addition; else one opaque atom."""
        terms = _integer_terms(angle)
        if terms is None:
            return self._pair(angle)
        sine, cosine = self.algebra.number(0), self.algebra.number(1)
        for generator, times in terms:
            s, c = self._pair(generator)
            for _ in range(abs(times)):
                step = s if times > 0 else -s
                sine, cosine = sine * c + cosine * step, cosine * c - sine * step
        return self.algebra.reduced(sine), self.algebra.reduced(cosine)

    def _pair(self, angle: Any) -> tuple[Any, Any]:
        s, c = self.algebra.atom("sin", angle, FREE), self.algebra.atom("cos", angle, FREE)
        self.algebra.relate(s, 1 - c**2)
        return s, c


_TRUTH = {
    "lt": {"+": True, "-": False, "0": False, "-0": False},
    "le": {"+": True, "-": False, "0": True, "+0": True},
    "eq": {"+": False, "-": False, "0": True},
    "ne": {"+": True, "-": True, "0": False},
}
_OPERATIONS: dict[str, Callable[..., Any]] = {
    "fabs": RingArithmetic.magnitude,
    "sign": RingArithmetic.signum,
    "fmin": RingArithmetic.smaller,
    "fmax": RingArithmetic.larger,
    "sqrt": RingArithmetic.root,
    "log": RingArithmetic.logarithm,
    "sin": lambda me, a: me.sine_cosine(a)[0],
    "cos": lambda me, a: me.sine_cosine(a)[1],
    "exp": RingArithmetic.exponential,
    "tanh": lambda me, a: me.algebra.atom("tanh", a, FREE),
    "constpow": lambda _, a, b: a ** int(b.number),
}


def _polynomial_root(poly: Any) -> Any:
    """Square root of a polynomial; None if there is none."""
    try:
        return poly.sqrt()
    except (DomainError, ValueError):
        return None


def _integer_terms(angle: Any) -> list[tuple[Any, int]] | None:
    """(generator, integer) of a linear form, or None."""
    if not angle.denom.is_constant():
        return None
    terms = []
    for monomial, times in angle.numer.terms():
        if sum(monomial) != 1 or times.denominator != 1:
            return None
        terms.append((angle.field.generators[monomial.index(1)], int(times)))
    return terms
