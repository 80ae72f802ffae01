"""The scenario of a base whose speed loops were fitted to a log, with its filter."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wmr_ctrl.control.filter.filter import check_filter
from wmr_ctrl.control.filter.peak_gain import PeakGain, peak_gains, pi_loop
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.unstated import Unstated
from wmr_ctrl.world.scenario import Scenario, override

from .bounds import UNDETERMINED, Estimate, FilterBounds
from .estimate import bare_scenario
from .judgement import NOT_EXPLAINED, Judgement, bent
from .logs.log import COMMAND, UNITS, Pair
from .logs.samples import Samples, held_speeds
from .speed_loop import SMOOTHED, Fits, LoopFit
from .stated import LEAST_SEEN, MOST_FAR, rounded_down
from .written import four_digits, outward

LEAST_BACK = 2.0
"""Largest ratio of commands in both directions of a log that shows both."""
MOST_LATE, MOST_VAGUE = 0.3, 4.0
"""Latest delay [s], and ratio of the ends of an interval, of undetermined numbers for a filter."""
UNFOUNDED = ("filter.gain", "filter.d", "filter.kp", "filter.push")
"""Keys that are assumed where a log does not show what they promise up to the limits."""


@dataclass(frozen=True)
class Base:
    """A log, the loops that were fitted to it, what is thought of them, and their numbers."""

    log: Samples
    fits: Fits
    judgements: Sequence[Judgement | None]
    estimates: Mapping[str, Estimate]

    @property
    def seen(self) -> list[LoopFit]:
        """Fits of the axes that were driven."""
        return [fit for fit in self.fits if fit is not None]

    def far(self, limits: Sequence[float]) -> list[float]:
        """By how much limits are beyond the fastest motion of the log, as shares of it."""
        held = held_speeds(self.log)
        return [max(limit / max(v, LEAST_SEEN) - 1, 0.0) if fit else 0.0
                for fit, limit, v in zip(self.fits, limits, held, strict=True)]  # fmt: skip


def scenario_of_base(
    name: str, scenario: Scenario, found: Base, remarks: list[str]
) -> tuple[FilterBounds, Scenario]:
    """The scenario of the base, whose filter is on where its numbers can be met."""
    log, estimates = found.log, found.estimates
    base = replace(bare_scenario(scenario, log, remarks), title=f"identified from {name}")
    step, far = base.clock.plant, found.far(base.limits.v_u1)
    d1, d2 = (0.0 if fit is None else outward(0.0, _deviation(fit) * (1 + share))[1]
              for fit, share in zip(found.fits, far, strict=True))  # fmt: skip
    both = [fit or found.seen[0] for fit in found.fits]
    values = [{name: four_digits(x) for name, x in fit.values.items()} for fit in both]
    delays = [estimates[key] for key in ("delay1", "delay2") if key in estimates]
    late = max(round(float(np.mean([item.value for item in delays])) / step), 0) * step
    accel = [item.get("accel", math.inf) for item in values]
    decel = [item.get("decel", most) for item, most in zip(values, accel, strict=True)]
    lows, highs = [item.low for item in delays], [item.high for item in delays]
    ends = outward(min(late, *lows), max(late, *highs))
    result = override(base, {
        "robot.mu": 0.0, "base.kind": "velocity",
        "base.delay": late, "base.accel": accel, "base.decel": decel,
        "base.deadband": [item.get("dead", 0.0) for item in values], "guard.enabled": False,
        "filter.kind": "none", "filter.delay": list(ends),
        "disturbance.std": 0.0, "disturbance.push": [0.0, 0.0],
    })  # fmt: skip
    own = ["robot.mu", "disturbance.std"]
    loop = both[0].loop
    if loop != "first-order" and isinstance(base.initial.velocity, Unstated):
        # A filter for loops that overshoot counts on a base at rest.
        result = override(result, {"initial.velocity": [0.0, 0.0]})
    hull = _hulls(estimates)
    if "gain" in hull:
        # A gain that grows with the command grows on beyond those of the log.
        grows = [hull["gain"][1] / hull["gain"][0] - 1 if "curve" in item else 0.0
                 for item in values]  # fmt: skip
        more = max(x * (bent(fit) + y) for fit, x, y in zip(both, far, grows, strict=True))
        hull["gain"] = hull["gain"][0], hull["gain"][1] * (1 + more)
    hull = {name: outward(*pair) for name, pair in hull.items()}
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
    peak = [k.gain if fit is not None else math.inf
            for k, fit in zip(peaks, found.fits, strict=True)]  # fmt: skip
    sentence = (
        f"largest deviation, averaged over {SMOOTHED:g} s, that was seen in "
        f"{log.t[-1] - log.t[0]:.3g} s, on this floor, with this load: no bound that is proved"
    )
    bounds = FilterBounds(loop, (peak[0], peak[1]), (d1, d2), ends, sentence)
    return bounds, _filtered(result, found, peaks, remarks)


def _deviation(fit: LoopFit) -> float:
    """Largest deviation of the speed from what its command explains [m/s, rad/s]."""
    return float(np.abs(fit.deviation()).max()) + abs(fit.values.get("bias", 0.0))


def _filtered(
    result: Scenario,
    found: Base,
    peaks: list[PeakGain],
    remarks: list[str],
) -> Scenario:
    """The scenario with the filter that its log supports; without one, bounds are assumed."""
    off = replace(result, assumed=(*result.assumed, *UNFOUNDED))
    if reason := _against(result, found):
        remarks.append(f"the filter is off: {reason}")
        return off
    stated = override(result, {"filter.kind": "clip"})
    try:
        settle(stated, None)
        check_filter(stated)
    except ScenarioError as error:
        remarks.append(f"the filter is off: with these numbers it is refused. {error}")
        return off
    far = found.far(result.limits.v_u1)
    if max(far) > 0:
        remarks.append(
            f"limits.v_u1 is up to {100 * max(far):.0f} % beyond the fastest motion of the log: "
            "filter.gain and filter.d are wider by what grows with speed. Drive up to the limits."
        )
    if _never_sent(stated, found.seen, peaks, remarks) or max(far) > 0:
        return replace(stated, assumed=off.assumed)
    return stated


def _against(stated: Scenario, found: Base) -> str:
    """Why no filter may rest on the log: what it does not show or explain; empty if nothing."""
    for fit, judgement, column, unit in zip(
        found.fits, found.judgements, COMMAND, UNITS, strict=True
    ):
        if fit is None or judgement is None:
            return f"{column} never changed. Drive both axes."
        if judgement.explained == NOT_EXPLAINED:
            return f"no loop that is known explains {judgement.axis}. Check the log's columns."
        least, largest = float(fit.log.sent.min()), float(fit.log.sent.max())
        if min(-least, largest) < max(-least, largest) / LEAST_BACK:
            return (
                f"{column} was from {least:.3g} to {largest:.3g} {unit}, which does not "
                "show what the base does in the other direction. Drive both ways."
            )
    vague = [
        key
        for key, item in found.estimates.items()
        if item.verdict == UNDETERMINED
        and (item.high > MOST_LATE if key[:-1] == "delay" else
             key[:-1] in ("gain", "tau", "wn") and item.high > MOST_VAGUE * item.low)
    ]  # fmt: skip
    if vague:
        return f"{', '.join(vague)} undetermined. Steps of the command show them."
    for axis, far in enumerate(found.far(stated.limits.v_u1)):
        if far > MOST_FAR - 1:
            limit, unit = stated.limits.v_u1[axis], UNITS[axis]
            seen = limit / (1 + far)
            return (
                f"the limit {limit:.3g} {unit} is more than twice the largest speed that the log "
                f"shows, {seen:.3g} {unit}. Drive faster, or state a limit of at most "
                f"{rounded_down(MOST_FAR * seen):g} {unit}."
            )
    return ""


def _never_sent(
    stated: Scenario, fits: list[LoopFit], peaks: list[PeakGain], remarks: list[str]
) -> bool:
    """Whether the log has no command near the largest that is sent, in a direction, and remarks."""
    before = len(remarks)
    rows = zip(_largest_sent(stated, peaks), fits, COMMAND, UNITS, strict=True)
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


def _hulls(estimates: Mapping[str, Estimate]) -> dict[str, Pair]:
    """Intervals of each kind of parameter that hold those of both axes."""
    names = {name[:-1] for name in estimates}
    pairs = {name: [estimates[k] for k in estimates if k[:-1] == name] for name in names}
    return {k: (min(i.low for i in v), max(i.high for i in v)) for k, v in pairs.items()}


def _of_relaxing(
    scenario: Scenario,
    loop: str,
    values: list[dict[str, float]],
    hull: Mapping[str, Pair],
    d: Pair,
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
    hull: Mapping[str, Pair],
    d: Pair,
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
