"""From a log of commanded and measured velocities to a scenario with [base] and [filter]."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from wmr_ctrl.control.filter.filter import check_filter
from wmr_ctrl.control.filter.peak_gain import PeakGain, peak_gains, pi_loop
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.scenario import Scenario, override

from .bounds import (
    UNDETERMINED,
    BaseIdentification,
    Estimate,
    FilterBounds,
    Surface,
    Traces,
    grid_about,
    loop_remarks,
)
from .estimate import bare_scenario, cut_of, loop_estimates, loop_score
from .logs.lint import check_following
from .logs.log import COMMAND, Floats, LogError
from .logs.samples import AxisLog, Samples, axis_log, shifted_gain
from .speed_loop import (
    AXES,
    LOOPS,
    RANGES,
    SMOOTHED,
    Fits,
    LoopFit,
    fitted,
    forecast,
    foretold,
    likelihoods,
    set_of,
)
from .stated import MOST_FAR, rounded_down

LEAST_DRIVEN = 1e-3
TRAINED = 4
SPEEDS = (0.03, 0.1, 0.3)
"""Time constants that fits are started from [s]."""
DAMPINGS = (0.35, 1.0)
GAIN_OF_BIC = 4.0
SCREENED = 12
SCREEN_SECONDS = 30.0
PASSES = 30
PLACES = {
    "base.tau": ("tau1", "tau2"), "base.gain": ("gain1", "gain2"),
    "base.kp": ("wn1", "zeta1", "wn2", "zeta2"), "base.delay": ("delay1", "delay2"),
    "base.accel": ("accel1", "accel2"), "filter.gain": ("gain1", "gain2"),
}  # fmt: skip
"""Keys of the scenario, and the parameters whose intervals stand beside them."""
UNFOUNDED = ("filter.gain", "filter.d", "filter.kp", "filter.push")
"""Keys that are assumed where a log does not show what they promise up to the limits."""


@dataclass(frozen=True)
class VelocityIdentification(BaseIdentification):
    """Results for a base that takes velocities.

    ``fits``: of v and omega, if driven; ``trained``: those to the first two thirds only.
    """

    bounds: FilterBounds
    fits: Fits
    trained: Fits
    places = PLACES

    def traces(self) -> Traces:
        """Measured and predicted speeds, and their deviations as in filter.d."""
        log = next(fit.log for fit in self.fits if fit is not None)
        seen, foretold, left = (np.full((len(log.t), 2), np.nan) for _ in range(3))
        for axis, (fit, trained) in enumerate(zip(self.fits, self.trained, strict=True)):
            if fit is not None and trained is not None:
                seen[:, axis], left[:, axis] = fit.log.speed, fit.deviation()
                foretold[:, axis] = np.where(log.in_fit, forecast(trained, fit.log), np.nan)
        return Traces(log.t, seen, foretold, left, self.score.held_out_from)

    def surfaces(self) -> tuple[Surface, ...]:
        """Likelihood over each axis' delay and time constant, or frequency."""
        surfaces = []
        for axis, fit in zip(AXES, self.fits, strict=True):
            if fit is not None:
                pair = "delay", "tau" if "tau" in fit.names else "wn"
                errors = dict(zip(fit.names, fit.standard_errors().tolist(), strict=True))
                value = fit.values[pair[1]]
                x = grid_about(fit.values["delay"], errors["delay"], 0.0)
                y = grid_about(value, value * errors[pair[1]], value / 9)
                places = np.stack(np.meshgrid(x, y, indexing="ij")).reshape(2, -1)
                fall = likelihoods(fit, dict(zip(pair, places, strict=True)))
                names = f"{pair[0]}{axis}", f"{pair[1]}{axis}"
                surfaces.append(Surface(names, x, y, fall.reshape(len(x), len(y))))
        return tuple(surfaces)


def of_velocities(
    name: str,
    log: Samples,
    scenario: Scenario,
    remarks: list[str],
    tell: Callable[[], None],
) -> VelocityIdentification:
    """The base of a log; raises LogError where it determines nothing."""
    axes = [axis_log(log, axis) for axis in (0, 1)]
    driven = [bool(np.std(axis.sent) > LEAST_DRIVEN) for axis in axes]
    if not any(driven):
        raise LogError(
            f"{name}: both commands are constant, so the log says nothing about the base. Change "
            "both by steps, at different times."
        )
    for axis, drives, column in zip(axes, driven, COMMAND, strict=True):
        if drives:
            check_following(name, column, *shifted_gain(axis), log.period)
    fits = same_loop(axes, driven, tell)
    estimates = loop_estimates(fits, log.period)
    if all(item.verdict == UNDETERMINED for item in estimates.values()):
        raise LogError(
            f"{name}: the log says nothing about the base. Change both commands by steps, at "
            "different times."
        )
    remarks += loop_remarks(fits, estimates)
    bounds, identified = _scenario(name, scenario, log, fits, estimates, remarks)
    cut = cut_of(log)
    first, second = (
        fit and fitted(fit.log.until(cut), fit.loop, fit.names, fit.theta, TRAINED) for fit in fits
    )
    trained, said = (first, second), tuple(remarks)
    score = loop_score(axes, cut, trained)
    return VelocityIdentification(name, estimates, bounds, said, score, identified, fits, trained)


def _scenario(
    name: str,
    scenario: Scenario,
    log: Samples,
    fits: Fits,
    estimates: Mapping[str, Estimate],
    remarks: list[str],
) -> tuple[FilterBounds, Scenario]:
    """The scenario of the base, whose filter is on where its numbers can be met."""
    base = bare_scenario(scenario, log, remarks)
    step = base.clock.plant
    seen = [fit for fit in fits if fit is not None]
    d1, d2 = (0.0 if fit is None else float(np.abs(fit.deviation()).max()) for fit in fits)
    both = [fit or seen[0] for fit in fits]
    values = [fit.values for fit in both]
    delays = [estimates[key] for key in ("delay1", "delay2") if key in estimates]
    late = max(round(float(np.mean([item.value for item in delays])) / step), 0) * step
    accel = [item.get("accel", math.inf) for item in values]
    ends = min([late, *(item.low for item in delays)]), max([late, *(i.high for i in delays)])
    result = override(base, {
        "title": f"identified from {name}", "robot.mu": 0.0, "base.kind": "velocity",
        "base.delay": late, "base.accel": accel, "base.decel": accel, "guard.enabled": False,
        "filter.kind": "none", "filter.delay": list(ends),
        "disturbance.std": 0.0, "disturbance.push": [0.0, 0.0],
    })  # fmt: skip
    own = ["robot.mu", "disturbance.std"]
    loop = both[0].loop
    hull = _hulls(estimates)
    if loop == "pi":
        own += ["robot.I"] if {"robot.m", "robot.l"} & {*base.assumed} else []
        result = _of_pi(result, values, hull, (d1, d2))
    else:
        result = _of_relaxing(result, loop, values, hull, (d1, d2))
    result = replace(result, assumed=(*result.assumed, *own))
    remarks += _said_of(loop, base.robot.m)
    if loop == "first-order":
        peaks = [PeakGain(hull["gain"][1], d) for d in (d1, d2)]
    else:
        peaks = list(peak_gains(override(result, {"filter.kind": "clip"})))
    peak = [k.gain if fit is not None else math.inf for k, fit in zip(peaks, fits, strict=True)]
    sentence = (
        f"largest deviation, averaged over {SMOOTHED:g} s, that was seen in "
        f"{log.t[-1] - log.t[0]:.3g} s, on this floor, with this load: no bound that is proved"
    )
    bounds = FilterBounds(loop, (peak[0], peak[1]), (d1, d2), ends, sentence)
    quickest = None if loop != "first-order" or any(map(math.isfinite, accel)) else hull["tau"][0]
    return bounds, _filtered(result, fits, peaks, quickest, remarks)


def _filtered(
    result: Scenario,
    fits: Fits,
    peaks: list[PeakGain],
    quickest: float | None,
    remarks: list[str],
) -> Scenario:
    """The scenario with the filter that its log supports; without one, bounds are assumed.

    ``quickest`` as in `_filter_kind`.
    """
    off = replace(result, assumed=(*result.assumed, *UNFOUNDED))
    missing = [column for fit, column in zip(fits, COMMAND, strict=True) if fit is None]
    if missing:
        remarks.append(f"the filter is off: {missing[0]} never changed. Drive both axes.")
        return off
    seen = [fit for fit in fits if fit is not None]
    kind = _filter_kind(result, seen, peaks, quickest, remarks)
    if kind == "none":
        return off
    stated = override(result, {"filter.kind": kind})
    try:
        settle(stated, None)
        check_filter(stated)
    except ScenarioError as error:
        remarks.append(f"the filter is off: with these numbers it is refused. {error}")
        return off
    if _never_sent(stated, seen, peaks, remarks):
        return replace(stated, assumed=off.assumed)
    return stated


def _filter_kind(
    stated: Scenario,
    fits: list[LoopFit],
    peaks: list[PeakGain],
    quickest: float | None,
    remarks: list[str],
) -> str:
    """The filter that sends no command beyond those whose effect the log shows, and a remark.

    ``quickest``: least time constant [s] of a base that a governor can be used for.
    """
    limits, units = stated.limits.v_u1, ("m/s", "rad/s")
    known = [_largest_command(fit) for fit in fits]
    sent = _largest_sent(stated, peaks)
    for V, u, item, most, unit in zip(limits, sent, peaks, known, units, strict=True):
        if most * (1 + 1e-9) < u:
            remarks.append(
                f"the filter is off: for the limit of {V:.3g} {unit} it would send commands up to "
                f"{u:.3g} {unit}, and the log shows what the base does with commands up to "
                f"{most:.3g} {unit}. Drive faster, or state a limit of at most "
                f"{rounded_down(item.gain * most + item.push):g} {unit}."
            )
            return "none"
    for fit, u, column, unit in zip(fits, sent, COMMAND, units, strict=True):
        least, largest = float(fit.log.sent.min()), float(fit.log.sent.max())
        if min(-least, largest) < u / MOST_FAR:
            remarks.append(
                f"the filter is off: {column} was from {least:.3g} to {largest:.3g} {unit}, which "
                "does not show what the base does in the other direction. Drive both ways."
            )
            return "none"
    if quickest is None:
        return "clip"
    # A governor sends most where it takes over at full speed backwards.
    rise = 2 / math.expm1(min(stated.clock.control / quickest, 700.0))
    sent = [u + rise * V / item.gain for u, V, item in zip(sent, limits, peaks, strict=True)]
    if all(u <= most for u, most in zip(sent, known, strict=True)):
        return "governor"
    remarks.append(
        f"the filter is a clip: a governor would send up to {sent[0]:.3g} m/s and {sent[1]:.3g} "
        "rad/s for moments, and the log shows what the base does with commands up to "
        f"{known[0]:.3g} m/s and {known[1]:.3g} rad/s."
    )
    return "clip"


def _never_sent(
    stated: Scenario, fits: list[LoopFit], peaks: list[PeakGain], remarks: list[str]
) -> bool:
    """Whether the log has no command near the largest that is sent, in a direction, and remarks."""
    before = len(remarks)
    rows = zip(_largest_sent(stated, peaks), fits, COMMAND, ("m/s", "rad/s"), strict=True)
    for most, fit, column, unit in rows:
        for ahead in (1, -1):
            sent = ahead * fit.log.sent
            if not ((sent >= most / MOST_FAR) & (sent <= most)).any():
                remarks.append(
                    f"{column} was never from {ahead * most / MOST_FAR:.3g} to {ahead * most:.3g} "
                    f"{unit}: that the base follows in proportion there is assumed. Drive there."
                )
    return len(remarks) > before


def _largest_sent(stated: Scenario, peaks: list[PeakGain]) -> list[float]:
    """Largest command of each axis that a clip sends [m/s, rad/s]."""
    return [(V - item.push) / item.gain for V, item in zip(stated.limits.v_u1, peaks, strict=True)]


def _largest_command(fit: LoopFit) -> float:
    """Largest command whose effect the log shows: one that ended too soon counts in part."""
    followed = float(np.abs(fit.log.speed - fit.left)[fit.log.in_fit].max())
    return min(float(np.abs(fit.log.sent).max()), followed / fit.values.get("gain", 1.0))


def _said_of(loop: str, m: float) -> list[str]:
    """Remarks on the properties of a kind of loop that no scenario can hold."""
    said = {
        "second-order": (
            "the loop is second-order without a zero, which runs cannot simulate: they take the "
            "first-order loop of the same gain and mean lag. filter.trust makes them accept the "
            "filter, which is for the identified loop."
        ),
        "pi": (
            f"kp and ki go with robot.m = {m:g} kg as it was given: a log of velocities tells kp/M "
            "and ki/M alone. Coulomb friction is left to the loop (robot.mu = 0), and filter.push "
            "is the least push that makes the largest deviation seen."
        ),
    }
    return [said[loop]] if loop in said else []


def _hulls(estimates: Mapping[str, Estimate]) -> dict[str, tuple[float, float]]:
    """Intervals of each kind of parameter that hold those of both axes."""
    names = {name[:-1] for name in estimates}
    pairs = {name: [estimates[k] for k in estimates if k[:-1] == name] for name in names}
    return {k: (min(i.low for i in v), max(i.high for i in v)) for k, v in pairs.items()}


def _of_relaxing(
    scenario: Scenario,
    loop: str,
    values: list[dict[str, float]],
    hull: Mapping[str, tuple[float, float]],
    d: tuple[float, float],
) -> Scenario:
    """A first-order loop for runs, of the same mean lag where the identified one is of second."""
    if loop == "first-order":
        tau = [item["tau"] for item in values]
        counted: dict[str, object] = {"filter.tau": list(hull["tau"])}
    else:
        tau = [2 * item["zeta"] / item["wn"] for item in values]
        counted = {
            "filter.damping": list(hull["zeta"]), "filter.frequency": list(hull["wn"]),
            "filter.trust": True,
        }  # fmt: skip
    return override(scenario, {
        "base.loop": "first-order", "base.tau": tau, "base.gain": [v["gain"] for v in values],
        "filter.loop": loop, "filter.gain": list(hull["gain"]), "filter.d": list(d), **counted,
    })  # fmt: skip


def _of_pi(
    scenario: Scenario,
    values: list[dict[str, float]],
    hull: Mapping[str, tuple[float, float]],
    d: tuple[float, float],
) -> Scenario:
    """A PI loop of both wheels: kp and ki on robot.m, and the inertia that turns as was seen."""
    m, l = scenario.robot.m, scenario.robot.l
    pulls = [(2 * v["zeta"] * v["wn"], v["wn"] ** 2) for v in values]
    # Both ratios of v over omega are I/(m l^2) in a loop that both wheels share.
    heavier = math.sqrt(pulls[0][0] / pulls[1][0] * (pulls[0][1] / pulls[1][1]))
    inertia = m * l**2 * heavier
    (wn, wn_most), (zeta, zeta_most) = hull["wn"], hull["zeta"]
    own = min(1.0, heavier), max(1.0, heavier)
    result = override(scenario, {
        "base.loop": "pi", "robot.I": inertia,
        "base.kp": m * pulls[0][0], "base.ki": m * pulls[0][1], "filter.loop": "pi",
        "filter.mass": [m, m], "filter.inertia": [inertia, inertia],
        "filter.kp": [2 * m * zeta * wn * own[0], 2 * m * zeta_most * wn_most * own[1]],
        "filter.ki": [m * wn**2 * own[0], m * wn_most**2 * own[1]],
    })  # fmt: skip
    pushes = [d[axis] / pi_loop(result, axis).peak(1.0).push * (1.0, l**2)[axis] for axis in (0, 1)]
    return override(result, {"filter.push": pushes})


def best_loop(
    log: AxisLog, tell: Callable[[], None], loops: tuple[str, ...] = tuple(LOOPS)
) -> LoopFit:
    """The likeliest loop by the criterion of Schwarz, with a ramp where it earns one.

    All are tried on the first part of the log, the best three on all of it; a simpler one stays
    unless a richer one gains by more than chance and its numbers are determined.
    """
    part, tried = log.until(log.t[0] + SCREEN_SECONDS), []
    wide = max(round(0.1 / log.period), 1)
    slopes = np.abs(log.speed[wide:] - log.speed[:-wide])[log.in_fit[wide:]] / (wide * log.period)
    steepest = max(float(np.quantile(slopes, 0.98)), 0.02)
    for ramp, loop in product((False, True), loops):
        names = LOOPS[loop] + (("accel",) if ramp else ())
        starts = _starts(log, names, steepest)
        speeds = foretold(part, loop, np.array([set_of(names, x) for x in starts]))
        squares = np.sum((speeds - part.speed[:, None])[part.in_fit] ** 2, axis=0)
        near = [starts[k] for k in np.argsort(squares)[:2]]
        fits = [fitted(part, loop, names, x, SCREENED, SCREENED - 4) for x in near]
        tried.append(min(fits, key=lambda item: item.nll))
        tell()
    best: LoopFit | None = None
    few = sorted(tried, key=lambda item: (item.vague, item.bic))[:3]
    for item in sorted(few, key=lambda item: len(item.theta)):
        fit = fitted(log, item.loop, item.names, item.theta, PASSES)
        tell()
        if best is not None and fit.vague:
            continue
        if best is None or fit.bic < best.bic - GAIN_OF_BIC:
            best = fit
    assert best is not None
    return best


def same_loop(
    axes: list[AxisLog], driven: list[bool], tell: Callable[[], None]
) -> tuple[LoopFit | None, LoopFit | None]:
    """Fits of both axes by one kind of loop: where they differ the one likelier for both."""
    first, second = (
        best_loop(axis, tell) if moves else None for axis, moves in zip(axes, driven, strict=True)
    )
    if first is None or second is None or first.loop == second.loop:
        return first, second
    others = (
        (first, best_loop(axes[1], tell, (first.loop,))),
        (best_loop(axes[0], tell, (second.loop,)), second),
    )
    return min(others, key=lambda pair: pair[0].bic + pair[1].bic)


def _starts(log: AxisLog, names: tuple[str, ...], steepest: float) -> list[Floats]:
    gain = max(shifted_gain(log)[0], RANGES["gain"][0])
    grid = {
        "gain": (gain, 1.25 * gain) if "accel" in names else (gain,),
        "tau": SPEEDS, "wn": tuple(1 / x for x in SPEEDS), "zeta": DAMPINGS,
        "delay": (0.01, 0.06, 0.15), "accel": (0.7 * steepest, 1.1 * steepest, 2 * steepest),
    }  # fmt: skip
    return [
        np.array([x if n == "delay" else math.log(x) for n, x in zip(names, values, strict=True)])
        for values in product(*(grid[name] for name in names))
    ]
