"""Overlap: plant steps in which the previous command may still act, wholly or in part.

With jitter in the drives, either command acts for some plant steps.  With a ramp in the firmware,
the velocity moves from one command to the next (ledger: corridor.jitter, corridor.ramp).  The model
uses a mean of both commands; its error is a share of their difference.
"""

import math
from dataclasses import dataclass

import numpy as np

from wmr_ctrl.theory.checks.error_coordinates import COMMAND, Floats
from wmr_ctrl.world.scenario import Scenario

ROOM = 1.5
"""Share of the linear loop's largest change of commands for which a ramp's plant steps are counted.
"""


@dataclass(frozen=True)
class Overlap:
    """Overlap error in each plant step after a command's arrival.

    ``share`` (n): share of the earlier command in the modelled one.  ``off`` (n, 2): largest error
    of that model, as a share of the change.  ``most`` (2): the largest change for which this is
    valid.
    """

    share: Floats
    off: Floats
    most: Floats

    @property
    def steps(self) -> int:
        """Number of plant steps."""
        return len(self.share)


ALONE = Overlap(np.zeros(0), np.zeros((0, COMMAND)), np.full(COMMAND, np.inf))
"""Each command acts at once."""


def jitter_overlap(scenario: Scenario) -> Overlap:
    """Overlap by jitter: the mean of both commands, with half of the change as error."""
    steps = int(np.floor(scenario.actuator.jitter / scenario.clock.plant + 0.5))
    return Overlap(np.full(steps, 0.5), np.full((steps, COMMAND), 0.5), np.full(COMMAND, np.inf))


def ramps(scenario: Scenario) -> bool:
    """True if the firmware limits the acceleration."""
    return bool(np.isfinite([*scenario.base.accel, *scenario.base.decel]).any())


def ramp_overlap(scenario: Scenario, changes: Floats) -> Overlap:
    """Overlap by a ramp, for changes up to slightly more than ``changes`` (2).

    In a plant step h a ramp covers at least a h, except in a step in which it stops at 0.  So at
    most D - p a h of a change D remains in the p-th step, which is D (1 - p/L) or less for D <= L a
    h.
    """
    base, clock = scenario.base, scenario.clock
    reach = clock.plant * np.minimum(base.accel, base.decel) * (1 - 1e-12)
    off, most = np.zeros((clock.substeps - 1, COMMAND)), np.full(COMMAND, np.inf)
    for i in range(COMMAND):
        if not math.isfinite(reach[i]):
            continue
        heard = base.quantum[i] + 2 * base.deadband[i]
        count = min(1 + math.ceil((ROOM * changes[i] + heard) / reach[i]), clock.substeps - 1)
        off[:count, i] = 1 - np.arange(count) / count
        most[i] = max(count * reach[i] - heard, 0.0) * (1 - 1e-12)
    steps = int(np.count_nonzero(off.any(axis=1)))
    return Overlap(np.zeros(steps), off[:steps] * (1 + 1e-15), most)
