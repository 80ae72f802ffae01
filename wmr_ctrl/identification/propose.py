"""Propose a drive that shows what a log did not, within limits and floor: random steps.

Its size follows from kinematics alone, with reserve for a loop that tracks badly.
"""

import math
from dataclasses import dataclass

import numpy as np

from wmr_ctrl.core.errors import ArgumentError

from .bounds import BaseIdentification
from .logs.log import Floats, Pair

SECONDS = 60.0
"""Length of a drive [s]."""
FADE = 2.0
"""Length of its rise and of its fall [s]."""
HELD = 1.0
"""Length of a step [s]."""
DRAWS = 40
"""Drives that are drawn; the one that strays least is proposed."""
SHARE, ROOM = 0.8, 0.9
"""Speeds of a drive over [limits] v_u1, and its farthest distance over half of the floor."""
SMALLER, TRIALS = 0.8, 12


@dataclass(frozen=True)
class ProposedDrive:
    """Speeds (N,) over t (N,) [s], and the path (N, 3) of a base that follows them.

    ``farthest`` [m] from the start and ``fastest`` [m/s, rad/s], with the largest gain that the log
    allows for.
    """

    t: Floats
    v: Floats
    omega: Floats
    path: Floats
    farthest: float
    fastest: Pair

    def to_csv(self) -> str:
        """CSV text: the reached extremes, then rows of t, v, omega and the path."""
        v, omega = self.fastest
        lines = [
            f"# at most {self.farthest:.3g} m from the start, {v:.3g} m/s, {omega:.3g} rad/s",
            "t [s],v [m/s],omega [rad/s],x [m],y [m],theta [rad]",
        ]
        table = np.column_stack((self.t, self.v, self.omega, self.path))
        return "\n".join([*lines, *(",".join(f"{x:.6g}" for x in row) for row in table), ""])


def propose(result: BaseIdentification, floor: float = 4.0) -> ProposedDrive:
    """A drive within the scenario's limits, on a floor ``floor`` metres across, starting in its
    middle.

    For a base that takes velocities it lists commands.  Raises ArgumentError if no drive fits.
    """
    if not floor > 0:
        raise ArgumentError(f"floor = {floor:g} m must be above 0.")
    gains = [result.parameters.get(f"gain{axis}") for axis in (1, 2)]
    most = np.array([item.high if item and item.high < math.inf else 1.0 for item in gains])
    t, shapes = _shapes(result.scenario.clock.control)
    wanted = shapes * SHARE * np.array(result.scenario.limits.v_u1) / most
    for _ in range(TRIALS):
        paths = [_path(t, *(item * most).T) for item in wanted]
        strays = [float(np.hypot(*path[:, :2].T).max()) for path in paths]
        best = int(np.argmin(strays))
        if strays[best] <= ROOM * floor / 2:
            v, omega = wanted[best].T
            top, turn = (np.abs(wanted[best]).max(axis=0) * most).tolist()
            return ProposedDrive(t, v, omega, paths[best], strays[best], (top, turn))
        wanted = SMALLER * wanted
    raise ArgumentError(
        f"no drive of {SECONDS:g} s stays within {floor:g} m and the limits. Give a larger --floor."
    )


def _path(t: Floats, v: Floats, omega: Floats) -> Floats:
    """Path (N, 3) x, y, theta of speeds (N,)."""
    step = np.diff(t, append=2 * t[-1] - t[-2])
    turn = np.cumsum(omega * step) - omega * step
    middle = turn + omega * step / 2
    x, y = np.cumsum(-np.sin(middle) * v * step), np.cumsum(np.cos(middle) * v * step)
    return np.column_stack((x, y, turn))


def _shapes(period: float) -> tuple[Floats, Floats]:
    """Times (N,) and random drives (DRAWS, N, 2) with maximum 1, at rest at both ends."""
    rng = np.random.default_rng(0)
    t: Floats = period * np.arange(round(SECONDS / period), dtype=np.float64)
    levels = rng.uniform(-1, 1, (DRAWS, math.ceil(SECONDS / HELD), 2))
    steps = levels[:, (t / HELD).astype(int)]
    fade = np.clip(np.minimum(t, t[-1] - t) / FADE, 0, 1)[:, None]
    return t, steps / np.abs(steps).max(axis=1, keepdims=True) * fade
