"""Weights of past commands if velocities are measured late or drives are slow.

Per axis, times in control periods.  The velocity is the mean over a window that ended ``age`` ago,
L = age + window.  A command takes over between lo and hi after it was sent.  Drives follow with one
time constant of at most b (for one that varies see `varying`).  With sigma the age of a velocity,
uniform on [age, L], a force of age s has the following weight in what v may have gained since:

    P(s) = E min(1, exp(-(s - sigma)/b))       (mean),   and with sigma = L       (rest).

A piece of time has the integral of P as its weight; future time (s < 0) counts in full.  The
integrals are taken in closed form with 50 digits, once, and rounded to floats.

Command j, sent j periods ago, is sure to act in one piece of time.  In the piece before the next
command is sure, either of the two may act.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from decimal import Context, Decimal, localcontext
from fractions import Fraction
from functools import lru_cache

from .varying import Varying, less, number, ramp, varying

Pair = tuple[float, float]
DIGITS = 50
GRID = 1e-6
"""Share of a plant step within which a time counts as so many whole steps."""

Piece = tuple[tuple[int, ...], float]
"""Commands of which any may act (1: the latest sent), and what the piece counts for [periods]."""
Weight = Callable[[Fraction], Decimal]


@dataclass(frozen=True)
class Tail:
    """Weight of commands older than those listed, behind a lag.

    In each sample ``decay`` of it remains and ``entering`` (sure, mixed) [periods] of the oldest
    listed command is added; the mean uses the ``share``; ``steady`` is its limit for a force of 1.
    """

    decay: float
    entering: tuple[float, float]
    share: float
    steady: float


@dataclass(frozen=True)
class Counting:
    """Command weights of one axis, in periods; see the module's docstring.

    ``mean`` and ``rest``: pieces up to when the new command may first take over.  ``jitter``: J =
    hi - lo.  ``lag``: b.  ``oldest``: L. ``most``: L + hi + b, the longest time that matters;
    ``usual``: that for the mean.  ``mixed``: the mean's weight of pieces with two commands.
    ``commands``: how many are listed.  If the lag varies, all pieces are in ``varying``, and all of
    their weight is mixed.
    """

    mean: tuple[Piece, ...]
    rest: tuple[Piece, ...]
    jitter: float
    lag: float
    oldest: float
    most: float
    usual: float
    mixed: float
    commands: int
    tail: Tail | None = None
    varying: Varying | None = None

    @property
    def at_once(self) -> bool:
        """True if nothing is late."""
        return not (self.rest or self.jitter or self.lag)

    @property
    def roundings(self) -> int:
        """Largest number of commands whose rounding errors add up."""
        return self.commands + math.ceil(self.lag)

    @property
    def averaged(self) -> bool:
        """True if a window matters."""
        if self.varying:
            return any(item.mean != item.rest for item in self.varying.pieces)
        return self.mean != self.rest or (self.tail is not None and self.tail.share != 1.0)


AT_ONCE = Counting((), (), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0)
"""Exact velocities, and drives that act at once."""


@dataclass(frozen=True)
class Since:
    """Command weights in a velocity's change since the previous sample, in periods.

    ``mean`` for a robot that moved throughout, ``rest`` for one that rested within the window; and
    the times for which a push acts.
    """

    mean: tuple[Piece, ...]
    rest: tuple[Piece, ...]
    mean_time: float
    rest_time: float
    older: Counting
    varying: Varying | None = None


@dataclass(frozen=True)
class Times:
    """Delays [s].  A velocity is the mean over a ``window`` that ended ``age`` ago.

    A command takes effect between the bounds of ``delay``; the drives' time constant is constant
    and at most lag[1] if both bounds are equal, else it varies between them.
    """

    period: float
    step: float
    age: float = 0.0
    window: float = 0.0
    delay: Pair = (0.0, 0.0)
    lag: Pair = (0.0, 0.0)

    def in_periods(self, time: float) -> Fraction:
        """A time in periods; exact if it is a whole number of plant steps."""
        steps = round(time / self.step)
        if abs(time - steps * self.step) <= GRID * self.step:
            return Fraction(steps, round(self.period / self.step))
        return Fraction(time) / Fraction(self.period)


@lru_cache(maxsize=1024)
def lateness(times: Times) -> Counting:
    """Weights of past commands."""
    age, window, lo, hi = map(times.in_periods, (times.age, times.window, *times.delay))
    least, most = (Fraction(item) / Fraction(times.period) for item in times.lag)
    oldest, usual = age + window, float(age + window / 2 + hi + most)
    count, long = math.ceil(oldest + hi), ramp(oldest, Fraction(0))
    own = float(hi - lo), float(most), float(oldest), float(oldest + hi + most), usual
    with localcontext(Context(prec=DIGITS)):
        if least == most:
            mean, rest, mixed, tail = _lateness(age, window, lo, hi, most)
            return Counting(mean, rest, *own, mixed, count, tail)
        slow = varying(count, (lo, hi), (least, most), ramp(age, window), long)
        return Counting((), (), *own, usual, count, varying=slow)


def since_last(times: Times) -> Since | None:
    """Weights of past commands in the velocity's change since the previous sample.

    The velocity of age sigma differs from that of age sigma + T by at most the integral of the
    acting force over the time between, which behind a lag may stem from any earlier time.  None if
    the window is longer than a period.
    """
    if times.in_periods(times.window) > 1:
        return None
    older = lateness(replace(times, age=times.age + times.period))
    gone = times.window / times.period / 2
    if older.varying:
        return Since((), (), 1.0, 1 + gone, older, _varying_since(times, older.commands))
    newer = dict(lateness(replace(times, lag=(0.0, 0.0))).mean)
    mean, rest = (
        tuple((which, time - newer.get(which, 0.0)) for which, time in pieces)
        for pieces in (older.mean, older.rest)
    )
    return Since(_positive(mean), _positive(rest), 1 + older.lag, 1 + gone + older.lag, older)


def _varying_since(times: Times, count: int) -> Varying:
    age, window, lo, hi = map(times.in_periods, (times.age, times.window, *times.delay))
    least, most = (Fraction(item) / Fraction(times.period) for item in times.lag)
    newer, oldest = ramp(age, window), ramp(age + window + 1, Fraction(0))
    with localcontext(Context(prec=DIGITS)):
        moved, begun = less(ramp(age + 1, window), newer), less(oldest, newer)
        return varying(count, (lo, hi), (least, most), moved, begun)


def _lateness(
    age: Fraction, window: Fraction, lo: Fraction, hi: Fraction, lag: Fraction
) -> tuple[tuple[Piece, ...], tuple[Piece, ...], float, Tail | None]:
    """Mean, rest, mixed and tail of a Counting behind a constant lag."""
    oldest, jittered = age + window, hi > lo
    count = math.ceil(oldest + hi)
    mean, rest = _mean_weight(age, window, lag), _rest_weight(oldest, lag)
    pieces = [(*_group(j, lo, hi, mean), *_group(j, lo, hi, rest)) for j in range(1, count + 2)]
    listed = pieces[:count]
    mixed, tail = sum((item[1] for item in listed), Decimal(0)), None
    if lag:
        _, over, sure, either = pieces[count]
        decay, share = number(-1 / lag).exp(), Decimal(1)
        if window:
            share = number(lag / window) * (1 - number(-window / lag).exp())
        mixed += over / (1 - decay)
        steady = (sure + either) / (1 - decay)
        tail = Tail(float(decay), (float(sure), float(either)), float(share), float(steady))
    means, rests = ([(item[k], item[k + 1]) for item in listed] for k in (0, 2))
    return _pieces(means, jittered), _pieces(rests, jittered), float(mixed), tail


def _pieces(weights: list[tuple[Decimal, Decimal]], jittered: bool) -> tuple[Piece, ...]:
    """Sure and mixed pieces of commands 1, 2, ..., without that of command 1 and the new one."""
    pieces: list[Piece] = []
    for j, (sure, mixed) in enumerate(weights, 1):
        pieces.append(((j,), float(sure)))
        if jittered and j > 1:
            pieces.append(((j, j - 1), float(mixed)))
    return _positive(pieces)


def _positive(pieces: Iterable[Piece]) -> tuple[Piece, ...]:
    return tuple(item for item in pieces if item[1] > 0)


def _group(j: int, lo: Fraction, hi: Fraction, weight: Weight) -> tuple[Decimal, Decimal]:
    """Weights of command j: of the time when it surely acts, and when the next one may act, too."""
    begin, sure, over = j - hi, j - 1 - lo, j - 1 - hi
    return weight(sure) - weight(begin), weight(over) - weight(sure)


def _rest_weight(oldest: Fraction, lag: Fraction) -> Weight:
    """Integral of P over all ages from s on, for sigma = ``oldest``."""
    return lambda s: _once(s - oldest, lag)


def _mean_weight(age: Fraction, window: Fraction, lag: Fraction) -> Weight:
    if not window:
        return _rest_weight(age, lag)
    wide = number(window)
    return lambda s: (_twice(s - age, lag) - _twice(s - age - window, lag)) / wide


def _once(x: Fraction, lag: Fraction) -> Decimal:
    """Integral from x on of 1 for negative, exp(-x/lag) for positive arguments."""
    if x <= 0:
        return number(lag - x)
    return number(lag) * number(-x / lag).exp() if lag else Decimal(0)


def _twice(x: Fraction, lag: Fraction) -> Decimal:
    """Integral of `_once` from 0 to x."""
    if x <= 0:
        return number(lag * x - x * x / 2)
    return number(lag * lag) * (1 - number(-x / lag).exp()) if lag else Decimal(0)
