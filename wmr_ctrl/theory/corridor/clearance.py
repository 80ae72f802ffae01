"""Clearance between a path and the obstacles, less body and corridor.

The path is sampled on a grid of times.  Between two of them it moves no farther than its speed
admits, and half of that is subtracted, so that no obstacle is missed.
"""

from dataclasses import dataclass

import numpy as np

from wmr_ctrl.core.fields.units import length
from wmr_ctrl.results.obstacles import closest
from wmr_ctrl.world.references.kind import sample
from wmr_ctrl.world.scenario import Scenario

TIMES = 20_000
"""Most times at which a path is looked at."""


@dataclass(frozen=True)
class Clearance:
    """Distance ``path`` [m] of a path from its nearest obstacle, and the part that stays free.

    Obstacle number ``obstacle``, from 1, is nearest at ``time`` [s].  ``free`` [m]: distance less
    the body (``radius`` [m] about the axle's midpoint) and the law's corridor; None without a
    corridor that is valid from a run's first command; below 0 the obstacle may be touched.
    """

    path: float
    obstacle: int
    time: float
    radius: float
    free: float | None

    @property
    def sentence(self) -> str:
        """One-sentence summary."""
        place = f"obstacle {self.obstacle}, at t = {self.time:.4g} s"
        if self.path < 0:
            return f"clearance: none, the path leads through {place}"
        near = (
            f"clearance: the path comes within {length(self.path)} of {place}, the body "
            f"takes {length(self.radius)} of it"
        )
        if self.path < self.radius:
            return f"{near}, more than there is: a robot that never left its path would touch it"
        if self.free is None:
            return f"{near}; without a corridor of the run nothing is promised of the rest"
        if self.free < 0:
            return f"{near}, the corridor all of the rest: pushes may bring the body there"
        free = length(self.free, up=False)
        return f"{near}; as long as the corridor holds, at least {free} stay free"


def find_clearance(scenario: Scenario, corridor: float | None) -> Clearance | None:
    """The Clearance of a scenario whose law keeps within ``corridor`` [m] of its path.

    None without obstacles.
    """
    obstacles, radius = scenario.obstacles, scenario.body.radius
    if not obstacles or radius is None:
        return None
    end = scenario.clock.duration
    times = np.linspace(0.0, end, min(TIMES, round(end / scenario.clock.plant)) + 1)
    motion = sample(scenario, times)
    slack = np.abs(motion[:, 3]).max() * (times[1] - times[0]) / 2
    away, place, k = closest(obstacles, motion[:, :2])
    path = float(away - slack)
    free = None if corridor is None else float(path - radius - corridor)
    return Clearance(path, place + 1, float(times[k]), radius, free)
