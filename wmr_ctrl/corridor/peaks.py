"""Peaks: largest deviations of the loop, a tube of them, and what is measured amiss within them.

Where no pose comes it is reckoned.  Over one sample a reckoned pose moves off a robot that it began
with by what is a row of the loop, and one that is turned by b against it by its way times b more
(ledger: corridor.reckoning).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from wmr_ctrl.checks.world import Floats
from wmr_ctrl.corridor.enclosure import upper
from wmr_ctrl.corridor.inputs import Inputs
from wmr_ctrl.corridor.loop import UP, SampledLoop

LEAST = 1e-15
"""Added to every deviation that is made larger."""


@dataclass(frozen=True)
class Peaks:
    """Largest deviations: fast state with all its rows, state at samples, outputs of the law."""

    fast: Floats
    state: Floats
    law: Floats

    @property
    def every(self) -> Floats:
        """All in one vector."""
        return np.concatenate((self.fast, self.state, self.law))

    def times(self, factor: float, more: float = LEAST) -> Peaks:
        """So many times as large, and some more."""
        return Peaks(*(part * factor + more for part in (self.fast, self.state, self.law)))

    def within(self, other: Peaks) -> bool:
        """True where no element is larger than another's."""
        return bool((self.every <= other.every).all())


@dataclass(frozen=True)
class Tube:
    """A closed box: ``position`` [m], ``heading`` [rad], and the condition that is used most.

    ``position_late`` [m]: what the position comes down to in the long run.  ``settling`` [s]: the
    time before which limits may act, 0: none does.
    """

    peaks: Peaks
    position: float
    position_late: float
    heading: float
    binding: str
    share: float
    settling: float = 0.0


def reckoned_inputs(
    loop: SampledLoop, inputs: Inputs, sizes: tuple[Floats, Floats], away: float
) -> Inputs:
    """The inputs with the errors of a pose that is reckoned for as many samples as none comes.

    ``sizes``: of e and v as measured (5), and of the linear part of what reckoning over a sample is
    off (3); ``away`` [m]: how far the robot is from its place.
    """
    measured, row = sizes
    curve, period = loop.reckoning, loop.setup.scenario.clock.control
    left = curve.remainders(np.outer(measured, measured) * UP).sum(axis=(1, 2))
    rest = np.array([upper(item) for item in curve.value()])
    rest[:2] += reference_gap(curve.at[3:], period)
    off = (row + left + rest) * UP
    v = abs(float(curve.at[3])) + float(measured[3])
    each = float(np.hypot(off[0], off[1]) + off[2] * away) * UP
    pose, turn = inputs.pose, 0.0
    for _ in range(inputs.missing):
        pose = (pose + each + period * v * turn) * UP
        turn = (turn + float(off[2])) * UP
    return replace(inputs, pose=(pose + turn * away) * UP, turn=turn)


def reference_gap(v_d: Floats, step: float) -> float:
    """Distance [m] between a circle's arc of one plant step and its sum by Simpson's rule."""
    return abs(float(v_d[0])) * float(v_d[1]) ** 4 * step**5 / 1000
