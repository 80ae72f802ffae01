"""The guard behind drives with a delay: what is under way cannot be called back.

A command that is computed now acts only after the delay.  Until then the commands F_j that were
sent before it act, each for another tau_j, together for the delay.  By the time the new one takes
over, v can have risen, and -v can have risen, by at most

    ahead = sum tau_j max(F_j + net, 0)/M_min,      back = sum tau_j max(net - F_j, 0)/M_min,

with net = dbar - f_min, and the guard counts that as speed: its room is v_u1 - max(y + nbar,
f_speed) - ahead.  So that the room ahead and the room behind never run out together, no command
may be larger than

    largest = (M_min (v_u1 - f_speed) - max(brake + net, 0)/alpha)/delay - net.

Since a braking command is not counted in favour, all this stays true for every constant delay that
is shorter than the stated one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca

if TYPE_CHECKING:
    from wmr_ctrl.guard.guard import Bounds


@dataclass(frozen=True)
class UnderWay:
    """What one axis' commands under way can add to v (ahead) and to -v (back) [m/s or rad/s]."""

    ahead: ca.SX
    back: ca.SX

    @property
    def mirrored(self) -> UnderWay:
        """The same seen in the other direction."""
        return UnderWay(self.back, self.ahead)


def under_way(sent: Sequence[tuple[ca.SX, ca.SX | float]], axis: int, b: Bounds) -> UnderWay:
    """Of forces (2,) [N, N m] with the periods that each will act from now on."""
    ahead, back = ca.SX(0), ca.SX(0)
    for force, periods in sent:
        ahead += periods * ca.fmax(force[axis] + b.net, 0)
        back += periods * ca.fmax(b.net - force[axis], 0)
    return UnderWay(ahead * b.period / b.M_min, back * b.period / b.M_min)


def largest_force(b: Bounds) -> ca.SX:
    """Of one axis, behind a delay [N or N m]; at least what it brakes with."""
    assert b.delay is not None
    held_back = ca.fmax(b.braking + b.net, 0) / b.alpha
    return (b.M_min * (b.u1 - b.f_speed) - held_back) / b.delay - b.net
