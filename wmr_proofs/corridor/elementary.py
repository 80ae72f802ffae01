"""Sines, exponentials and tanh of many numbers, each with a rigorous radius.

They use series, with sums, products and quotients only.
"""

from math import factorial, log

import numpy as np

from wmr_ctrl.theory.checks.error_coordinates import Floats

from .midradius import OUTWARD, MidRadius, widened

ANGLE, EXPONENT, SATURATED = 0.5, 300.0, 20.0
"""Largest arguments of sine and of exp, and that from which on tanh is within ONE_OFF of 1."""
LN_2, ONE_OFF, REST = MidRadius(log(2.0), 1e-16), 1e-17, 3e-17
"""The series' remainders are below REST: x^15/15!, x^16/16! at ANGLE, 1.5 x^14/14! at ln 2 / 2."""
SERIES_OFF, STEEP = 2.0**-50, 1.01
"""Rounding error of a series' sum, and weight of its argument's error, as shares of the sum.

By Horner's rule a sum of c_k x^k errs by (2 k + 2) 2^-53 |c_k x^k| at most for each k, with that of
c_k and what is of higher order: less than 4 times 2^-53 in all where |x| <= 0.36 and c_k = 1/k!.
No series' derivative is larger than the series, for arguments that are off by less than 0.001.
"""


def _series(x: MidRadius, orders: range) -> MidRadius:
    """Power series whose coefficients are reciprocal factorials of ``orders``, with signs."""
    sign = -1.0 if orders.step == 2 else 1.0
    result = np.zeros_like(x.middle)
    for k, order in reversed(list(enumerate(orders))):
        result = result * x.middle + sign**k / factorial(order)
    wide = x.radius * STEEP * np.abs(result) + (SERIES_OFF + REST)
    return MidRadius(result, wide * OUTWARD)


def sine(a: MidRadius) -> MidRadius:
    """Sines of arguments within ANGLE."""
    x = MidRadius(a.middle)
    return widened(x * _series(x * x, range(1, 14, 2)), a.radius)


def cosine(a: MidRadius) -> MidRadius:
    """Cosines of arguments within ANGLE."""
    x = MidRadius(a.middle)
    return widened(_series(x * x, range(0, 15, 2)), a.radius * (np.abs(a.middle) + a.radius))


def _exp_of(x: Floats) -> MidRadius:
    times = np.rint(x / log(2.0))
    series = _series(MidRadius(x) - MidRadius(times) * LN_2, range(14))
    power = np.ldexp(1.0, times.astype(int))
    return MidRadius(series.middle * power, series.radius * power)


def _tanh_of(x: Floats) -> MidRadius:
    size = np.abs(x)
    part = MidRadius(2.0) / (_exp_of(2 * np.minimum(size, SATURATED)) + MidRadius(1.0))
    result = MidRadius(1.0) - part
    far = size > SATURATED
    middle = np.where(far, 1.0, result.middle)
    return MidRadius(np.copysign(middle, x), np.where(far, ONE_OFF, result.radius))


def exponential(a: MidRadius) -> MidRadius:
    """Exponentials of arguments within EXPONENT."""
    return _between(*(_exp_of(end) for end in _ends(a)))


def hyperbolic_tangent(a: MidRadius) -> MidRadius:
    """Hyperbolic tangents of any arguments."""
    return _between(*(_tanh_of(end) for end in _ends(a)))


def _ends(a: MidRadius) -> list[Floats]:
    if not a.radius.any():
        return [np.asarray(a.middle, dtype=float)]
    return list(a.ends)


def _between(low: MidRadius, high: MidRadius | None = None) -> MidRadius:
    """Enclosure of an increasing function with these values at the ends of its argument."""
    if high is None:
        return low
    apart = high - low
    middle = low.middle + apart.middle / 2
    return widened(MidRadius(middle), apart.most / 2 + low.radius + high.radius)
