"""Remarks on a finished run for its user, each with a key, numbers and a remedy.

Thresholds and reasons: docs/verdicts.md, whose labelled runs test them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from wmr_ctrl.core.fields.units import length

from . import measures
from .consistency import CONTRADICTS, JUMP, contradictions
from .obstacles import nearest
from .oscillation import fast_swing_rms, oscillation
from .outcomes import Outcome, beyond_bounds
from .settings import TIGHTER
from .windows import at_rest, drive, driving, rows_of, working

if TYPE_CHECKING:
    from .run import Run

HELD_BACK = 0.25
"""Share of the drive's samples from which guard, filter or base hold a run back."""
NEAR_BY = 8192
"""Bit of filter_flags: something is too near for any command except one away from it."""
SATURATED = 0.2
"""Share of the samples with a wheel at its torque limit from which drives are too weak."""
CHATTER, OF_LIMIT, OF_PEAK = 1.0, 0.1, 1e-3
"""Swing or change from sample to sample of torque that is too much: more than this multiple of the
torque that the motion needs and of that which pushes the wheels, and than these shares of the limit
and of the run's largest torque: without friction a motion may need none.
"""
BURST = 1.5
"""Multiple of the same for a part of the window."""
PARTS = 10
"""Number of such parts; halves of them overlap."""
FEWEST = 32
"""Least number of samples of a part."""
NEAR = 0.9
"""Share of the speed at which a law's barrier begins, from which a desired one is close to it."""
STILL = 1e-9
"""Speed [m/s, rad/s] by which a desired one is beyond a limit through rounding alone."""
SWAY = 0.2
"""RMS of a velocity about the desired one, as a share of its limit, that is no steady drive."""
BASE_CAUSES = ("dead-band", "wheel-limit", "quantum", "ramps", "losses")
"""Keys of what a base that takes velocities makes of commands."""
OBJECTED = "objected"
"""Key of what `wmr-ctrl check` objects to."""
NOT_CHECKED = "not-checked"
"""Remark key: theory was not evaluated, because it takes more work than a verdict may."""
SHORT = {
    "not-tracked": "it did not track",
    "goal-not-reached": "it did not reach its goal",
    "too-fast": "it was asked to exceed its limits",
    "oscillates": "it oscillates",
    "chatter": "its torques chatter",
    "saturated": "its wheels are at their torque limit",
    "guard-holds-back": "the guard holds it back",
    "filter-holds-back": "the filter holds it back",
    "dead-band": "the base's dead band stops it",
    "wheel-limit": "its wheels are at their speed limit",
    "quantum": "its commands are rounded to 0",
    "ramps": "the base ramps its commands",
    "losses": "its commands are lost",
    "obstacle": "it touched an obstacle",
    "corridor-left": "it left its certified corridor",
    "exact-pose": "its pose was exact",
    CONTRADICTS: "its pose contradicts its speeds",
    JUMP: "its pose jumped in the first step",
    OBJECTED: "theory objects",
    NOT_CHECKED: "its stability was not checked",
    "assumption-void": "an assumption of the guarantee is void",
}
"""Remarks in a few words, by key; the other keys are what the outcome says."""
CALMER = "Lower the law's gains, or shorten clock.control and the drives' delay."


@dataclass(frozen=True)
class Remark:
    """One finding: a key for scripts, and a text with the fault, its size and the remedy."""

    key: str
    text: str


ROUNDED = 1e-9
"""Torque [N m] that is rounding alone."""


def percent(share: float) -> str:
    """A share such as "12.3 %": three digits, without an exponent from 1 % on."""
    return f"{float(f'{100 * share:.3g}'):g} %"


def speeds(pair: Sequence[float]) -> str:
    """Speeds of both axes, such as "0.98 m/s, 1.4 rad/s"."""
    return f"{pair[0]:.3g} m/s, {pair[1]:.3g} rad/s"


def remarks_on(run: Run) -> tuple[Remark, ...]:
    """All remarks on a run; empty only if all is well."""
    others = (Remark(key, text) for key, part in _PARTS.items() for text in part(run))
    apart = (Remark(key, text) for key, text in contradictions(run).items())
    return (*_outcome(run), *apart, *others)


def in_short(remarks: tuple[Remark, ...]) -> str:
    """Remarks beyond the outcome, in short, as "it did not track and its torques oscillate"."""
    *head, last = dict.fromkeys(SHORT[item.key] for item in remarks if item.key in SHORT)
    return f"{', '.join(head)} and {last}" if head else last


def _outcome(run: Run) -> Iterator[Remark]:
    monitor, seen = run.monitor, run.monitor.rigid
    if monitor.violations:
        yield _sentence(Outcome.LIMIT_VIOLATED, run)
    if seen and seen.tipped is not None:
        yield _sentence(Outcome.TIPPED, run)
    if seen and seen.slipped is not None:
        yield Remark(
            Outcome.SLIPPED.value,
            f"From t = {seen.slipped:.6g} s on the wheels slipped over the ground, by at most "
            f"{seen.max_slip:.3g} m/s; laws and guard assume that they grip. Limit the wheel "
            "torques: `wmr-ctrl check` names the largest one without spin.",
        )
    if run.guard and monitor.bounds_left:
        alone = run.outcome is Outcome.BOUNDS_LEFT
        text = run.outcome.sentence(monitor, run.guard) if alone else beyond_bounds(monitor)
        yield Remark(Outcome.BOUNDS_LEFT.value, text)


def _sentence(outcome: Outcome, run: Run) -> Remark:
    return Remark(outcome.value, outcome.sentence(run.monitor, run.guard))


def _not_tracked(run: Run) -> Iterator[str]:
    if measures.tracked(run) is not False:
        return
    parts = [
        f"{part['position_rms']:.3g} m RMS (at most {part['position_max']:.3g} m) in the {place}"
        for place, part in zip((driving(run), "end"), measures.tracking(run).values(), strict=True)
        if part is not None and part["position_rms"] is not None
    ]
    if not parts:
        yield "The run ended before the part that is judged was over."
        return
    yield (
        f"The robot was off its desired position by {' and '.join(parts)}; metrics.tolerance is "
        f"{run.settings.tolerance:g} m. See the other remarks and `wmr-ctrl check` for the cause, "
        "choose another law or gains, ask for a slower reference, or raise the tolerance if this "
        "is good enough."
    )


def _too_fast(run: Run) -> Iterator[str]:
    axes = zip(("v1_d", "v2_d"), ("m/s", "rad/s"), run.settings.sides, strict=True)
    for name, unit, (least, most) in axes:
        beyond = np.maximum(run[name] - most, least - run[name])
        if np.max(beyond, initial=0.0) > STILL:
            asked = float(run[name][np.argmax(beyond)])
            limit = most if asked > 0 else least
            yield (
                f"The desired motion reaches {name} = {asked:.4g} {unit}, beyond the limit of "
                f"{limit:g} {unit}: no law is allowed to follow it. Ask for a slower reference."
            )


def _not_arrived(run: Run) -> Iterator[str]:
    times, settings = measures.arrival(run), run.settings
    if times is None or settings.arrival is None or times["robot"] is not None:
        return
    if settings.samples <= settings.index(settings.arrival):
        yield (
            f"The desired motion comes to rest at its goal at t = {settings.arrival:.4g} s, and "
            f"the run of {settings.duration:g} s has no sample from then on. Lengthen "
            "clock.duration."
        )
    elif settings.tolerance is not None and run.rows:
        away = float(np.hypot(run["x"][-1] - run["x_d"][-1], run["y"][-1] - run["y_d"][-1]))
        remedy = (
            "At rest a sideways error is not corrected: slow down the end of the path "
            "(reference.a_max), or use a law that tracks more closely."
        )
        if run.outlook is not None and run.outlook.causes:
            remedy = "See the other remarks for the cause."
        yield (
            f"At the end the robot was {away:.3g} m from the goal; metrics.tolerance is "
            f"{settings.tolerance:g} m. {remedy}"
        )


def _touched(run: Run) -> Iterator[str]:
    near = nearest(run)
    if near is not None and near[0] < 0:
        gap, place, time = near
        yield (
            f"At t = {time:.4g} s the body reached {-gap:.3g} m into obstacle {place}. Move the "
            "path away from it, start closer to the path, or let a filter stop the robot "
            "(filter.free_error)."
        )


def _left_corridor(run: Run) -> Iterator[str]:
    if run.corridor_left is not None:
        yield run.corridor_left.sentence


def _oscillates(run: Run) -> Iterator[str]:
    cycle = oscillation(run)
    if cycle is not None:
        what = "The wheel torques swing" if cycle.unit == "N m" else f"{cycle.quantity} swings"
        yield (
            f"{what} by {cycle.swing:.3g} {cycle.unit} peak to peak at {cycle.frequency:.3g} Hz, "
            f"{1 / cycle.frequency / run.settings.control:.3g} samples a period: a limit cycle, or "
            f"a loop that is close to one. {CALMER}"
        )
        return
    shares = measures.velocity_sway(run) or (0.0, 0.0)
    for name, share in zip(("v1", "omega"), shares, strict=True):
        if share > SWAY:
            yield (
                f"{name} swings about its desired value by {percent(share)} of its limit (RMS), "
                f"more than {percent(SWAY)}: the robot does not drive steadily. {CALMER}"
            )
            return


def _chatters(run: Run) -> Iterator[str]:
    needed, outlook, torque = measures.torque_needed_rms(run), run.outlook, measures.torques(run)
    if needed is None or run.needed is None or outlook is None:
        return
    limit = outlook.tau_max if np.isfinite(outlook.tau_max) else 0.0
    pushed = float(np.sqrt(np.mean(run["noise_right"] ** 2 + run["noise_left"] ** 2) / 2))
    peak = OF_PEAK * float(np.abs(torque).max())
    allowed = max(CHATTER * needed, CHATTER * pushed, OF_LIMIT * limit, peak, ROUNDED)
    windows = (rows_of(run, part(run.settings)) for part in (working, at_rest))
    judged = [rows for rows in windows if rows is not None]
    extra, period = torque - run.needed, run.settings.control

    def moved(rows: slice) -> tuple[float, float]:
        return measures.change_rms(torque, rows), fast_swing_rms(extra[rows], period)

    change, swing = np.max([*map(moved, judged), (0.0, 0.0)], axis=0)
    those, parts = "The", [part for rows in judged for part in _parts(rows)]
    if max(change, swing) <= allowed and parts:
        (change, swing), rows = max(
            zip(map(moved, parts), parts, strict=True), key=lambda item: max(item[0])
        )
        first, end = run.time[rows.start], run.time[rows.stop - 1]
        those, allowed = f"From {first:.4g} to {end:.4g} s the", BURST * allowed
    if max(change, swing) > allowed:
        movers, first = _movers(run, outlook.barrier)
        yield (
            f"{those} wheel torques change by {change:.3g} N m RMS from "
            f"sample to sample and swing by {swing:.3g} N m RMS, where the desired motion needs "
            f"{needed:.3g} N m RMS in all: {movers} move them, not the motion. {first} the law's "
            "gains, or measure better (finer encoders, a longer encoder.window or "
            "sensor.velocity_window)."
        )


def _movers(run: Run, barrier: tuple[float, float] | None) -> tuple[str, str]:
    """Causes of torques that the motion does not need, and the beginning of the remedies."""
    for axis, name, unit in ((0, "v1_d", "m/s"), (1, "v2_d", "rad/s")):
        asked = float(np.max(np.abs(run[name]), initial=0.0))
        if barrier is not None and asked > NEAR * barrier[axis]:
            begins = f"limits.v_u2[{axis + 1}] = {barrier[axis]:g} {unit}"
            close = f"to which the desired {asked:.3g} {unit} is close"
            return "noise, gains or the barrier", f"Raise {begins}, {close}, lower"
    return "noise and gains", "Lower"


def _parts(window: slice) -> Iterator[slice]:
    size = max((window.stop - window.start) // PARTS, FEWEST)
    for first in range(window.start, window.stop - size + 1, size // 2):
        yield slice(first, first + size)


def _saturated(run: Run) -> Iterator[str]:
    share, outlook = measures.saturated_share(run), run.outlook
    if share is not None and outlook is not None and share > SATURATED:
        yield (
            f"A wheel is at its torque limit of {outlook.tau_max:.4g} N m in {percent(share)} of "
            "the samples: the law's torque is not delivered. Lower the law's gains, raise "
            "actuator.tau_max, or ask for a slower or smoother reference."
        )


def _exact_pose(run: Run) -> Iterator[str]:
    if run.outlook is not None and run.outlook.exact_pose:
        yield (
            "The encoders give only velocities, and the law saw the true pose at every sample: "
            "position errors of this run are smaller than those of a real robot. State its pose "
            "sensor: sensor.pose_noise, pose_period, pose_delay."
        )


def _objected(run: Run) -> Iterator[str]:
    for item in run.outlook.objections if run.outlook is not None else ():
        yield f"`wmr-ctrl check` objects, even if this run went well: {item}"


def _not_checked(run: Run) -> Iterator[str]:
    for item in run.outlook.warnings if run.outlook is not None else ():
        if item.key == NOT_CHECKED:
            yield item.sentence


def _held_back(run: Run) -> Iterator[str]:
    shares = measures.guard_share(run, drive(run.settings))
    if shares is not None and max(shares) >= HELD_BACK:
        thrust, moment = map(percent, shares)
        yield (
            f"In the {driving(run)} the guard changed the thrust in {thrust} and the moment in "
            f"{moment} of the samples: the law demands more than the limits minus the guard's "
            f"reserve. Ask for a slower reference, shorten clock.control (raise guard.alpha, where "
            f"it is stated), or {TIGHTER}."
        )


def _filtered(run: Run) -> Iterator[str]:
    shares = measures.filter_share(run, drive(run.settings))
    if "filter_flags" not in run or np.mean(run["filter_flags"] % 2) < HELD_BACK:
        return  # bit 1: limited; filter.least changes commands, too, and holds nothing back
    if shares is not None and max(shares) >= HELD_BACK:
        near, flags = nearest(run), run["filter_flags"][slice(*drive(run.settings))]
        if near is not None and np.mean(flags // NEAR_BY % 2) >= HELD_BACK:
            yield (
                f"The filter stopped the robot {length(near[0])} before obstacle {near[1]}: "
                "something is in the way. Move the path away from it."
            )
            return
        v, omega = map(percent, shares)
        yield (
            f"In the {driving(run)} the filter changed v in {v} and omega in {omega} of the "
            "samples: the law asks for more than it lets pass. Ask for a slower reference, lower "
            "the law's gains, or state narrower bounds in [filter] if they are true."
        )


def _caused(run: Run, key: str) -> Iterator[str]:
    """Remarks on effects of the base on the commands of a run that missed its path or goal."""
    causes = run.outlook.causes if run.outlook is not None else {}
    if key in causes and any((*_not_tracked(run), *_not_arrived(run))):
        yield causes[key]


def _void(run: Run) -> Iterator[str]:
    late = run.provenance.get("master") == "jacobi" and "v_command" in run.columns
    if (run.guard or late) and run.settings.void:
        yield run.settings.void


_PARTS: Mapping[str, Callable[[Run], Iterator[str]]] = {
    "not-tracked": _not_tracked,
    "goal-not-reached": _not_arrived,
    "obstacle": _touched,
    "corridor-left": _left_corridor,
    "too-fast": _too_fast,
    "oscillates": _oscillates,
    "chatter": _chatters,
    "saturated": _saturated,
    "guard-holds-back": _held_back,
    "filter-holds-back": _filtered,
    **{key: partial(_caused, key=key) for key in BASE_CAUSES},
    "exact-pose": _exact_pose,
    "assumption-void": _void,
    OBJECTED: _objected,
    NOT_CHECKED: _not_checked,
}
"""Texts of the remarks by key, but for those on the outcome."""
