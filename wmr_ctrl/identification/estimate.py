"""From samples to estimates: starts, the model that is taken, intervals, verdicts, the score.

Could the log tell?  Each parameter gets a verdict, mixtures get words, and seconds are named.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np

from wmr_ctrl.identification import lint
from wmr_ctrl.identification.fit import (
    ACCEPTED,
    LAG_LEAST,
    Fit,
    LogProblem,
    first_guess,
    half_widths,
    scored,
    searched,
    standard_errors,
)
from wmr_ctrl.identification.graph import LOGARITHMIC
from wmr_ctrl.identification.reading import BLOCKS, Floats, Samples
from wmr_ctrl.scenario import Scenario

START_SECONDS = 30.0
"""Length of the piece on which starts are tried [s]."""
ROUGH = 0.1
"""Gain in log-likelihood below which a fit ends that is compared alone."""
SPLITS = (0.2, 0.5, 0.8)
"""Shares of delay in the time from command to force that fits are started from."""
LATENESS, SURE_PASSES = (0.03, 0.1, 0.3), 12
"""Delay and lag together [s] that further fits start from where a log tells little."""
LOW_SPEED, LOW_FADING, LOW_FACTOR = 0.06, 0.1, 10.0
"""Speed of a wheel below which the force noise counts LOW_FACTOR times [m/s], fading over [s]."""
MOVED = 3.5
"""Standard errors of the worse fit from which on a parameter has moved."""
HELD_OUT = 1 / 3
AFFECTED = ("resistance", "gust", "wheels", "slope", "motor", "push")
"""Sections of what is known that the identified numbers take the place of."""
FREE_RUN = 1.0
TOLD, ROUGHLY, NOT_TOLD = "told", "roughly", "not told"
SHARES = (0.1, 0.3)
"""Half-width over size up to which a parameter is told, or roughly told."""
PHYSICAL = ("m", "I", "Fc", "Fv", "c", "Mv", "delay", "lag")
WORDS = {
    "m": "mass", "I": "moment of inertia", "Fc": "Coulomb friction of the body",
    "Fv": "friction of speed", "c": "Coulomb friction of each wheel", "Mv": "friction of turning",
    "delay": "delay of commands", "lag": "lag of the drives",
    "gain1": "gain of v", "wn1": "natural frequency of v", "zeta1": "damping of v",
    "tau1": "time constant of v", "gain2": "gain of omega", "wn2": "natural frequency of omega",
    "zeta2": "damping of omega", "tau2": "time constant of omega",
    "delay1": "delay of v", "delay2": "delay of omega",
    "accel1": "acceleration limit of v", "accel2": "acceleration limit of omega",
}  # fmt: skip
UNITS = {
    "m": "kg", "I": "kg.m2", "Fc": "N", "Fv": "N.s/m", "c": "N", "Mv": "N.m.s/rad", "delay": "s",
    "lag": "s", "gain1": "1", "gain2": "1", "wn1": "rad/s", "wn2": "rad/s", "zeta1": "1",
    "zeta2": "1", "tau1": "s", "tau2": "s", "delay1": "s", "delay2": "s", "accel1": "m/s2",
    "accel2": "rad/s2",
}  # fmt: skip
BECAUSE = {
    frozenset({"Fc", "c"}): "the wheels never turned against each other",
    frozenset({"Fc", "Fv"}): "the log knows one speed",
    frozenset({"c", "Fv"}): "the log knows one speed",
    frozenset({"Mv", "c"}): "the log knows one rate of turning",
    frozenset({"delay", "lag"}): "torques changed too slowly or too little",
    frozenset({"m", "delay"}): "the robot hardly accelerated",
    frozenset({"m", "lag"}): "the robot hardly accelerated",
    frozenset({"I", "delay"}): "the robot hardly turned faster or slower",
    frozenset({"tau1", "delay1"}): "v_command changed too slowly or too little",
    frozenset({"tau2", "delay2"}): "omega_command changed too slowly or too little",
}
"""Pairs that cannot be told apart, and what the log lacks then."""
SMALL, PART = 0.03, 0.35


class Estimate(NamedTuple):
    """A value with its 95 % interval, whether the log told it, when it did [s], and the half-width
    as a share of what the verdict compares it with.
    """

    value: float
    low: float
    high: float
    verdict: str
    seconds: tuple[float, float] = (0.0, 0.0)
    share: float = 0.0

    def to_json(self) -> dict[str, object]:
        """Plain data."""
        return {
            "value": self.value,
            "low": self.low,
            "high": self.high,
            "told": self.verdict,
            "seconds": list(self.seconds),
        }


@dataclass(frozen=True)
class Score:
    """How the held-out third was foretold: shares of both speeds' variance, by the fit and by
    constant velocities; [s] from where on it was held out.

    ``usable_speed`` of a guard with the bounds, and what one newton more of dbar costs [m/s]; None
    where the guard refuses them.
    """

    foretold: tuple[float, float]
    constant_velocity: tuple[float, float]
    held_out_from: float
    usable_speed: float | None = None
    one_newton_more: float | None = None


def verdict(half: float, size: float) -> str:
    """Told, roughly or not told, of a half-width and the size that it is compared with."""
    share = half / max(size, 1e-300)
    return TOLD if share <= SHARES[0] else ROUGHLY if share <= SHARES[1] else NOT_TOLD


def sizes(values: Mapping[str, float], speed: Floats, period: float) -> dict[str, float]:
    """Sizes that half-widths are compared with: a value, or for what may be 0 a share of its kind.

    ``speed`` (2,): rms speeds.  Friction is compared with a quarter of all friction at these
    speeds at least, a time with a control period.
    """
    v, w = np.maximum(speed, 1e-3)
    ahead = abs(values["Fc"]) + 2 * abs(values["c"]) + abs(values["Fv"]) * v
    turning = abs(values["Mv"]) * w + 2 * abs(values["c"]) * 0.2
    least = {"Fc": ahead / 4, "c": ahead / 8, "Fv": ahead / 4 / v, "Mv": turning / 4 / w,
             "delay": period, "lag": period}  # fmt: skip
    return {name: max(abs(value), least.get(name, 0.0)) for name, value in values.items()}


def seconds_that_told(t: Floats, share: Floats) -> tuple[float, float]:
    """Shortest stretch [s] that has half of the information ``share`` (B,) on one parameter."""
    total, edges = share.sum(), np.linspace(t[0], t[-1], BLOCKS + 1)
    for length in range(1, BLOCKS + 1):
        sums = np.convolve(share, np.ones(length), "valid")
        if sums.max() >= 0.5 * total:
            first = int(np.argmax(sums))
            return float(edges[first]), float(edges[first + length])
    return float(t[0]), float(t[-1])


def mixtures(names: Sequence[str], information: Floats, vague: set[str]) -> Iterator[str]:
    """Sentences on parameters that the log cannot tell apart, those among ``vague``.

    From the small eigenvalues of the Fisher information (n, n) with unit diagonal.
    """
    scale = np.sqrt(np.maximum(np.diag(information), 1e-300))
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    for value, vector in zip(values, vectors.T, strict=True):
        mixed = [names[k] for k in np.argsort(-np.abs(vector)) if abs(vector[k]) > PART]
        if value > SMALL or len(mixed) < 2 or not set(mixed) & vague:
            continue
        why = next((text for pair, text in BECAUSE.items() if pair <= set(mixed)), "")
        listed = " and ".join((", ".join(WORDS[n] for n in mixed[:-1]), WORDS[mixed[-1]]))
        yield f"{listed} cannot be told apart" + (f": {why}." if why else " by this log.")


def free_of(problem: LogProblem, coloured: bool) -> np.ndarray:
    """Parameters that are searched (n,): with a coloured push or without."""
    names, left = problem.filter.graph.names, set() if coloured else {"s1", "s2", "time"}
    if not problem.log.of_speed:
        left |= {"n1", "n2"}
    return np.array([name not in left for name in names])


def started(problem: LogProblem, scenario: Scenario, tell: Callable[[], None]) -> Floats:
    """The best of a few starts, on the first piece of the log; delay and lag share a time."""
    log, robot = problem.log, scenario.robot
    force = np.column_stack((
        log.command.sum(axis=1), robot.l * (log.command[:, 0] - log.command[:, 1])
    )) / robot.r  # fmt: skip
    guess, shift = first_guess(replace(log, command=force))
    names = problem.filter.graph.names
    piece = replace(problem, log=log.until(log.t[0] + START_SECONDS))
    rest = {"q1": 0.1 * guess["m"], "q2": 0.1 * guess["I"], "s1": 0.0, "s2": 0.0, "time": 1.0}
    noise = 1e-3 if log.of_speed else 1.0
    late = max(shift, log.period)
    tried = []
    for split in SPLITS:
        start = guess | rest | {"n1": noise, "n2": noise}
        start |= {"delay": late * split, "lag": max(late * (1 - split), 1e-3)}
        tried.append(scored(piece, searched(start, names), free_of(problem, False), 8, tell, ROUGH))
    return min(tried, key=lambda item: item.nll).theta


def white_fit(problem: LogProblem, scenario: Scenario, tell: Callable[[], None]) -> Fit:
    """The fit with white force noise; where delay or lag is at an end also from its other split."""
    names, free = problem.filter.graph.names, free_of(problem, False)
    fit = scored(problem, started(problem, scenario, tell), free, tell=tell)
    late = [names.index("delay"), names.index("lag")]
    delay, lag = fit.theta[late]
    if delay > 0 and lag > LAG_LEAST:
        return fit
    start = fit.theta.copy()
    share = SPLITS[-1] if delay <= 0 else SPLITS[0]
    start[late] = share * (delay + lag), (1 - share) * (delay + lag)
    other = scored(problem, start, free, tell=tell)
    return min(fit, other, key=lambda item: item.nll)


def coloured_if_likelier(white: Fit, tell: Callable[[], None]) -> tuple[Fit, float | None]:
    """The fit with a coloured push where twice its gain is above 4 ln n, else the white one."""
    names = white.problem.filter.graph.names
    best: Fit | None = None
    for time in (0.4, 3.0):
        start = white.theta.copy()
        for axis in ("1", "2"):
            start[names.index(f"s{axis}")] = white.theta[names.index(f"q{axis}")] - 1.0
        start[names.index("time")] = math.log(time)
        passes = 40 if best is None else 12
        fit = scored(white.problem, start, free_of(white.problem, True), passes, tell, ROUGH)
        best = fit if best is None or fit.nll < best.nll else best
    assert best is not None
    if 2 * (white.nll - best.nll) > 4 * math.log(white.problem.counted()):
        best = scored(white.problem, best.theta, best.free, tell=tell)
        return best, float(np.exp(best.theta[names.index("time")]))
    return white, None


def distrusting_low_speeds(
    fit: Fit, remarks: list[str], tell: Callable[[], None]
) -> tuple[Fit, list[str]]:
    """The fit with noise at low speeds counted more, where that moves a parameter; else ``fit``."""
    problem, names = fit.problem, fit.problem.filter.graph.names
    speed = np.abs(lint.wheels(lint.speeds(problem.log), problem.known[1])).min(axis=1)
    slow = np.flatnonzero(speed < LOW_SPEED)
    if not slow.size or slow.size > 0.8 * len(speed):
        return fit, remarks
    t = problem.log.t
    place = np.searchsorted(slow, np.arange(len(t)))
    ahead = np.abs(t[slow[np.minimum(place, slow.size - 1)]] - t)
    behind = np.abs(t[slow[np.maximum(place - 1, 0)]] - t)
    near = np.clip(1 - np.minimum(ahead, behind) / LOW_FADING, 0, 1)
    again = scored(
        replace(problem, boost=1 + (LOW_FACTOR - 1) * near), fit.theta, fit.free, tell=tell
    )
    errors = np.maximum.reduce([*standard_errors(fit), *standard_errors(again)])
    moved = [
        name
        for k, name in enumerate(names)
        if name in PHYSICAL and abs(again.theta[k] - fit.theta[k]) > MOVED * errors[k]
    ]
    if not moved:
        return fit, remarks
    said = (
        f"{', '.join(moved)} move{'s' if len(moved) == 1 else ''} where speeds below "
        f"{100 * LOW_SPEED:g} cm/s count less, as stiction or backlash make them; values are those "
        "of that fit, and Coulomb friction at low speed is not covered."
    )
    least = {names.index(name): abs(again.theta[names.index(name)] - fit.theta[names.index(name)])
            for name in moved}  # fmt: skip
    return replace(again, least=least), [*remarks, said]


def surest(fit: Fit, tell: Callable[[], None]) -> Fit:
    """The likeliest of several fits where this one knows delay or mass badly, else ``fit``.

    Maxima as high as a profile's interval reaches widen the intervals: none of them is refuted.
    """
    names, half = fit.problem.filter.graph.names, half_widths(fit)
    m, inertia, delay, lag = (names.index(name) for name in ("m", "I", "delay", "lag"))
    if half[delay] <= fit.problem.log.period and half[m] <= SHARES[0]:
        return fit
    fits = [fit]
    for late, (share, lighter) in product(LATENESS, ((SPLITS[0], 0.0), (SPLITS[-1], 0.7))):
        start = fit.theta.copy()
        start[[delay, lag]] = share * late, (1 - share) * late
        start[[m, inertia]] -= lighter
        fits.append(scored(fit.problem, start, fit.free, SURE_PASSES, tell))
    best = min(fits, key=lambda item: item.nll)
    near = [item.theta for item in fits if item.nll < best.nll + ACCEPTED]
    places = [k for k, name in enumerate(names) if name in PHYSICAL]
    least = {
        k: max(fit.least.get(k, 0.0), *(abs(x[k] - best.theta[k]) for x in near)) for k in places
    }
    return replace(best, least=least)


def intervals_of(fit: Fit) -> dict[str, tuple[float, float, float]]:
    """Value, low and high of each physical parameter, in SI units."""
    half, names = half_widths(fit), fit.problem.filter.graph.names
    step = plant_step(fit.problem.log.period)
    intervals = {}
    for name in PHYSICAL:
        place = names.index(name)
        value, width = float(fit.theta[place]), float(half[place])
        if name in LOGARITHMIC:
            value, width = math.exp(value), min(max(width, 2e-3), 50.0)
            intervals[name] = (value, value * math.exp(-width), value * math.exp(width))
            continue
        least = step / 2 if name in ("delay", "lag") else 2e-3 * abs(value)
        width = max(width, least)
        intervals[name] = (value, value - width, value + width)
    return intervals


def plant_step(period: float) -> float:
    """Step of the plant [s]: a whole part of a control period, of one millisecond at most."""
    return period / math.ceil(period / 1e-3 - 1e-9)


def parted(fit: Fit, passes: int, tell: Callable[[], None]) -> tuple[Fit, Fit, float]:
    """The fit of what lies before the last third, that of the last third, and its begin [s]."""
    problem = fit.problem
    t, boost = problem.log.t, problem.boost
    cut = float(t[-1] - HELD_OUT * (t[-1] - t[0]))
    fits, theta = [], fit.theta
    for begin, end in ((-np.inf, cut), (cut, np.inf)):
        own = None if boost is None else boost[(t >= begin) & (t < end)]
        part = replace(problem, log=problem.log.until(end, begin), boost=own)
        fits.append(replace(scored(part, theta, fit.free, passes, tell), least=fit.least))
        theta = fits[0].theta
    return fits[0], fits[1], cut


def score_of(white: Fit, trained: Fit, cut: float) -> Score:
    """How well the last third is foretold by a fit of the rest, in free runs of a second."""
    problem = white.problem
    rest = problem.log.until(np.inf, cut)
    result = replace(problem, log=rest).read(trained.theta, slopes=False)
    foretold, held = free_runs(problem, rest, trained.theta, result.mean)
    seen = result.mean[:, 2:4]
    total = np.sum((seen - seen.mean(axis=0)) ** 2, axis=0)
    shares = [1 - np.sum((item - seen) ** 2, axis=0) / np.maximum(total, 1e-12)
              for item in (foretold, held)]  # fmt: skip
    ours, constant = ((float(item[0]), float(item[1])) for item in shares)
    return Score(ours, constant, cut)


def free_runs(
    problem: LogProblem, log: Samples, theta: Floats, mean: Floats
) -> tuple[Floats, Floats]:
    """Speeds (N, 2) that runs of a second from the filter's means foretell, and those held."""
    index = np.arange(len(log.t))
    turn = np.floor((log.t - log.t[0]) / FREE_RUN)
    fresh = np.concatenate(([True], np.diff(turn) > 0))
    fresh[log.first] = True
    first = np.flatnonzero(fresh)
    begin = first[np.searchsorted(first, index, "right") - 1]
    foretold = problem.foretold(replace(log, first=first), theta, mean[first])
    return foretold[:, 2:4], mean[begin, 2:4]
