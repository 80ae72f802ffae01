"""Intervals of doubles that contain both the real value and the IEEE double that C computes.

Bounds of the four operations and the root are rounded to nearest and then moved outward by one unit
in the last place unless they are exact, so each interval contains the real results and, rounding
being monotone, the rounded ones.  Elementary functions come from flint's balls, widened by the
stated accuracy of the C library.

An interval may also have a form: value = sum of c_k b_k with 0 <= c_k in known ranges and b_k >= 0
named quantities.  The quotient of two such forms lies between the least and the largest quotient of
their coefficients, which bounds x/(x + y) near x = y = 0, where plain intervals fail.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import fabs, inf, isfinite, nextafter, sqrt

from flint import arb

UNIT = 2.0**-53
LIBM = 2.0**-51
"""Relative accuracy assumed of log, exp, sin, cos, tanh in the C library."""

Form = dict[int, tuple[float, float]]
LARGEST_FORM = 4


@dataclass(slots=True)
class Interval:
    """[lo, hi]; ``key`` names the quantity (negated: the opposite quantity); optionally a form of
    its size.
    """

    lo: float
    hi: float
    key: int = 0
    form: Form | None = None

    @property
    def sign(self) -> int:
        """1 if nowhere negative, -1 if nowhere positive, 0 if unknown."""
        return 1 if self.lo >= 0 else (-1 if self.hi <= 0 else 0)

    @property
    def size(self) -> tuple[float, float]:
        """Range of the absolute value, for a known sign."""
        return (self.lo, self.hi) if self.lo >= 0 else (-self.hi, -self.lo)

    def terms(self) -> Form | None:
        """Form of the absolute value: its own, or itself as one quantity."""
        if self.form is not None:
            return self.form
        return {abs(self.key): (1.0, 1.0)} if self.sign and self.key else None


def down(value: float) -> float:
    """One unit in the last place below."""
    return nextafter(value, -inf)


def up(value: float) -> float:
    """One unit in the last place above."""
    return nextafter(value, inf)


def _missed(a: float, b: float) -> float:
    """Exact rounding error of the sum a + b, by Knuth's two-sum."""
    total = a + b
    back = total - a
    return (a - (total - back)) + (b - back)


def add(a: Interval, b: Interval) -> Interval:
    """a + b, with exact ends for exact sums; with a form if both have the same sign."""
    low, high = a.lo + b.lo, a.hi + b.hi
    found = Interval(
        low if _missed(a.lo, b.lo) >= 0 and isfinite(low) else down(low),
        high if _missed(a.hi, b.hi) <= 0 and isfinite(high) else up(high),
    )
    sign = a.sign
    if sign and sign == b.sign:
        found.form = _merged(a.terms(), b.terms())
    return found


def _merged(a: Form | None, b: Form | None) -> Form | None:
    if a is None or b is None or len(a) + len(b) > LARGEST_FORM + 2:
        return None
    keys = {*a, *b}
    pairs = {k: (a.get(k, (0.0, 0.0)), b.get(k, (0.0, 0.0))) for k in keys}
    return {
        k: _widened(down(x[0] + y[0]) if x[0] + y[0] else 0.0, up(x[1] + y[1]))
        for k, (x, y) in pairs.items()
    }


def _widened(low: float, high: float) -> tuple[float, float]:
    """Both ends moved outward by the rounding of the operation itself."""
    return down(low * (1 - 2 * UNIT)) if low > 0 else 0.0, up(high * (1 + 2 * UNIT))


def negative(a: Interval) -> Interval:
    """-a."""
    return Interval(-a.hi, -a.lo, -a.key, a.form)


def multiply(a: Interval, b: Interval) -> Interval:
    """a b; with a form if signs are known, from the factor that reaches closest to 0."""
    sign = a.sign * b.sign
    if not sign:
        corners = [_product(x, y) for x in (a.lo, a.hi) for y in (b.lo, b.hi)]
        return Interval(down(min(corners)), up(max(corners)))
    (least, most), (low, high) = a.size, b.size
    near = (least / most if most > 0 else 0.0) <= (low / high if high > 0 else 0.0)
    low, high = max(0.0, down(_product(least, low))), up(_product(most, high))
    found = Interval(low, high) if sign > 0 else Interval(-high, -low)
    found.form = _scaled(a, b) if near else _scaled(b, a)
    return found


def _product(x: float, y: float) -> float:
    return 0.0 if x == 0 or y == 0 else x * y


def _scaled(kept: Interval, factor: Interval) -> Form | None:
    terms = kept.terms()
    if terms is None or len(terms) > LARGEST_FORM:
        return None
    low, high = factor.size
    return {
        k: _widened(max(0.0, down(_product(x, low))), up(_product(y, high)))
        for k, (x, y) in terms.items()
    }


def divide(a: Interval, b: Interval) -> Interval | None:
    """a/b; None if b may be 0."""
    if b.lo <= 0 <= b.hi:
        return None
    corners = [x / y for x in (a.lo, a.hi) for y in (b.lo, b.hi)]
    sign = a.sign * b.sign
    low, high = down(min(corners)), up(max(corners))
    found = Interval(max(0.0, low) if sign > 0 else low, min(0.0, high) if sign < 0 else high)
    if sign:
        _bound_by_forms(found, a, b, sign)
        least, most = b.size
        found.form = _scaled(a, Interval(down(1 / most), up(1 / least))) if least > 0 else None
    return found


def _bound_by_forms(found: Interval, a: Interval, b: Interval, sign: int) -> None:
    above, below = a.terms(), b.terms()
    if above is None or below is None or not set(above) <= set(below):
        return
    if any(low <= 0 for low, _ in below.values()):
        return
    pairs = [(above.get(k, (0.0, 0.0)), below[k]) for k in below]
    low = min(_widened(down(n[0] / d[1]), 0.0)[0] if n[0] else 0.0 for n, d in pairs)
    high = max(_widened(0.0, up(n[1] / d[0]))[1] for n, d in pairs)
    if sign > 0:
        found.lo, found.hi = max(found.lo, low), min(found.hi, high)
    else:
        found.lo, found.hi = max(found.lo, -high), min(found.hi, -low)


def root(a: Interval) -> Interval | None:
    """Square root; None if a may be negative."""
    if a.lo < 0:
        return None
    return Interval(max(0.0, down(sqrt(a.lo))), up(sqrt(a.hi)))


def smaller(a: Interval, b: Interval) -> Interval:
    """Minimum; one of the two operands if it is clear which is less."""
    if a.hi <= b.lo:
        return a
    return b if b.hi <= a.lo else Interval(min(a.lo, b.lo), min(a.hi, b.hi))


def magnitude(a: Interval) -> Interval:
    """|a|."""
    if a.sign:
        return a if a.sign > 0 else negative(a)
    return Interval(0.0, max(-a.lo, a.hi))


def elementary(call: Callable[[arb], arb], a: Interval, monotone: bool = True) -> Interval | None:
    """An elementary function by flint, widened by the C library's error."""
    if not (isfinite(a.lo) and isfinite(a.hi)):
        return None
    balls = [call(arb(a.lo)), call(arb(a.hi))] if monotone else [call(arb(a.lo).union(arb(a.hi)))]
    if any(not ball.is_finite() for ball in balls):
        return None
    low = min(down(float(ball.lower())) for ball in balls)
    high = max(up(float(ball.upper())) for ball in balls)
    return Interval(down(low - LIBM * fabs(low)), up(high + LIBM * fabs(high)))
