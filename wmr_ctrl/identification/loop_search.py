"""Structures beside an axis' loop that a log may need, tried one by one.

Source: logs of real bases: ramps that differ up and down, dead bands, offsets, saturation, a gain
that depends on direction, speed or time, a constant push.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from .fit import ACCEPTED
from .logs.log import Floats, Names
from .logs.samples import AxisLog
from .speed_loop import (
    LINEAR,
    LOOPS,
    MOST_VAGUE,
    RANGES,
    WITHOUT,
    LoopFit,
    Values,
    fitted,
    foretold,
    searched,
)

MOST = 3
LESS_BIC = 10.0
"""Least fall of the criterion."""
LESS_BIC_ROW = 0.01
"""Least fall of the criterion for each row of the fit."""
LESS_SQUARES = 0.9
"""Largest share of the sum of squares that may remain."""
LEAST_GAIN = 0.05
"""Least share of its gain that may be left to a base before or after a time."""
SQUARES_WIN = 0.8
"""Share of the squares of the likelihood's fit below which least squares are taken: its
autoregression can swallow a slow misfit."""
PASSES, PLAIN = 15, 3
SPEEDS = (0.03, 0.1, 0.3)
"""Time constants that fits are started from [s]."""
GAIN_OF_BIC = 4.0
MORE: Sequence[Names] = ((), ("accel",), ("lag",))
"""Parameters that may be added to a loop before further structures."""
LAGS = 0.01 * 2 ** (np.arange(12) / 2)
"""Lags of a sensor that a log may hide [s]."""
Starts = Callable[[LoopFit], Sequence[Values]]


@dataclass(frozen=True)
class Member:
    """A structure: names of searched and of fixed parameters; start values from a fit."""

    names: Names
    fixed: Names
    starts: Starts


def _sent(fit: LoopFit, quantiles: Sequence[float] | Floats) -> list[float]:
    """Quantiles of the sizes of non-zero commands."""
    size = np.abs(fit.log.sent[fit.log.sent != 0])
    return np.unique(np.quantile(size, quantiles)).tolist() if size.size else []


def _shares(name: str, quantiles: Sequence[float] | Floats, *shares: float) -> Starts:
    """Starts of a parameter at fractions of quantiles of the commands' sizes."""
    return lambda fit: [{name: share * x} for x in _sent(fit, quantiles) for share in shares]


def _slowing(fit: LoopFit) -> Sequence[Values]:
    now = fit.values.get("accel", fit.steepest)
    return [{"accel": now, "decel": now * share} for share in (0.25, 0.5, 2.0, 4.0)]


def _cuts(fit: LoopFit) -> Sequence[Values]:
    """Gains before and after several candidate times, each by least squares."""
    log, y, starts = fit.log, fit.forecast, []
    for time in np.quantile(log.t[log.in_fit], np.arange(0.1, 0.91, 0.04)).tolist():
        sides = [log.in_fit & side for side in (log.t < time, log.t >= time)]
        before, after = (y[k] @ log.speed[k] / max(y[k] @ y[k], 1e-300) for k in sides)
        if min(before, after) > LEAST_GAIN:
            gain = fit.gain * float(before)
            starts.append({"gain": gain, "when": time, "then": float(after / before)})
    return starts


MENU: Mapping[str, Member] = {
    "decel": Member(("accel", "decel"), (), _slowing),
    "dead-band": Member((), ("dead",), _shares("dead", np.arange(0.02, 0.5, 0.02), 1 + 1e-9)),
    "offset": Member(("offset",), (), _shares("offset", (0.5,), 0.05, 0.1, 0.2, 0.4)),
    "saturation": Member(("sat",), (), _shares("sat", (0.3, 0.5, 0.65, 0.8, 0.9), 1.0)),
    "sides": Member(("back",), (), lambda fit: [{"back": x} for x in (0.8, 0.95, 1.05, 1.25)]),
    "curve": Member(("curve",), (), lambda fit: [
        {"curve": share / x} for x in _sent(fit, (0.95,)) for share in (-0.3, -0.05, 0.05, 0.3)
    ]),
    "change": Member(("then",), ("when",), _cuts),
    "bias": Member(("bias",), (), lambda fit: [
        {"bias": float(fit.left[fit.log.in_fit].mean())}
    ]),
}  # fmt: skip
"""Structures by the key of their diagnosis."""


def axis_fit(log: AxisLog, loops: Names = tuple(LOOPS)) -> LoopFit:
    """The likeliest loop of one axis with the structures that its log needs, and equally likely
    fits.
    """
    fit = plain = best_loop(log, loops)
    for _ in range(MOST):
        better = _one_more(fit)
        if better is None:
            break
        fit = better
    if fit is not plain:
        again = best_loop(log, loops, fit)
        fit = again if again.bic < fit.bic - GAIN_OF_BIC else fit
    squared, others = _again(fit, fit.values, PASSES, PASSES), tuple(_as_likely(fit))
    return replace(squared if squared.squares < SQUARES_WIN * fit.squares else fit, others=others)


def _as_likely(fit: LoopFit) -> Iterator[LoopFit]:
    """Fits of a loop that overshoots, behind sensors whose lag the log does not show."""
    one = fit
    for lag in LAGS if "zeta" in fit.names and "lag" not in fit.names else ():
        fixed = {**fit.fixed, "lag": lag}
        one = fitted(fit.log, fit.loop, fit.names, one.theta, PASSES, fixed=fixed)
        if one.nll.sum() > fit.nll.sum() + ACCEPTED:
            return
        yield one


def best_loop(log: AxisLog, loops: Names, beside: LoopFit | None = None) -> LoopFit:
    """The likeliest loop by Schwarz's criterion (BIC), with a ramp if that improves it.

    A simpler loop is replaced only if a richer one gains more than by chance and its numbers are
    determined.  ``beside``: a fit whose structures are kept.
    """
    members = () if beside is None else tuple(n for n in beside.members if n != "lag")
    fixed = {} if beside is None else dict(beside.fixed)
    tried = []
    for more, loop in product(MORE, loops):
        if ("accel" in more and members) or {*more, *members} & {*WITHOUT[loop]}:
            continue
        names = (*LOOPS[loop], *more, *members)
        start = _nearest(log, loop, [fixed | item for item in _starts(log, names, beside)])
        tried.append(fitted(log, loop, names, searched(start, names), 2 * PASSES, PASSES, fixed))
    best, *richer = sorted(tried, key=lambda item: len(item.theta))
    for fit in richer:
        if not fit.vague and fit.bic < best.bic - GAIN_OF_BIC:
            best = fit
    return best


def _starts(log: AxisLog, names: Names, beside: LoopFit | None) -> list[dict[str, float]]:
    wide = max(round(0.1 / log.period), 1)
    slopes = np.abs(log.speed[wide:] - log.speed[:-wide])[log.in_fit[wide:]] / (wide * log.period)
    steepest = max(float(np.quantile(slopes, 0.98)), 0.02)
    gain = max(log.follows[0], RANGES["gain"][0])
    grid: dict[str, Sequence[float]] = {
        "gain": (gain, 1.25 * gain) if "accel" in names else (gain,),
        "tau": SPEEDS, "wn": [1 / x for x in SPEEDS], "zeta": (0.35, 1.0),
        "delay": (0.01, 0.06, 0.15), "lag": SPEEDS,
        "accel": (0.7 * steepest, 1.1 * steepest, 2 * steepest),
    }  # fmt: skip
    if beside is not None:
        grid |= {name: (beside.values[name],) for name in ("gain", *beside.members)
                 if name in beside.values}  # fmt: skip
    combinations = product(*(grid[name] for name in names))
    return [dict(zip(names, values, strict=True)) for values in combinations]


def _one_more(fit: LoopFit) -> LoopFit | None:
    """The likeliest fit with one further structure, if that improves the criterion; else None."""
    tried = []
    for key, member in MENU.items():
        ours = (*member.names, *member.fixed)
        if {*ours} <= {*fit.names, *fit.fixed} or {*ours} & {*WITHOUT[fit.loop]}:
            continue
        starts = [{**fit.values, **start} for start in member.starts(fit)]
        if not starts:
            continue
        one = _again(fit, _nearest(fit.log, fit.loop, starts), PASSES, PLAIN, member)
        if member.fixed:
            one = _refined(one, member.fixed[0], [item[member.fixed[0]] for item in starts])
        most = 1.0 if key == "decel" else LESS_SQUARES
        half = one.half_widths()
        sizes = {name: abs(one.values[name]) if name in LINEAR else 1.0 for name in member.names}
        sure = all(half[name] < MOST_VAGUE * size for name, size in sizes.items())
        if sure and not one.too_steep and one.squares <= most * fit.squares:
            tried.append(one)
    best = min(tried, key=lambda item: item.bic, default=None)
    least = max(LESS_BIC, LESS_BIC_ROW * fit.log.in_fit.sum())
    return best if best is not None and best.bic < fit.bic - least else None


def _nearest(log: AxisLog, loop: str, sets: list[dict[str, float]]) -> dict[str, float]:
    """The set of parameters whose predicted speeds are nearest to the log's."""
    left = foretold(log, loop, sets) - log.speed[:, None]
    return sets[int(np.argmin(np.sum(left[log.in_fit] ** 2, axis=0)))]


def _again(
    fit: LoopFit, values: Values, passes: int, plain: int = 0, more: Member | None = None
) -> LoopFit:
    """Refit from other start values, with one further structure."""
    names = tuple(dict.fromkeys((*fit.names, *(more.names if more else ()))))
    kept = {*fit.fixed, *(more.fixed if more else ())}
    fixed = {name: values[name] for name in kept}
    return fitted(fit.log, fit.loop, names, searched(values, names), passes, plain, fixed)


def _refined(fit: LoopFit, name: str, starts: list[float]) -> LoopFit:
    """Refit from a finer grid between neighbouring starts, for a number that is not searched."""
    near = np.unique(starts)
    at = int(np.argmin(np.abs(near - fit.fixed[name])))
    ends = near[max(at - 1, 0)], near[min(at + 1, len(near) - 1)]
    sets = [{**fit.values, name: float(x)} for x in np.linspace(*ends, 23)]
    return _again(fit, _nearest(fit.log, fit.loop, sets), PASSES)
