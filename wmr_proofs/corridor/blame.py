"""Name the term of a plant step that grows as large as the loop's correction."""

from contextlib import suppress

import numpy as np

from wmr_ctrl.theory.checks.error_coordinates import COMMAND, ROBOT, Floats

from .along import Along
from .enclosure import OpenBoxError
from .inputs import product
from .midradius import MidRadius

PARTS = (1.0, 0.8, 0.6, 0.4, 0.2, 0.0)
"""Of a box on which it is looked which term grows."""


def blamed(along: Along, reach: Floats, k: int) -> str:
    """Sentence on the product of two errors with the largest share of a plant step's remainder."""
    curve, nz = along.loop.step_curve, len(along.loop.names)
    bends = _bends_near(along, reach, k)
    row, i, j = curve.bends.T
    inside = (row < nz) & (i < ROBOT) & (j < ROBOT)
    row, i, j, bends = row[inside], i[inside], j[inside], bends[inside]
    own = np.maximum(reach[row], np.finfo(float).tiny)  # where nothing is off
    worst = (bends * reach[i] * reach[j] / own).argmax()
    pair = i[worst], j[worst]
    term, turns = product(*pair), pair == (ROBOT - COMMAND, ROBOT - COMMAND)
    why = ", since friction turns near standstill," if turns else ""
    far = f" beyond {d:.3g} mm" if np.isfinite(d := 1e3 * np.hypot(reach[0], reach[1])) else ""
    return f"{term} may grow as large as what the loop corrects{why}{far} {along.place(k)}"


def _bends_near(along: Along, reach: Floats, k: int) -> Floats:
    """Second derivatives of a plant step, on the largest scaled box for which they are bounded."""
    by, numbers = along.step_range(k, k + 1)
    wide, nz = np.zeros(by.middle.shape), len(along.loop.names)
    for share in PARTS:
        wide[:nz] = share * reach[:nz]
        with suppress(OpenBoxError):
            return along.loop.step_curve.bend(MidRadius(by.middle, wide), numbers)
    return np.ones(len(along.loop.step_curve.bends))
