"""From a log of commanded and measured velocities to a scenario with [base] and [filter]."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wmr_ctrl.control.filter.filter import check_filter
from wmr_ctrl.control.filter.peak_gain import PeakGain, peak_gains, pi_loop
from wmr_ctrl.core.fields.unstated import Unstated
from wmr_ctrl.world.encoder import Encoder
from wmr_ctrl.world.scenario import Scenario, override

from .bounds import (
    DETERMINED,
    ROUGHLY,
    UNDETERMINED,
    BaseIdentification,
    Estimate,
    Estimates,
    FilterBounds,
    Traces,
    informative_seconds,
    loop_remarks,
    verdict,
)
from .estimate import bare_scenario, cut_of, score_of
from .fit import WIDEST, plant_step
from .judgement import EXPLAINED, NOT_EXPLAINED, Judgement, Judgements, bent, judged
from .logs.lint import check_following
from .logs.log import COMMAND, Pair
from .logs.samples import AxisLog, Samples, axis_log
from .loop_search import axis_fit
from .speed_loop import LINEAR, LOOPS, RANGES, SMOOTHED, Fits, LoopFit, fitted
from .stated import MOST_FAR, beyond, refusal, too_far
from .written import four_digits, outward

LOOP, LEAST_DRIVEN = "first-order", 1e-3
TRAINED = 4
UNSURE = 0.1
"""Share by which numbers of a loop are widened that explains its log in part."""
LEAST_BACK = 2.0
"""Largest ratio of commands in both directions of a log that shows both."""
MOST_LATE = 0.3
"""Largest undetermined delay that a filter takes [s]."""
MOST_VAGUE = 4.0
"""Largest ratio of the ends of an undetermined interval that it takes."""
KEYS = {"tau": "tau", "wn": "frequency", "zeta": "damping", "gain": "gain"}
"""Keys of a loop's numbers in [base] and [filter]."""
UNFOUNDED = ("filter.gain", "filter.d", "filter.kp", "filter.push")
"""Keys that are assumed where a log does not show what they promise up to the limits."""


@dataclass(frozen=True)
class VelocityIdentification(BaseIdentification):
    """Results for a base that takes velocities."""

    bounds: FilterBounds


def of_velocities(
    name: str, log: Samples, scenario: Scenario, remarks: list[str]
) -> VelocityIdentification:
    """Identify the base of a log; raises LogError if units, signs or clocks are wrong."""
    axes = [axis_log(log, axis) for axis in (0, 1)]
    driven = [bool(np.std(axis.sent) > LEAST_DRIVEN) for axis in axes]
    for axis, drives, column in zip(axes, driven, COMMAND, strict=True):
        if drives:
            check_following(name, column, *axis.follows, log.period)
    fits = same_loop(axes, driven)
    pairs = zip(fits, fits[::-1], strict=True)
    judgements = [judged(fit, other, place) for place, (fit, other) in enumerate(pairs) if fit]
    estimates = loop_estimates(judgements, log.period)
    remarks += loop_remarks(judgements, estimates)
    bare = replace(bare_scenario(scenario, log, remarks), title=f"identified from {name}")
    bounds, identified = _scenario(bare, log, judgements, estimates, remarks)
    curves = _curves(axes, fits, cut_of(log))
    return VelocityIdentification(
        name, estimates, bounds, tuple(remarks), score_of(curves), identified, curves,
        judgements=tuple(judgements),
    )  # fmt: skip


def _curves(axes: list[AxisLog], fits: Fits, cut: float) -> Traces:
    """Measured speeds, predictions by fits before ``cut`` [s], and deviations as in filter.d."""
    seen = np.column_stack([axis.speed for axis in axes])
    foretold, left = np.full((2, *seen.shape), np.nan)
    for axis, fit in enumerate(fits):
        if fit is not None:
            inside = fit.log.in_fit
            part = replace(fit.log, in_fit=inside & (fit.log.t < cut))
            trained = fitted(part, fit.loop, fit.names, fit.theta, TRAINED, fixed=fit.fixed)
            left[:, axis] = fit.deviation()
            foretold[inside, axis] = trained.forecast[inside]
    return Traces(axes[0].t, seen, foretold, left, cut)


def same_loop(axes: list[AxisLog], driven: list[bool]) -> Fits:
    """Fits of both axes with one kind of loop: if their kinds differ, the likelier one for both.

    The axis whose kind was changed keeps its own fit among the `others`, so that its intervals
    cover both fits.
    """
    first, second = (
        axis_fit(axis) if moves else None for axis, moves in zip(axes, driven, strict=True)
    )
    if first is None or second is None or first.loop == second.loop:
        return first, second
    pairs = (first, _forced(second, first.loop)), (_forced(first, second.loop), second)
    return min(pairs, key=lambda pair: pair[0].bic + pair[1].bic)


def _forced(own: LoopFit, loop: str) -> LoopFit:
    """Fit of a given kind of loop to an axis; ``own``, its fit of another kind, is among the
    `others`.
    """
    fit = axis_fit(own.log, (loop,))
    return replace(fit, others=(*fit.others, own))


def loop_estimates(judgements: Judgements, period: float) -> dict[str, Estimate]:
    """Value, interval and verdict of each parameter, for the axes that were driven."""
    if not judgements:
        keys = [f"{name}{axis}" for axis in (1, 2) for name in LOOPS["first-order"]]
        return dict.fromkeys(keys, Estimate(math.nan, 0.0, math.inf, UNDETERMINED, share=9.0))
    estimates = {}
    sure = all(item.explained == EXPLAINED for item in judgements)
    for item in judgements:
        fit, axis = item.fit, item.place + 1
        for name in fit.values:
            if name != "when":
                estimates[f"{name}{axis}"] = _estimate(item, name, period, sure)
        if "accel" not in fit.names:
            # A command that is ramped drives no speed faster than its ramp, times the gain.
            least = fit.steepest / fit.gain if item.explained == EXPLAINED else 0.0
            estimates[f"accel{axis}"] = Estimate(math.inf, least, math.inf, UNDETERMINED, share=9.0)
    return estimates


def _estimate(judgement: Judgement, name: str, period: float, sure: bool) -> Estimate:
    """A parameter's estimate; its interval is widened if the fit explains the log only in part.

    ``sure``: the other axis is explained, too, so it cannot have caused the misfit.
    """
    fit = judgement.fit
    value, in_part = fit.values[name], judgement.explained != EXPLAINED
    alike = [item for item in (fit, *fit.others) if name in item.values]
    low, high = _hull([_interval(item, name, period) for item in alike])
    more = min(judgement.share, 1.0) * (1 + in_part) + UNSURE * (
        in_part and name in ("tau", "wn", "zeta")
    )
    if name == "delay":
        low, high = low - period * in_part, high + period * in_part
    elif name not in LINEAR:
        low, high = low / (1 + more), high * (1 + more)
    least, most = judgement.reached(name, value)
    size, own = max(abs(value), period if name == "delay" else 1e-12), (high - low) / 2
    # What is hardly determined reaches little beyond what is searched.
    lowest, highest = RANGES.get(name, (0.0, math.inf))
    low, high = max(min(low, least), lowest / 2), min(max(high, most), 2 * highest)
    # A structure that is known makes a number another, not unknown.
    share = ((high - low) / 2 if in_part else own) / size
    word, seconds, several = verdict(share), (0.0, 0.0), least < most
    if name in fit.names:
        place = fit.names.index(name)
        seconds = informative_seconds(fit.log.t, fit.fisher[:, place, place])
        several |= bool(fit.alone[place]) or (name in fit.members and not sure)
        several |= "lag" in fit.names and name != "gain"
        several |= len(alike) <= len(fit.others)
    if judgement.explained == NOT_EXPLAINED:
        word = NOT_EXPLAINED
    elif fit.at_end(name):
        word = UNDETERMINED
    elif word == DETERMINED and (in_part or several):
        word = ROUGHLY
    return Estimate(value, low, high, word, seconds, share)


def _interval(fit: LoopFit, name: str, period: float) -> Pair:
    """95 % interval from the fit alone; that of a dead band is between two commands of the log."""
    value = fit.values[name]
    if name not in fit.names:
        sizes = np.unique(np.abs(fit.log.sent))
        place = int(np.clip(np.searchsorted(sizes, value), 1, len(sizes) - 1))
        return float(sizes[place - 1]), float(sizes[place])
    half = fit.half_widths(plant_step(period) / 2)[name]
    if name in LINEAR:
        low, high = RANGES[name]
        return max(value - half, low), min(value + half, high)
    wide = math.exp(min(half, WIDEST / 3))
    return value / wide, value * wide


def _scenario(
    base: Scenario,
    log: Samples,
    judgements: Judgements,
    estimates: Estimates,
    remarks: list[str],
) -> tuple[FilterBounds, Scenario]:
    """The base's scenario; its filter is on if its numbers can be met."""
    own = ["robot.mu", "disturbance.std"]
    numbers: dict[str, object] = {
        "robot.mu": 0.0, "base.kind": "velocity", "base.loop": LOOP, "guard.enabled": False,
        "filter.kind": "none", "disturbance.std": 0.0, "disturbance.push": [0.0, 0.0],
    }  # fmt: skip
    if not judgements:
        remarks.append("the filter is off. Change both commands by steps, at different times.")
        none = math.inf, math.inf
        bounds = FilterBounds(LOOP, none, none, (0.0, math.inf), "the log shows none")
        return bounds, replace(override(base, numbers), assumed=(*base.assumed, *own))
    fits = {item.place: item.fit for item in judgements}
    far = beyond(base, log)
    d = [0.0, 0.0]
    for place, fit in fits.items():
        seen = float(np.abs(fit.deviation()).max()) + abs(fit.values.get("bias", 0.0))
        d[place] = outward(0.0, seen * far[place])[1]
    both = [fits.get(place, judgements[0].fit) for place in (0, 1)]
    values = [{name: four_digits(x) for name, x in fit.values.items()} for fit in both]
    loop, late, ends = both[0].loop, *_ends(base, both, estimates, far)
    accel = [item.get("accel", math.inf) for item in values]
    numbers |= {
        "base.loop": loop, "filter.loop": loop, "base.delay": late, "base.accel": accel,
        "base.decel": [v.get("decel", most) for v, most in zip(values, accel, strict=True)],
        "base.deadband": [item.get("dead", 0.0) for item in values],
        "filter.delay": _stated(ends["delay"]),
    }  # fmt: skip
    rests = loop != LOOP or base.section(Encoder).counts
    if rests and isinstance(base.initial.velocity, Unstated):
        # A filter for loops that overshoot counts on a base at rest, as encoders do.
        numbers["initial.velocity"] = [0.0, 0.0]
    if loop == "pi":
        own += ["robot.I"] if {"robot.m", "robot.l"} & {*base.assumed} else []
        result = _of_pi(base, numbers, values, ends, d, remarks)
    else:
        for name, key in KEYS.items():
            if name in LOOPS[loop]:
                numbers[f"base.{key}"] = [item[name] for item in values]
                numbers[f"filter.{key}"] = _stated(ends[name])
        result = override(base, numbers | {"filter.d": d})
    result = replace(result, assumed=(*result.assumed, *own))
    sentence = (
        f"largest deviation, averaged over {SMOOTHED:g} s, that was seen in "
        f"{log.t[-1] - log.t[0]:.3g} s, on this floor, with this load: no bound that is proved"
    )
    first, second = (
        k.gain if place in fits else math.inf for place, k in enumerate(peak_gains(result))
    )
    bounds = FilterBounds(loop, (first, second), (d[0], d[1]), _hull(ends["delay"]), sentence)
    return bounds, _filtered(result, judgements, estimates, far, remarks)


def _filtered(
    result: Scenario,
    judgements: Judgements,
    estimates: Estimates,
    far: Sequence[float],
    remarks: list[str],
) -> Scenario:
    """The scenario, with its filter on if the log allows it; numbers beyond the log are marked as
    assumed.
    """
    unfounded = replace(result, assumed=(*result.assumed, *UNFOUNDED))
    stated = override(result, {"filter.kind": "clip"})
    if reason := _against(stated, judgements, estimates, far):
        remarks.append(f"the filter is off: {reason}")
        return unfounded
    if max(far) > 1:
        remarks.append(
            f"limits.v_u1 is up to {100 * max(far) - 100:.0f} % beyond the fastest motion of the "
            "log: filter.gain and filter.d are wider by what grows with speed. Drive up to the "
            "limits."
        )
    lacking = _never_sent(stated, judgements, peak_gains(result))
    remarks += lacking
    founded = not lacking and max(far) == 1
    return stated if founded else replace(stated, assumed=unfounded.assumed)


def _against(
    stated: Scenario,
    judgements: Judgements,
    estimates: Estimates,
    far: Sequence[float],
) -> str:
    """Reason why a filter cannot be based on the log; "" if there is none."""
    if len(judgements) < 2:
        return f"{COMMAND[1 - judgements[0].place]} never changed. Drive both axes."
    for item in judgements:
        if item.explained == NOT_EXPLAINED:
            return f"no loop that is known explains {item.axis}. Check the log's columns."
        least, largest = float(item.fit.log.sent.min()), float(item.fit.log.sent.max())
        if min(-least, largest) < max(-least, largest) / LEAST_BACK:
            return (
                f"{COMMAND[item.place]} was from {least:.3g} to {largest:.3g} {item.unit}, which "
                "does not show what the base does in the other direction. Drive both ways."
            )
    vague = [
        key
        for key, item in estimates.items()
        if item.verdict == UNDETERMINED
        and (item.high > MOST_LATE if key[:-1] == "delay" else
             key[:-1] in ("gain", "tau", "wn") and item.high > MOST_VAGUE * item.low)
    ]  # fmt: skip
    if vague:
        return f"{', '.join(vague)} undetermined. Steps of the command show them."
    return too_far(stated, far) or refusal(stated, check_filter)


def _never_sent(stated: Scenario, judgements: Judgements, peaks: Sequence[PeakGain]) -> list[str]:
    """Remarks on axes and directions whose commands stayed far below a clip's largest command."""
    remarks = []
    for item, limit, peak in zip(judgements, stated.limits.v_u1, peaks, strict=True):
        most = (limit - peak.push) / peak.gain
        for ahead in (1, -1):
            sent = ahead * item.fit.log.sent
            if not ((sent >= most / MOST_FAR) & (sent <= most)).any():
                remarks.append(
                    f"{COMMAND[item.place]} was never from {ahead * most / MOST_FAR:.3g} to "
                    f"{ahead * most:.3g} {item.unit}: that the base follows in proportion there "
                    "is assumed. Drive there."
                )
    return remarks


def _ends(
    base: Scenario, both: Sequence[LoopFit], estimates: Estimates, far: Sequence[float]
) -> tuple[float, dict[str, list[Pair]]]:
    """Delay [s], a multiple of the plant step, and intervals of v and omega per kind of number.

    A lone axis gives its interval to both; where the filter takes only one interval, it is the
    hull.
    """
    ends: dict[str, list[Pair]] = {}
    for key, item in estimates.items():
        ends.setdefault(key[:-1], []).append((item.low, item.high))
    ends = {name: (pairs * 2)[:2] for name, pairs in ends.items()}
    delays = [item.value for name, item in estimates.items() if name.startswith("delay")]
    late = max(round(float(np.mean(delays)) / base.clock.plant), 0) * base.clock.plant
    ends["delay"] = [(min(late, low), max(late, high)) for low, high in ends["delay"]]
    for axis, (fit, share) in enumerate(zip(both, far, strict=True)):
        if "gain" in ends:
            # A gain that grows with the command grows on beyond those of the log.
            low, high = ends["gain"][axis]
            more = (share - 1) * (bent(fit) + ("curve" in fit.values) * (high / low - 1))
            ends["gain"][axis] = low, high * (1 + more)
    wheels = base.filter.channels == "wheels" or base.filter.wheel_speed is not None
    if both[0].loop == "pi" or wheels:
        ends = {name: 2 * [_hull(pairs)] for name, pairs in ends.items()}
    return late, {name: [outward(*pair) for pair in pairs] for name, pairs in ends.items()}


def _hull(pairs: Sequence[Pair]) -> Pair:
    """Smallest interval that contains both axes' intervals."""
    lows, highs = zip(*pairs, strict=True)
    return min(lows), max(highs)


def _stated(pairs: Sequence[Pair]) -> object:
    """Bounds as a filter states them: one interval if both axes have the same, or two."""
    return pairs[0] if pairs[0] == pairs[1] else pairs


def _of_pi(
    base: Scenario,
    numbers: Mapping[str, object],
    values: list[dict[str, float]],
    ends: Mapping[str, Sequence[Pair]],
    d: Sequence[float],
    remarks: list[str],
) -> Scenario:
    """A PI loop of both wheels: kp and ki that act on robot.m, and the measured inertia."""
    m, l = base.robot.m, base.robot.l
    remarks.append(
        f"kp and ki are for robot.m = {m:g} kg as it was given: a log of velocities "
        "determines only kp/M and ki/M. Coulomb friction is left to the loop (robot.mu = 0), and "
        "filter.push is the least push that makes the largest deviation seen."
    )
    pulls = [(2 * v["zeta"] * v["wn"], v["wn"] ** 2) for v in values]
    # Both ratios of v over omega are I/(m l^2) in a loop that both wheels share.
    heavier = math.sqrt(pulls[0][0] / pulls[1][0] * (pulls[0][1] / pulls[1][1]))
    inertia = m * l**2 * heavier
    (wn, wn_most), (zeta, zeta_most) = ends["wn"][0], ends["zeta"][0]
    own = min(1.0, heavier), max(1.0, heavier)
    result = override(base, {
        **numbers, "robot.I": inertia,
        "base.kp": m * pulls[0][0], "base.ki": m * pulls[0][1],
        "filter.mass": [m, m], "filter.inertia": [inertia, inertia],
        "filter.kp": [2 * m * zeta * wn * own[0], 2 * m * zeta_most * wn_most * own[1]],
        "filter.ki": [m * wn**2 * own[0], m * wn_most**2 * own[1]],
    })  # fmt: skip
    pushes = [d[axis] / pi_loop(result, axis).peak(1.0).push * (1.0, l**2)[axis] for axis in (0, 1)]
    return override(result, {"filter.push": pushes})
