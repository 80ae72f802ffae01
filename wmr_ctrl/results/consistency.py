"""Whether somebody else's plant moves as its speeds say, and so whether its limits were kept.

Over a second or so the way ahead and the turn of the pose are compared with the sums of v1 and
omega, with room for outputs that lag by two samples, for noise and for some slip of the wheels.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from .outcomes import Outcome

if TYPE_CHECKING:
    from .run import Floats, Run

CONTRADICTS = "pose-contradicts-speed"
JUMP = "first-step-jump"
SHARE, OF_TOP, LAG, NOISE = 0.05, 0.01, 2, 5.0
"""Room: shares of the motion and of the largest speed, samples of lag, spreads of the noise."""
SECONDS, FEWEST = 1.0, 20
"""Length of a part of the run [s], and its least number of samples."""
_WORDS = (("moved at {:.3g} m/s ahead", "v1", "m/s"), ("turned at {:.3g} rad/s", "omega", "rad/s"))


def kept(run: Run) -> bool | None:
    """Whether both speeds stayed within their limits.

    None where the plant contradicts itself, or an FMU ended the run.
    """
    if contradictions(run) or run.outcome is Outcome.FAILED or not run.rows:
        return None
    return not run.monitor.violations and bool(np.isfinite(run.monitor.max_abs_v).all())


def contradictions(run: Run) -> dict[str, str]:
    """What pose and speeds of a foreign plant contradict each other in, by the remark's key."""
    if run.settings.plant_kind != "fmu" or run.rows < 2:
        return {}
    period, speed = run.settings.control, np.stack([run["v1"], run["omega"]], axis=1)
    turn = np.diff(run["psi"])
    turn -= 2 * np.pi * np.round(turn / (2 * np.pi))  # some plants keep their angles in a turn
    middle = run["psi"][:-1] + turn / 2
    dx, dy = np.diff(run["x"]), np.diff(run["y"])
    moved = np.stack([dx * np.cos(middle) + dy * np.sin(middle), turn], axis=1)
    said = period * (speed[:-1] + speed[1:]) / 2
    off = moved - said
    noise = NOISE * 1.4826 * np.median(np.abs(off - np.median(off, axis=0)), axis=0)
    top = np.max(np.abs([moved[1:] / period, said[1:] / period]), axis=(0, 1), initial=0.0)
    top = np.minimum(run.settings.v_u1, np.maximum(top, np.abs(speed).max(axis=0)))
    told = {}
    first = np.array([np.hypot(dx[0], dy[0]), abs(turn[0])]) - np.abs(said[0])
    if (first > period * top + noise).any():
        told[JUMP] = (
            f"In its first step the pose jumped by {np.hypot(dx[0], dy[0]):.3g} m and "
            f"{turn[0]:.3g} rad, more than the speeds say: the plant's outputs before that step, "
            "as the 0 of some tools, were not its state, and whether the limits were kept is not "
            "known. Let it compute them in its initialisation, and state where it starts as "
            "initial.pose and initial.velocity."
        )
        moved, said, speed = moved[1:], said[1:], speed[1:]
    return told | _apart(run, moved, said, np.abs(speed), noise + OF_TOP * top)


def _apart(run: Run, moved: Floats, said: Floats, speed: Floats, room: Floats) -> dict[str, str]:
    """The part of a run in which moves (n, 2) and what the speeds say differ by most, if too much.

    ``speed``: sizes at the n + 1 samples; ``room``: noise, and a speed that is not judged.
    """
    period, count = run.settings.control, len(moved)
    length = min(count, max(FEWEST, round(SECONDS / period)))
    if length == 0:
        return {}
    sums = (sliding_window_view(part, length, axis=0).sum(axis=-1) for part in (moved, said))
    way, sum_said = sums
    fastest = sliding_window_view(speed, length + 1, axis=0).max(axis=-1)
    larger = np.maximum(np.abs(way), np.abs(sum_said))
    allowed = SHARE * larger + LAG * period * fastest + room * max(1.0, length * period)
    beyond = (np.abs(way - sum_said) - allowed) / np.maximum(allowed, 1e-300)
    start, axis = np.unravel_index(np.nanargmax(beyond), beyond.shape)
    if not beyond[start, axis] > 0:
        return {}
    span, words = length * period, _WORDS[axis]
    begin = run.time[run.rows - 1 - count + start]
    mean, name, unit = words[0].format(way[start, axis] / span), *words[1:]
    return {
        CONTRADICTS: (
            f"From t = {begin:.4g} to {begin + span:.4g} s the pose {mean}, and {name} says "
            f"{sum_said[start, axis] / span:.3g} {unit}: whether the limits were kept is not "
            "known. Correct the map's rows and units of x, y, psi or theta and of v1, omega or "
            "w_right, w_left, and robot.r and robot.l; or the wheels slip."
        )
    }
