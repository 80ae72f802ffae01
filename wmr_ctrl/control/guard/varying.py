"""Weights of commands behind a lag whose time constant varies, piece by piece.

Per axis and direction, with p = max(F + net, 0) of the acting command F. Behind drives whose time
constant tau lies in [a, b] and varies arbitrarily, the push that acts is at most Z:

    tau Z' = p - Z    rises soonest with a and falls latest with b.

So Z is propagated through the pieces of time in which one command, or either of two, may act.  It
uses the larger p of a piece, a where Z rises and b where Z falls.  In a piece from Z0 on,

    Z = p + max(Z0 - p, 0) exp(-t/b) - max(p - Z0, 0) exp(-t/a),

and its end and its integral with the weights P(s) of `lateness` are linear in the two differences.
Their coefficients are computed once, in closed form with 50 digits.
"""

from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction

Weights = tuple[float, float, float]
"""Weights [periods] of p, and of the differences that decay and rise."""
Integral = Callable[[Fraction, Fraction, Fraction | None], Decimal]
"""Integral of P(s) exp(-(begin - s)/tau) between the ages begin and end; of P(s) if tau is None."""


@dataclass(frozen=True)
class Passage:
    """A piece of time: the commands that may act, and the evolution of Z in it.

    ``stays``: remaining share of a falling and of a rising difference.  The weights are for mean
    and rest (see `lateness`).
    """

    which: tuple[int, ...]
    stays: tuple[float, float]
    mean: Weights
    rest: Weights


@dataclass(frozen=True)
class Varying:
    """Numbers of one axis [periods].

    ``pieces``: from the oldest listed command to the earliest start of the new one.  ``entering``:
    pieces of the command that leaves the list at the next sample.  ``longest``: b.  ``rises``: (b -
    a)(1 - exp(-t/a)) for t = J, T and T + J, the effect of a command larger than Z beyond its own
    time.  ``stays``: remaining share in J.
    """

    pieces: tuple[Passage, ...]
    entering: tuple[Passage, ...]
    longest: float
    rises: tuple[float, float, float]
    stays: tuple[float, float]


def varying(
    count: int, delay: tuple[Fraction, Fraction], span: tuple[Fraction, Fraction],
    mean: Integral, rest: Integral,
) -> Varying:  # fmt: skip
    """Pieces for ``count`` commands, from the bounds of ``delay`` and of the lag, ``span``."""
    (lo, hi), (a, b) = delay, span
    jitter = hi - lo

    def piece(which: tuple[int, ...], begin: Fraction, end: Fraction) -> Passage:
        weights = (tuple(float(of(begin, end, tau)) for tau in (None, b, a)) for of in (mean, rest))
        first, second = ((w[0], w[1], w[2]) for w in weights)
        return Passage(which, _staying(begin - end, span), first, second)

    def of(j: int) -> list[Passage]:
        over = Fraction(j - 1)
        items = [piece((j,), j - hi, over - lo)]
        return [*items, piece((j, j - 1), over - lo, over - hi)] if j > 1 else items

    listed = [item for j in range(count, 0, -1) for item in of(j)]
    joins = of(count + 1)
    one, two, three = (
        float(number(b - a) * (1 - _exp(time, a))) for time in (jitter, Fraction(1), 1 + jitter)
    )
    return Varying(
        _long(listed), _long(joins), float(b), (one, two, three), _staying(jitter, span)
    )  # fmt: skip


def ramp(age: Fraction, window: Fraction) -> Integral:
    """Integral with P(s) = 1 up to ``age``, falling to 0 over the following window."""
    oldest = age + window

    def integral(begin: Fraction, end: Fraction, tau: Fraction | None) -> Decimal:
        flat = _linear(begin, (end, min(begin, age)), (Fraction(1), Fraction(0)), tau)
        if not window:
            return flat
        falling = (max(end, age), min(begin, oldest))
        return flat + _linear(begin, falling, (oldest / window, -1 / window), tau)

    return integral


def less(first: Integral, second: Integral) -> Integral:
    """Integral whose weight is the difference of two weights."""
    return lambda begin, end, tau: first(begin, end, tau) - second(begin, end, tau)


def _linear(
    begin: Fraction, ages: tuple[Fraction, Fraction], line: tuple[Fraction, Fraction],
    tau: Fraction | None,
) -> Decimal:  # fmt: skip
    """Integral of (line[0] + line[1] s) exp(-(begin - s)/tau) between two ages; 0 without any."""
    low, high = ages
    if low >= high:
        return Decimal(0)
    if tau is None:
        return number((high - low) * (line[0] + line[1] * (high + low) / 2))
    upper, lower = (
        number(tau * (line[0] + line[1] * (s - tau))) * _exp(begin - s, tau) for s in (high, low)
    )
    return upper - lower


def _staying(time: Fraction, span: tuple[Fraction, Fraction]) -> tuple[float, float]:
    return float(_exp(time, span[1])), float(_exp(time, span[0]))


def _exp(time: Fraction, tau: Fraction) -> Decimal:
    """exp(-time/tau); 0 if tau = 0."""
    if tau == 0:
        return Decimal(int(time == 0))
    return number(-time / tau).exp()


def _long(pieces: list[Passage]) -> tuple[Passage, ...]:
    """Pieces of non-zero length."""
    return tuple(item for item in pieces if item.stays[0] < 1)


def number(x: Fraction) -> Decimal:
    """A fraction as a decimal with the context's digits."""
    return Decimal(x.numerator) / Decimal(x.denominator)
