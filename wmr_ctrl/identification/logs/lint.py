"""Faults of logs, named before anything is fitted: units, signs, clocks.

Each rule raises LogError with one paragraph: what was seen, where, and what to do about it.
"""

import math

import numpy as np

from .log import POSES, Floats, Log, LogError, Pair, unit_of
from .samples import Samples, differenced, gains, interpolated, shifts_of, speeds, wheels

LEAST_MOVING = 0.2
SLOW = 0.01
"""Speed of a wheel below which it counts as standing [m/s]."""
OVER = 0.4
"""Time over which poses are compared with the wheels' turn [s]."""
TOGETHER = 0.7
"""Correlation of poses and wheels from which on they tell a ratio: a straight drive has no turn."""


def check_motion(name: str, log: Samples, half_track: float, shortest: float) -> None:
    """Check that ``shortest`` [s] of the log can be used, and that it contains motion."""
    used = 1.0 if log.use is None else log.use.all(axis=1).mean()
    span = used * (log.t[-1] - log.t[0])
    if span < shortest:
        raise LogError(f"{name}: {span:.3g} s is too short; drive for {shortest:g} s or more.")
    speed = np.abs(wheels(speeds(log), half_track)).max(axis=1)
    share = float(np.mean(speed > SLOW))
    if share < LEAST_MOVING:
        raise LogError(
            f"{name}: the robot moves in only {100 * share:.0f} % of the log (a wheel above "
            f"{100 * SLOW:g} cm/s). Drive for most of the time."
        )


def check_torques(name: str, log: Samples, half_track: float) -> None:
    """Check that wheels are not swapped, that signs agree, and that motion follows torque."""
    moved, torque = differenced(log, half_track)
    if np.std(torque(0.0), axis=0).min() < 1e-9:
        return
    shifts = shifts_of(log.period)
    shares = np.array([gains(moved, torque(shift))[0] for shift in shifts])
    best = int(np.argmax(shares))
    if shares[best] < 0.3:
        return
    gain = gains(moved, torque(shifts[best]))[1]
    own = np.diag(gain)
    if np.linalg.det(gain) < 0 and np.abs(gain).sum() > 2 * np.abs(own).sum():
        raise LogError(
            f"{name}: the right wheel follows the left torque and the left wheel the right one: "
            "torques (or counters) of the two wheels are swapped. Swap them in one of the two."
        )
    wrong = [side for side, gain in zip(("right", "left"), own, strict=True) if gain < 0]
    if wrong:
        raise LogError(
            f"{name}: the {' and the '.join(wrong)} wheel turns against its torque: the sign of "
            "that torque or of that counter is reversed. Positive torque drives forward, and "
            "counts grow forward."
        )
    check_following(name, "its torque", 1.0, shifts[best], shares[best], log.period)


def check_poses(name: str, log: Log, seen: Samples) -> None:
    """Check that poses agree with the wheels' motion in unit, sign and heading convention."""
    motions = _over(log, seen)
    if motions is None:
        return
    theta, moved, rolled = motions
    way, turn = _ratios(moved, rolled)
    _check_ratio(name, "theta", "turn", turn)
    _check_ratio(name, "x, y", "way", way)
    _check_heading(name, theta, moved, rolled[:, 0])


def pose_ratios(log: Log, seen: Samples) -> Pair | None:
    """Ratios of poses to wheels in path length and rotation; None without poses."""
    motions = _over(log, seen)
    return None if motions is None else _ratios(*motions[1:])


def _ratios(moved: Floats, rolled: Floats) -> Pair:
    """Ratios of path length and rotation; NaN if one of the two is only noise."""
    pairs = (np.hypot(*moved[:, :2].T), np.abs(rolled[:, 0])), (moved[:, 2], rolled[:, 1])
    way, turn = (
        float(a @ b / (b @ b)) if abs(a @ b) > TOGETHER * math.sqrt(a @ a * (b @ b)) else math.nan
        for a, b in pairs
    )
    return way, turn


def _over(log: Log, seen: Samples) -> tuple[Floats, Floats, Floats] | None:
    """Motion over 0.4 s each: mean theta (K,), pose change (K, 3), and the wheels' path length and
    rotation (K, 2).
    """
    names = next((item for item in POSES if log.has(item)), None)
    if names is None:
        return None
    t, pose = log.pair(names)
    pose = np.column_stack((pose[:, :2], np.unwrap(pose[:, 2])))
    way = seen.seen
    if seen.of_speed:
        way = np.cumsum(way * np.diff(seen.t, prepend=seen.t[0])[:, None], axis=0)
    begin = np.arange(max(t[0], seen.t[0]), min(t[-1], seen.t[-1]) - OVER, OVER / 2)
    if len(begin) < 20:
        return None
    first, last = (interpolated(begin + s, t, pose) for s in (0, OVER))
    before, after = (interpolated(begin + s, seen.t, way) for s in (0, OVER))
    rolled = after - before
    return (first[:, 2] + last[:, 2]) / 2, last - first, rolled


def _check_ratio(name: str, column: str, what: str, ratio: float) -> None:
    if ratio < 0:
        raise LogError(
            f"{name}: {column} turns against the wheels (ratio {ratio:.3g}): the sign of theta, or "
            "right and left of the counters, is reversed. theta grows anticlockwise."
        )
    sense = unit_of(ratio)
    if sense or not (math.isnan(ratio) or 0.5 < ratio < 2):
        raise LogError(
            f"{name}: the {what} of {column} is {ratio:.3g} times that of the wheels"
            f"{f': it looks like {sense}' if sense else ''}. Check the units of the poses, "
            "encoder.counts, robot.r and robot.l."
        )


def _check_heading(name: str, theta: Floats, moved: Floats, way: Floats) -> None:
    far = np.abs(way) > 0.02
    if far.sum() < 10:
        return
    turned = np.sign(way[far]) * np.exp(-1j * theta[far])
    step = moved[far, 0] + 1j * moved[far, 1]
    ours, swapped = (np.mean(turned * np.exp(1j * np.angle(x))) for x in (step, 1j * np.conj(step)))
    if abs(ours) < 0.8:  # mirrored: exchanged turns forward to 90 degrees, one reversed to 0 or 180
        exchanged = abs(swapped - 1j) < 0.4
        hint = (
            "x and y are exchanged"
            if exchanged
            else "x or y is reversed, or the poses are of another robot or frame"
        )
        raise LogError(
            f"{name}: poses do not move where theta points, at no fixed angle to it: it looks like "
            f"{hint}. Forward is (-sin theta, cos theta)."
        )
    angle = math.degrees(np.angle(ours))
    if abs(angle) < 20:
        raise LogError(
            f"{name}: theta is the angle to +X (REP 103), and ours is 0 along +Y. Subtract pi/2 "
            "from it, or leave the poses out."
        )
    if abs(angle - 90) > 20:
        raise LogError(
            f"{name}: the robot moves at {angle:.0f} degrees to theta, and it should be 90 "
            "(forward is (-sin theta, cos theta)). Turn the poses' frame, or the sign of the "
            "motion."
        )


def check_following(
    name: str, column: str, gain: float, shift: float, share: float, period: float
) -> None:
    """Check that a speed follows its command: in the same unit and direction, and later."""
    if share < 0.3:
        return
    if gain < 0:
        raise LogError(
            f"{name}: the speed goes against {column}: one of the two has the wrong sign, or right "
            "and left are swapped. Positive is forward, and anticlockwise."
        )
    if sense := unit_of(gain):
        raise LogError(
            f"{name}: the speed is {gain:.4g} times {column}: it looks like {sense}. Name the unit "
            "in the header, or set encoder.counts."
        )
    if share > 0.5 and shift < -max(2.5 * period, 0.03):
        raise LogError(
            f"{name}: the speed changes {-shift:.2f} s before {column}: the clocks of commands and "
            "sensors differ, or a column was shifted. Take both times from one clock, of a bag the "
            "recorder's by --topics clock=recorder."
        )
