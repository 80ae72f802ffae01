"""Consistency of a foreign plant's motion with its speeds, and so whether its limits were kept.

Over about a second the pose's path ahead and rotation are compared with the sums of v1 and omega,
with tolerances for outputs that lag by some samples, for noise and for some wheel slip.
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
SHARE = 0.05
"""Allowed deviation as a share of the motion."""
OF_TOP = 0.01
"""Allowed deviation as a share of the largest speed."""
LAG = 3
"""Allowed lag in samples."""
NOISE = 5.0
"""Allowed deviation in spreads of the noise."""
SECONDS = 1.0
"""Length of a part of the run [s]."""
FEWEST = 20
"""Least number of samples of a part."""
_WORDS = (("moved ahead at", "v1", "m/s"), ("turned at", "omega", "rad/s"))


def kept(run: Run) -> bool | None:
    """True if both speeds stayed within their limits.

    None if the plant's pose and speeds contradict each other, or an FMU ended the run.
    """
    if contradictions(run) or run.outcome is Outcome.FAILED or not run.rows:
        return None
    return not run.monitor.violations and bool(np.isfinite(run.monitor.max_abs_v).all())


def contradictions(run: Run) -> dict[str, str]:
    """Contradictions between pose and speeds of a foreign plant, by the remark's key."""
    if run.settings.plant_kind != "fmu" or run.rows < 2:
        return {}
    period, told = run.settings.control, {}
    speed = np.stack([run["v1"], run["omega"]], axis=1)
    place = np.stack([run["x"], run["y"], np.unwrap(run["psi"])])
    dx, dy, turn = np.diff(place)
    middle = place[2, :-1] + turn / 2
    moved = np.stack([dx * np.cos(middle) + dy * np.sin(middle), turn], axis=1)
    said = period * (speed[:-1] + speed[1:]) / 2
    off = moved - said
    noise = NOISE * 1.4826 * np.median(np.abs(off - np.median(off, axis=0)), axis=0)
    top = np.abs(np.concatenate([moved[1:] / period, speed])).max(axis=0)
    top = np.minimum(run.settings.v_u1, top)
    jump = np.hypot(dx[0], dy[0]), abs(turn[0])
    if (jump - np.abs(said[0]) > period * top + noise).any():
        told[JUMP] = (
            f"In its first step the pose jumped by {jump[0]:.3g} m and {jump[1]:.3g} rad, more "
            "than the speeds say: the plant's outputs before that step, as the 0 of some tools, "
            "were not its state, and whether the limits were kept is not known. Let it compute "
            "them in its initialisation, and state its start as initial.pose and initial.velocity."
        )
        moved, said, speed = moved[1:], said[1:], speed[1:]
    return told | _apart(run, moved, said, speed, noise + OF_TOP * top)


def _apart(run: Run, moved: Floats, said: Floats, speed: Floats, room: Floats) -> dict[str, str]:
    """Part of a run in which the moves (n, 2) most exceed what the speeds explain, if any.

    ``speed``: at the n + 1 samples; ``room``: tolerance for noise, and a speed that is not judged.
    """
    period, count = run.settings.control, len(moved)
    length = min(count, max(FEWEST, round(SECONDS / period)))
    if length == 0:
        return {}
    span = length * period
    way, words = (sliding_window_view(p, length, axis=0).sum(axis=-1) for p in (moved, said))
    shift = np.abs(speed[length:] - speed[:-length])
    allowed = SHARE * np.maximum(np.abs(way), np.abs(words)) + LAG * period * shift
    allowed += room * max(1.0, span) + 1e-12
    beyond = np.abs(way - words) / allowed
    start, axis = np.unravel_index(np.nanargmax(beyond), beyond.shape)
    if not beyond[start, axis] > 1:
        return {}
    does, name, unit = _WORDS[axis]
    begin = run.time[run.rows - 1 - count + start]
    return {
        CONTRADICTS: (
            f"From t = {begin:.4g} to {begin + span:.4g} s the pose {does} "
            f"{way[start, axis] / span:.3g} {unit}, and {name} says "
            f"{words[start, axis] / span:.3g} {unit}: whether the limits were kept is not known. "
            "Correct the map's rows and units of x, y, psi or theta and of v1, omega or w_right, "
            "w_left, and robot.r and robot.l; or the wheels slip."
        )
    }
