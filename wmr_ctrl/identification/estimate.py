"""Estimation from samples of torques: start values, choice of the model; scores."""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from operator import attrgetter, itemgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.world.scenario import Scenario, from_dict, scenario_dict
from wmr_ctrl.world.scenario.scenario import multiples

from .bounds import SHARES, Score, Traces
from .fit import (
    ACCEPTED,
    LAG_LEAST,
    Fit,
    LogProblem,
    half_widths,
    plant_step,
    scored,
)
from .kalman import INDEX, LOGARITHMIC, NAMES
from .logs.log import Floats
from .logs.samples import Samples, differenced, gains, shifts_of

START_SECONDS = 30.0
"""Length of the piece on which starts are tried [s]."""
ROUGH = 0.1
"""Gain in log-likelihood below which a fit ends that is compared alone."""
SPLITS = (0.2, 0.5, 0.8)
"""Shares of delay in the time from command to force that fits are started from."""
LATENESS, SURE_PASSES = (0.03, 0.1, 0.3), 12
"""Delay and lag together [s] that further fits start from where a log tells little."""
HELD_OUT = 1 / 3
PART_PASSES = 12
"""Passes of the fit of a part of a log, from that of the whole."""
REPLACED = (
    *("resistance", "gust", "wheels", "slope", "motor", "push"),
    *("changes", "model", "actuator", "guard.M_min", "guard.M_max", "guard.dbar", "guard.nbar"),
    *("guard.delay", "guard.lag", "base.delay"),
)
"""Tables and keys of what is known that the identified numbers take the place of."""
FREE_RUN = 1.0


def first_guess(log: Samples, r: float, half_track: float) -> tuple[dict[str, float], float]:
    """Start values by regression, without friction: m, I, and time from command to force [s]."""
    moved, torque = differenced(log, half_track)
    tried = [(*gains(moved, torque(shift)), shift) for shift in shifts_of(log.period) if shift >= 0]
    _, gain, shift = max(tried, key=itemgetter(0))
    ahead, turn = (max(float(sides @ gain @ sides), 1e-3) for sides in ([1, 1], [1, -1]))
    m, inertia = 4 / (r * ahead), 4 * half_track**2 / (r * turn)
    return {"m": m, "I": inertia} | dict.fromkeys(("Fc", "Fv", "Mv", "c"), 0.0), float(shift)


def searched(values: dict[str, float]) -> Floats:
    """Parameters in the order and scaling of the search."""
    with np.errstate(divide="ignore"):
        return np.array([np.log(values[n]) if n in LOGARITHMIC else values[n] for n in NAMES])


def free_of(problem: LogProblem, coloured: bool) -> np.ndarray:
    """Mask (n,) of the parameters that are searched, with or without a coloured push."""
    left = set() if coloured else {"s1", "s2", "time"}
    if not problem.log.of_speed:
        left |= {"n1", "n2"}
    return np.array([name not in left for name in NAMES])


def started(problem: LogProblem) -> Floats:
    """Best of a few starts on the log's first piece; delay and lag share one time."""
    log = problem.log
    guess, shift = first_guess(log, *problem.known[:2].tolist())
    piece = replace(problem, log=log.until(log.t[0] + START_SECONDS))
    rest = {"q1": 0.1 * guess["m"], "q2": 0.1 * guess["I"], "s1": 0.0, "s2": 0.0, "time": 1.0}
    noise = 1e-3 if log.of_speed else 1.0
    late = max(shift, log.period)
    tried = []
    for split in SPLITS:
        start = guess | rest | {"n1": noise, "n2": noise}
        start |= {"delay": late * split, "lag": max(late * (1 - split), 1e-3)}
        tried.append(scored(piece, searched(start), free_of(problem, False), 8, ROUGH))
    return likeliest(tried).theta


def likeliest(fits: Sequence[Fit]) -> Fit:
    """The fit with the largest likelihood; the first one if several are equal."""
    return min(fits, key=attrgetter("nll"))


def white_fit(problem: LogProblem) -> Fit:
    """The fit with white force noise; if delay or lag is at a bound, another split is tried."""
    free = free_of(problem, False)
    fit = scored(problem, started(problem), free)
    late = [INDEX["delay"], INDEX["lag"]]
    delay, lag = fit.theta[late]
    if delay > 0 and lag > LAG_LEAST:
        return fit
    start = fit.theta.copy()
    share = SPLITS[-1] if delay <= 0 else SPLITS[0]
    start[late] = share * (delay + lag), (1 - share) * (delay + lag)
    other = scored(problem, start, free)
    return likeliest((fit, other))


def coloured_if_likelier(white: Fit) -> Fit:
    """The fit with a coloured push if twice its gain exceeds 4 ln n, else the white one."""
    tried = []
    for time, passes in ((0.4, 40), (3.0, 12)):
        start = white.theta.copy()
        for axis in ("1", "2"):
            start[INDEX[f"s{axis}"]] = white.theta[INDEX[f"q{axis}"]] - 1.0
        start[INDEX["time"]] = math.log(time)
        free = free_of(white.problem, True)
        tried.append(scored(white.problem, start, free, passes, ROUGH))
    best = likeliest(tried)
    if 2 * (white.nll - best.nll) > 4 * math.log(int(white.problem.counts.sum())):
        return scored(white.problem, best.theta, best.free)
    return white


def surest(fit: Fit) -> Fit:
    """The likeliest of several fits if ``fit`` hardly determines delay or mass, else ``fit``.

    Other maxima within the likelihood range of a 95 % profile interval widen the intervals.
    """
    half = half_widths(fit)
    m, inertia, delay, lag = (INDEX[name] for name in ("m", "I", "delay", "lag"))
    if half[delay] <= fit.problem.log.period and half[m] <= SHARES[0]:
        return fit
    fits = [fit]
    for late, (share, lighter) in product(LATENESS, ((SPLITS[0], 0.0), (SPLITS[-1], 0.7))):
        start = fit.theta.copy()
        start[[delay, lag]] = share * late, (1 - share) * late
        start[[m, inertia]] -= lighter
        fits.append(scored(fit.problem, start, fit.free, SURE_PASSES, ROUGH))
    best = likeliest(fits)
    near = [item.theta[fit.free] for item in fits if item.nll < best.nll + ACCEPTED]
    least = np.zeros(len(best.theta))
    least[fit.free] = np.abs(np.array(near) - best.theta[fit.free]).max(axis=0)
    return replace(best, least=least)


def bare_scenario(scenario: Scenario, log: Samples, remarks: list[str]) -> Scenario:
    """The known scenario on the log's clock, without the parts that the identified numbers replace.

    Other times that must be multiples of a clock's are rounded to the nearest multiple.
    """
    period = float(f"{log.period:.4g}")
    duration = max(1, round(scenario.clock.duration / period)) * period
    clocks = {"clock.control": period, "clock.plant": plant_step(period)}
    raw: dict[str, Any] = scenario_dict(scenario)
    for key in REPLACED:
        table, _, name = key.partition(".")
        (raw[table] if name else raw).pop(name or table, None)
    raw["clock"] |= {k.removeprefix("clock."): v for k, v in clocks.items()}
    raw["clock"]["duration"] = duration
    if raw["metrics"].get("split", 0.0) >= duration:
        del raw["metrics"]["split"]
    for key, clock, most in multiples():
        table, _, name = key.partition(".")
        value = raw.get(table, {}).get(name, 0.0)
        count = max(round(value / clocks[clock]), 1) if value else 0
        fitting = min(count, most or count) * clocks[clock]
        if abs(fitting - value) > 1e-9 * value:
            raw[table][name] = fitting
            remarks.append(
                f"{key} = {value:.4g} s becomes {fitting:.4g} s, a multiple of {clock} = "
                f"{clocks[clock]:.4g} s, which is the log's."
            )
    return from_dict(raw, scenario.name)


def cut_of(log: Samples) -> float:
    """Time at which the held-out last third of a log begins [s]."""
    return float(log.t[-1] - HELD_OUT * (log.t[-1] - log.t[0]))


def fitted_part(fit: Fit, end: float) -> Fit:
    """Refit, with the same model, the part of the log before ``end`` [s]."""
    part = replace(fit.problem, log=fit.problem.log.until(end))
    return replace(scored(part, fit.theta, fit.free, PART_PASSES), least=fit.least)


def score_of(curves: Traces) -> Score:
    """Score on the held-out last third, compared with speeds held constant for `FREE_RUN`."""
    held = curves.measured[seconds_begin(curves.t)]
    shares = np.full((2, 2), np.nan)
    for axis, foretold in enumerate(curves.foretold.T):
        rest = (curves.t >= curves.held_out_from) & np.isfinite(foretold)
        if rest.any():
            seen = curves.measured[rest, axis]
            total = max(float(np.sum((seen - seen.mean()) ** 2)), 1e-12)
            for k, told in enumerate((foretold, held[:, axis])):
                shares[k, axis] = 1 - np.sum((told[rest] - seen) ** 2) / total
    (v, omega), (held_v, held_omega) = shares.tolist()
    return Score((v, omega), (held_v, held_omega), curves.held_out_from)


def seconds_begin(t: Floats) -> NDArray[np.int64]:
    """Rows (N,) at which each row's stretch of `FREE_RUN` begins."""
    turn = np.floor((t - t[0]) / FREE_RUN)
    return np.searchsorted(turn, turn)
