"""Peak gain of a linear speed loop: the largest speed that commands of at most 1 can cause.

    second order   v'' + 2 z w0 v' + w0^2 v = w0^2 (K u + d)
    PI loop        M v' = F - c v + d,  F = kp (u - v) + f,  f' = ki (u - v)

N, the integral of the impulse response's absolute value, is the largest |v| that commands |u| <= 1
can cause from rest, whether held, late, lost or jittering.  No smaller number is (Boyd, Doyle
1987).  With r = exp(-pi z/w), w = sqrt(1 - z^2) the remainder after half an oscillation (0 for z >=
1):

    second order   N = K (1 + r)/(1 - r)
    PI loop        N = 1 + 2 o/(1 - r),  o = exp(-2 z acos(z)/w),  z = kp/(2 sqrt(ki M)),  c = 0
    its push       4 z exp(-z acos(z)/w)/(1 - r) dbar/(kp + c),    z = (kp + c)/(2 sqrt(ki M))

N is enclosed over the whole family.  Boxes that cover its numbers are halved, each bounded by
intervals that are rounded outward, until none can exceed the largest value found by more than a few
millionths.  No corner is assumed to be the worst; `filter.peak-worst` says which one is.  If a
scenario simulates such a base, its loop, held over plant steps, is included in the family
(`held_loop`).
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from math import inf

import numpy as np

from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.scenario import Scenario

from .enclosure import Floats, Span, exp, increasing, root, square
from .held_loop import PI, HeldLoop, Through, held_loop

NEAR_ONE = 2.0**-5
"""Dampings nearer to 1 have bounds of their own, where w hardly differs from 0."""
OFF_ONE = 2.0**-20
"""Single dampings nearer to 1 are taken for one so far below, where the bound is larger."""
TOLERANCE = 2.0**-16
MOST_ROUNDS, MOST_BOXES = 100, 100_000

HALF_PI = 0.5 * PI


@dataclass(frozen=True)
class PeakGain:
    """Largest |v| per commanded speed, and largest |v| caused by the push alone [m/s, rad/s]."""

    gain: float
    push: float


@dataclass(frozen=True)
class PiLoop:
    """Family of PI loops of one axis, all numbers intervals: M, kp, ki, c, at the wheels' rim.

    Units: kg, N.s/m, N/m, N.s/m; numbers of the angular axis are divided by l^2.  ``held``: the
    simulated base, in addition.
    """

    M: tuple[float, float]
    kp: tuple[float, float]
    ki: tuple[float, float]
    c: tuple[float, float]
    held: HeldLoop | None = None

    def peak(self, push: float) -> PeakGain:
        """Peak gain of the whole family; ``push`` [N] is its largest disturbance."""
        gain, pushed = _peak(self)
        return PeakGain(gain, float((Span.of(pushed) * push).hi) if push else 0.0)


@lru_cache(maxsize=64)
def _peak(loop: PiLoop) -> tuple[float, float]:
    """N of a family, and the response to a push of 1 N, over boxes that cover it."""
    M, kp, ki, c = (Span.of(*pair) for pair in (loop.M, loop.kp, loop.ki, loop.c))
    s = root(ki * M)
    family = largest(_gain_bound, kp / s, c / s), largest(_push_bound, kp + c, s)
    own = loop.held.through() if loop.held else None
    pairs = zip(family, _of_held(own) if own else family, strict=True)
    gain, pushed = map(max, pairs)
    return gain, pushed


def _of_held(own: Through) -> tuple[float, float]:
    """N, and the response to a push of 1 N, of a held loop."""
    s, share = root(own.b), own.mass / own.ratio
    gain = _gain_bound((own.a - own.gamma) / s, own.gamma / s)
    return float(gain), float(_push_bound(own.a * share, s * share))


def largest(bound: Callable[[Span, Span], Floats], first: Span, second: Span) -> float:
    """Upper bound of a function of two numbers on a box, close to its maximum.

    ``bound``: the function's upper bounds on many boxes at once.  Boxes are halved until none may
    exceed the largest value seen at centres by more than `TOLERANCE`, relatively.
    """
    x, y = (Span(np.atleast_1d(item.lo), np.atleast_1d(item.hi)) for item in (first, second))
    wide = [_width(item) for item in (x, y)]
    seen, most = -np.inf, -np.inf
    for _ in range(MOST_ROUNDS):
        upper = np.nan_to_num(bound(x, y), nan=np.inf)
        middle = (Span.of(0.5 * (item.lo + item.hi)) for item in (x, y))
        seen = max(seen, float(bound(*middle).max()))
        left = upper > seen * (1 + TOLERANCE)
        most = max(most, float(upper[~left].max(initial=-np.inf)))
        if not left.any() or left.sum() > MOST_BOXES:
            break
        x, y = _halves(x[left], y[left], wide)
    return max(most, float(upper[left].max(initial=-np.inf)))


def _width(x: Span) -> float:
    """Length of a box's side; inf for a side of rounding width, which is not split."""
    length = float(x.hi[0] - x.lo[0])
    return length if length > 2.0**-40 * float(x.size[0]) + 2.0**-900 else np.inf


def _halves(x: Span, y: Span, wide: Sequence[float]) -> tuple[Span, Span]:
    """Both halves of boxes, split across the side that is longer in the first box."""
    across = (x.hi - x.lo) / wide[0] >= (y.hi - y.lo) / wide[1]
    cut_x, cut_y = 0.5 * (x.lo + x.hi), 0.5 * (y.lo + y.hi)
    lower = Span(x.lo, np.where(across, cut_x, x.hi)), Span(y.lo, np.where(across, y.hi, cut_y))
    upper = Span(np.where(across, cut_x, x.lo), x.hi), Span(np.where(across, y.lo, cut_y), y.hi)
    linear, angular = (
        Span(np.concatenate([a.lo, b.lo]), np.concatenate([a.hi, b.hi]))
        for a, b in zip(lower, upper, strict=True)
    )
    return linear, angular


def _gain_bound(b: Span, drag: Span) -> Floats:
    """Upper bounds of N for b = kp/sqrt(ki M) and drag = c/sqrt(ki M), 2 z = b + drag.

    The overshoot is rho exp(-z t0), rho^2 = 1 - b drag, and t0 the first zero of the impulse
    response.  With y = b z - 1, t0 is acot(y/(b w))/w for z < 1, and artanh(b w/y)/w for z > 1 if
    there is such a zero.  Near z = 1 both are b/rho times arcsin(q)/q, q^2 = (b/rho)^2 (1 - z^2),
    if y > 0; in any case they are at least b over rho, or over y.
    """
    z = 0.5 * (b + drag)
    y, rho, w = b * z - 1, root(1 - b * drag), _frequency(z)
    turned = increasing(np.arctan, y / _positive(b * w))
    swinging = ((HALF_PI - turned) / _positive(w)).lo
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(y.hi > 0, (Span.of((b * w).lo) / _positive(y)).lo, np.inf)
        creeping = np.where(
            share < 1, (increasing(np.arctanh, Span.of(np.minimum(share, 1 - 2.0**-53)))
                        / _positive(w)).lo, np.inf,
        )  # fmt: skip
        slope = b / _positive(rho)
        least = np.where(y.hi > 0, np.minimum(slope.lo, (b / _positive(y)).lo), slope.lo)
        arc = _arc(square(slope) * ((1 - z) * (1 + z)))
        near = np.where(y.lo > 0, np.maximum(least, (slope * Span.of(arc)).lo), least)
    t0 = np.select([z.hi < 1 - NEAR_ONE, z.lo > 1 + NEAR_ONE], [swinging, creeping], near)
    over = rho * exp(-(Span.of(z.lo) * Span.of(np.maximum(t0, 0.0))))
    return (1 + 2 * over / _positive(1 - _left(z, w))).hi


def _push_bound(k: Span, s: Span) -> Floats:
    """Upper bounds of 2 exp(-z acos(z)/w)/((1 - r) s) with z = k/(2 s): the response to 1 N."""
    z = k / (2 * s)
    w = _frequency(z)
    swinging = ((HALF_PI - increasing(np.arctan, z / _positive(w))) / _positive(w)).lo
    creeping = (increasing(np.arccosh, Span.of(np.maximum(z.lo, 1.0))) / _positive(w)).lo
    near = _arc((1 - z) * (1 + z))
    ratio = np.select([z.hi < 1 - NEAR_ONE, z.lo > 1 + NEAR_ONE], [swinging, creeping], near)
    faded = exp(-(Span.of(z.lo) * Span.of(np.maximum(ratio, 0.0))))
    return (2 * faded / (_positive(1 - _left(z, w)) * s)).hi


def _frequency(z: Span) -> Span:
    """sqrt(|1 - z^2|)."""
    return root(((1 - z) * (1 + z)).magnitude)


def _arc(x: Span) -> Floats:
    """Lower bounds of arcsin(q)/q, q^2 = x, and for x < 0 of arsinh(q)/q, q^2 = -x; increasing.

    It is the start of the series, whose further terms are positive for x > 0 and alternate for x <
    0.  The bound is 0 if x may be below -1.
    """
    least = Span.of(np.clip(x.lo, -1.0, 1.0))
    cubic = 1 + least * (Span.of(1.0) / 6 + least * (Span.of(3.0) / 40 + least * 15 / 336))
    return np.where(x.lo >= -1, cubic.lo, 0.0)


def _left(z: Span, w: Span) -> Span:
    """r = exp(-pi z/w), 0 from z = 1 on."""
    left = exp(-(PI * Span.of(z.lo) / _positive(Span.of(w.hi))))
    return Span(np.zeros_like(z.lo), np.where(z.lo >= 1, 0.0, left.hi))


def _positive(x: Span) -> Span:
    """Part of intervals above 2^-100; the rest does not matter to callers."""
    return Span(np.maximum(x.lo, 2.0**-100), np.maximum(x.hi, 2.0**-100))


def refuse_all(faults: Iterable[str]) -> None:
    """Raise ScenarioError with the distinct sentences about both axes, if there are any."""
    if said := " ".join(dict.fromkeys(faults)):
        raise ScenarioError(said)


def peak_gains(scenario: Scenario) -> tuple[PeakGain, PeakGain]:
    """Peak gains of v's and omega's loop, as a scenario's filter states them."""
    return _peak_gain(scenario, 0), _peak_gain(scenario, 1)


def _peak_gain(scenario: Scenario, axis: int) -> PeakGain:
    """Peak gain of an axis; for a first-order loop, which never overshoots, its gain."""
    settings = scenario.filter
    loop, d, (_, K) = settings.loop[axis], settings.d[axis], settings.intervals("gain")[axis]
    if loop == "first-order":
        return PeakGain(K, d)
    if loop == "second-order":
        return second_order(settings.intervals("damping")[axis][0], K, d)
    push = settings.push[axis]
    if axis and push:
        push = over_square((0.0, push), scenario.robot.l)[1]
    return _with_error(pi_loop(scenario, axis).peak(push), d)


def _with_error(peak: PeakGain, error: float) -> PeakGain:
    """Sum of the peak gain and of a command error's peak gain."""
    pushed = (peak.push + peak.gain * error) * (1 + 2.0**-50)
    return replace(peak, push=pushed) if error else peak


def pi_loop(scenario: Scenario, axis: int) -> PiLoop:
    """Family of PI loops of an axis, as a scenario's filter states it, and the simulated base."""
    settings, l = scenario.filter, scenario.robot.l
    kp, ki, c = settings.interval("kp"), settings.interval("ki"), settings.friction
    M = over_square(settings.interval("inertia"), l) if axis else settings.interval("mass")
    return PiLoop(M, kp, ki, c, held_loop(scenario, axis))


def over_square(values: tuple[float, float], l: float) -> tuple[float, float]:
    """Bounds of values divided by l^2: a lower bound of the first, an upper bound of the second."""
    least, most = (Span.of(value) / square(Span.of(l)) for value in values)
    return max(float(least.lo), 0.0), float(most.hi)


def second_order(damping: float, gain: float, d: float) -> PeakGain:
    """Peak gain of loops with at least this damping and at most this steady gain.

    ``d``: the steady speed due to the push alone.
    """
    _, _, left = _swing(_off_one(damping, -1))
    if not (1 - left).lo > 0:  # no swing is certainly smaller than the one before
        return PeakGain(inf, inf)
    most = (1 + left) / (1 - left)  # r = exp(-pi/sqrt(1/z^2 - 1)) falls with z
    return PeakGain(float((most * gain).hi), float((most * d).hi) if d else 0.0)


def overshoot(scenario: Scenario) -> tuple[float, float]:
    """Largest relative overshoot of a step of v and of omega, for the stated numbers.

    Computed in doubles, at the corner with the largest N.
    """
    v, omega = (_overshoot(scenario, axis, _damping(scenario, axis)) for axis in (0, 1))
    return v, omega


def less_damped(scenario: Scenario, axis: int, more: float) -> float:
    """Factor by which a base's damping must shrink to raise its overshoot by ``more``."""
    z = _damping(scenario, axis)
    wanted, low, high = _overshoot(scenario, axis, z) + more, 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        less = _overshoot(scenario, axis, middle * z) < wanted
        low, high = (low, middle) if less else (middle, high)
    return low


BISECTIONS = 40


def _damping(scenario: Scenario, axis: int) -> float:
    """Least damping of an axis: that of a PI loop without friction, or 1 for a first-order loop."""
    settings = scenario.filter
    if settings.loop[axis] == "first-order":
        return 1.0
    if settings.loop[axis] == "second-order":
        return settings.intervals("damping")[axis][0]
    loop = pi_loop(scenario, axis)
    return float(loop.kp[0] / (2 * (loop.ki[1] * loop.M[1]) ** 0.5))


def _overshoot(scenario: Scenario, axis: int, damping: float) -> float:
    z, ratio, left = _swing(_off_one(damping, -1))
    own = exp(-2 * z * ratio) if scenario.filter.loop[axis] == "pi" else left
    return float(own.hi)


def _off_one(z: float, way: int) -> float:
    """The damping, moved away from 1 if it is near: below for ``way`` -1, above for 1."""
    return 1 + way * OFF_ONE if abs(z - 1) < OFF_ONE else z


def _swing(damping: float) -> tuple[Span, Span, Span]:
    """z, acos(z)/w and r = exp(-pi z/w); beyond 1 acosh(z)/sqrt(z^2 - 1) and 0."""
    z = Span.of(damping)
    w = root(((1 - z) * (1 + z)).magnitude)
    if damping >= 1:
        return z, increasing(np.arccosh, z) / w, Span.of(0.0)
    return z, increasing(np.arctan, w / z) / w, exp(-(PI * z / w))
